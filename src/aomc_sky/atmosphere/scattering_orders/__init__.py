"""Light scattered more than once, by successive orders in columns.

diffuse             What is asked for: orders of a medium, or of flat layers, in some zenith angles
solver              Columns of all wavelengths solved and looked into from the ground: radiances by order
orders              Successive orders in one column, all Fourier modes of the azimuth at once, and their rest
source_function     What the air scatters at its altitudes: the source functions between the orders
angular_resolution  How many angles, depths and Legendre moments the orders need
columns             The columns of a task with the paths of light through them: flat layers, or shells
slab                One column: elements in optical depth, nodes inside them; of flat layers, or of a medium
shell_paths         Straight paths through spherical shells as weights on the source function
formal_solution     The radiance along straight paths as weights on the source function
"""
