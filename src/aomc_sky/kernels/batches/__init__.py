"""Batches of photons after their emission: sums, and MCPL records.

mcpl_pack         Directions of photons packed into MCPL records (adaptive projection), equal to libmcpl to the bit
plain_mcpl        The packing of `mcpl_pack` in plain numpy, equal to the bit, for small jobs
plain_statistics  The sums of `statistics` in plain numpy, equal to the bit
statistics        Sums over the photons of a block in a fixed order, so that every machine prints the same digits
tally             Sums that a benchmark takes over a batch: moments of the cosine, a cone, a ring, a histogram of ...
"""
