"""MCPL files (Monte Carlo Particle Lists, formats 2 and 3).

file     `read_mcpl`: the head at once, the particles block by block; stored as they are or packed by gzip.
header   The head: what it says, its bytes, and reading one that somebody may have broken.
records  The records: energies and directions as they are packed, and what is no particle.
runs     What a head says of the runs of ours in it, in words in which files may differ and still be merged.
"""
