"""Photons of a band.

emit      Photon i of a band, for i in [start, stop): rank, slot, position in the cell, travel direction; compiled
plain     The same in plain numpy, equal to the bit: for small jobs, which numba's start-up would slow down
hooks     One text of a kernel for every plan, and the slices that it calls where the plan needs them
hosts/    Photons inside another code's own loop
batches/  Batches of photons after their emission: sums, and MCPL records
"""
