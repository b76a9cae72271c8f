"""Photons of a band.

emit   Photon i of a band, for i in [start, stop): rank, slot, position in the cell, travel direction; compiled
plain  The same in plain numpy, equal to the bit: for small jobs, which numba's start-up would slow down
"""
