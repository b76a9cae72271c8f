"""Batches of photons after their emission: sums in a fixed order, and MCPL records.

plain     In plain numpy
compiled  The same compiled, equal to the bit
"""
