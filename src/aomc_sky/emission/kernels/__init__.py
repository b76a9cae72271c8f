"""Photons of a band.

emit      Photon i of a band, for i in [start, stop): rank, slot, position in the cell, travel direction; compiled
numbers   Further coordinates that a photon carries for its host
batches   Sums over the photons of a batch, and their MCPL records
plain     All of these in plain numpy, equal to the bit: for small jobs, which numba's start-up would slow down
hooks     One text of a kernel for every plan, and the slices that it calls
sampler   One photon at a time, for a transport code that asks by index
next_photons  The function that delivers a range of photons of a band to numba's `fill`: `emit` behind an address
"""
