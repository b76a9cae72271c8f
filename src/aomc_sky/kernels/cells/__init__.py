"""Cells of a band: order of photons, parameters, laws.

order   The keyed order of photons: a bijection on [0, N), so that every prefix of a run is a fair sample
laws    The laws inside a cell: six parameters and two uniform numbers become a travel direction
columns The parameters of many cells as columns
blocks  From a rank to the parameters of a cell, on the way to the photons of a block, compiled
"""
