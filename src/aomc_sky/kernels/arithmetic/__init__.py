"""Arithmetic that gives the same bits on every machine, and the random numbers.

constants   Numbers that the jitted kernels and their plain numpy form share; importing this costs nothing
rng         Philox4x32-10, addressed by counter (Salmon et al. 2011, known answers in tests/golden)
elementary  Our own elementary functions: + - x / sqrt and integers only, so that every machine gives the same bits
logarithm   The logarithm's series: + - x / alone, for arrays, and for `elementary` to compile
plain       Random words and elementary functions over arrays, in plain numpy, equal to the bit
error_free  What the rounding of a sum and of a product left out
prefetch    Hints to the processor which memory is wanted soon; no effect on any result
"""
