"""MCPL files (Monte Carlo Particle Lists, formats 2 and 3).

file    `read_mcpl`: head and particles as the package `mcpl` reads them, and a check of the length.
header  The head: its fields, its bytes, and the comments of our runs.
"""
