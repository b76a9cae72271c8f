"""Every jitted function of the package. Numbers and arrays only: no sky, no file, no option.

backend       Plain numpy or compiled kernels: decided here alone
formula       One text of a formula for both backends: numpy calls it with arrays, kernels compile it for one photon
jit           The only decorators of the package's kernels: strict IEEE, no GIL, noalias, and a cache
numba_private What of numba is not public: the pipeline with noalias, and the cache
arguments     Arguments behind an address, for hosts
arithmetic/   Arithmetic that gives the same bits on every machine, and the random numbers
cells/        Cells of a band: who is where in them, their order, and the laws of patches
perez/        The Perez sky: its luminance and its photons
lobes/        Photons of the lobes of background skies
emission/     Photons of a band
hosts/        Photons inside another code's own loop
batches/      Batches of photons after their emission: sums, and MCPL records
allocate      Allocations that go cell by cell: multinomial, and the AOMC program's rounding
phase/        Phase functions and the scattering step
atmosphere/   Light in spherical shells: quadratures along rays, and paths followed backwards
"""
