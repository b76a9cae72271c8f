"""Photons of a band.

emit       Photon i of a band, for i in [start, stop): rank, slot, place in the cell, travel direction
runs       Emission in the order of the cells, run by run: the parameters of a cell stay in registers
plain      The emission in plain numpy, equal to the bit: for small jobs, which numba's start-up would slow down
positions  Where photons enter the surface: uniform over a circle or a rectangle, from a stream of their own
"""
