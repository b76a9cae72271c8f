"""What all jitted functions share, which stand below folders of this name: numbers and arrays, no file, no option.

backend       Plain numpy or compiled kernels: decided here alone
formula       One text of a formula for both backends: numpy calls it with arrays, kernels compile it for one photon
jit           The only decorators of the package's kernels: strict IEEE, no GIL, noalias, and a cache
numba_private What of numba is not public: the pipeline with noalias, and the cache
arguments     Arguments behind an address, for hosts
arithmetic/   Arithmetic that gives the same bits on every machine, and the random numbers
cells/        Cells of a band: who is where in them, their order, and the laws of patches
allocate      Allocations that go cell by cell: multinomial, and the AOMC program's rounding
phase/        Phase functions and the scattering step
"""
