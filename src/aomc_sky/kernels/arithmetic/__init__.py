"""Arithmetic that gives the same bits on every machine, and the random numbers.

constants   Numbers that many kernels and those who fill their tables share
rng         Philox4x32-10, addressed by counter, for arrays and kernels
net         A scrambled digital net over the ranks of a band: uniform numbers that never beat with the directions
elementary  Our own elementary functions: + - x / sqrt and integers only, so that every machine gives the same bits
error_free  What the rounding of a sum and of a product left out
prefetch    Hints to the processor which memory is needed soon; no effect on any result
"""
