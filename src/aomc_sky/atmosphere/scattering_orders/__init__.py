"""Light scattered more than once, by successive orders in columns.

angular_resolution  How many angles, depths and Legendre moments the orders of scattering need
columns             The columns of a task with the paths of light through them: flat layers, or the shells of a medium
diffuse             The diffuse light of a clear sky at the ground by successive orders of scattering
formal_solution     The radiance along straight paths through a column as weights on its source function
geometric_rest      What the orders of scattering after the last one worked out would add
ground_light        The light that successive orders of scattering bring to the ground: what their solver returns
orders              Successive orders of scattering in a plane column, all Fourier modes of the azimuth at once
shell_paths         Straight paths through spherical shells as weights on the source function of a column
slab                A plane-parallel column as the solver of scattering orders sees it: elements in optical depth, ...
slab_medium         Columns of a medium, one for each wavelength, on altitudes that all wavelengths share
solver              Columns of all wavelengths solved one after the other, and looked into from the ground
source_function     What the air scatters at its altitudes: the source functions between the orders of scattering
"""
