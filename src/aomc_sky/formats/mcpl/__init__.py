"""MCPL files (Monte Carlo Particle Lists, formats 2 and 3).

file    `read_mcpl`: a look at head and length, then the particles block by block, by the package `mcpl`.
header  The head: what it says, of the runs of ours too, and its bytes.
"""
