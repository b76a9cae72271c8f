"""MCPL files (Monte Carlo Particle Lists, formats 2 and 3).

file    `read_mcpl`: the head at once, the particles block by block; stored as they are or packed by gzip.
header  The head: what it says, of the runs of ours too; its bytes, and reading one that somebody may have broken.
"""
