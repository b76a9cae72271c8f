"""Photons of a band.

emit      Photon i of a band, for i in [start, stop): rank, slot, position in the cell, travel direction; compiled
numbers   Further coordinates that a photon carries for its host
batches   Sums over the photons of a batch, and their MCPL records
plain     All of these in plain numpy, equal to the bit: for small jobs, which numba's start-up would slow down
hooks     One text of a kernel for every plan, and the slices that it calls
sampler   Photons for a transport code: one by its index, or a range of them for `fill` of numba
"""
