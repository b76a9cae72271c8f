"""Basis of all jitted functions, which are in folders of this name: numbers and arrays, no file, no option.

backend       The choice between plain numpy and compiled kernels
formula       One text of a formula for both backends: numpy calls it with arrays, kernels compile it for one photon
jit           The only decorators of the package's kernels: strict IEEE, no GIL, noalias, and a cache
numba_private Private names of numba: the pipeline with noalias, and the cache
arguments     Arguments behind an address, for hosts
arithmetic/   Arithmetic that gives the same bits on every machine, and the random numbers
cells/        Cells of a band: order of photons, parameters, laws
allocate      Allocations that go cell by cell: multinomial, and the AOMC program's rounding
phase/        Phase functions and the scattering step
"""
