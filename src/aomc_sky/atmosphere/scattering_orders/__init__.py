"""Light scattered more than once, by successive orders in columns.

diffuse   What is asked for: orders of a medium or of flat layers in some zenith angles, and source functions
solver    How finely columns are cut; columns of all wavelengths solved and looked into from the ground
orders    Successive orders in one column, all Fourier modes of the azimuth at once, and their rest
paths     Straight paths through flat layers or shells as weights on the source function
slab      One column: elements in optical depth, nodes inside them; of flat layers, or of a medium
legendre  Phase functions as series of Legendre functions: one Fourier mode at a time; nodes of a hemisphere
"""
