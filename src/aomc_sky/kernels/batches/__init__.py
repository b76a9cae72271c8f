"""Batches of photons after their emission: sums, and MCPL records.

statistics        Sums over the photons of a block in a fixed order, so that every machine prints the same digits
plain_statistics  `statistics` in plain numpy, equal to the bit
mcpl_pack         Directions packed into MCPL records (adaptive projection), equal to libmcpl to the bit
plain_mcpl        `mcpl_pack` in plain numpy, equal to the bit, for small jobs
tally             Sums of a benchmark: moments of the cosine, a cone, a ring, a histogram of directions
"""
