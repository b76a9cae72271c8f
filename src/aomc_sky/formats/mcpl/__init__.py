"""MCPL files (Monte Carlo Particle Lists, formats 2 and 3).

file    `read_mcpl`: checks of head and length, then the particles block by block, by the package `mcpl`.
header  The head: its fields, its bytes, and the comments of our runs.
"""
