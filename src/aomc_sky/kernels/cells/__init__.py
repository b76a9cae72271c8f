"""Cells of a band: who is where in them, their order, and the laws of patches.

order       The keyed order of photons: a bijection on [0, N), so that every prefix of a run is a fair sample
slots       From a rank to the slot that holds it: a guide table, then at most a few steps
parameters  Cell parameters on their way to the photons: a ring's and a column's, four floats each
laws        The laws inside a cell: six parameters and two uniform numbers become a travel direction
plain       Order, cells and laws of a block of photons in plain numpy, equal to the bit
"""
