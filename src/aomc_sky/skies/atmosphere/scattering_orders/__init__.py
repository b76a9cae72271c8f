"""Light scattered more than once, by successive orders in columns.

diffuse  Orders of a medium in some zenith angles: resolution, solution, source functions
orders   Successive orders in one column, all Fourier modes of the azimuth at once: Legendre series, orders, their rest
paths    Straight paths through shells as weights on the source function
slab     One column: elements in optical depth, nodes inside them
"""
