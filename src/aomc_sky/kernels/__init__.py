"""Every jitted function of the package. Numbers and arrays only: no sky, no file, no option.

arithmetic/  Arithmetic that gives the same bits on every machine, and the random numbers.
atmosphere/  Light in spherical shells: quadratures along rays, and paths followed backwards.
batches/     Batches of photons after their emission: sums, and MCPL records.
cells/       Cells of a band: who is where in them, their order, and the laws of patches.
emission/    Photons of a band.
hosts/       Photons inside another code's own loop.
lobes/       Photons of the lobes of background skies.
perez/       The Perez sky: its luminance, its masses, its photons.
phase/       Phase functions and the scattering step.
allocate     Allocations that go cell by cell: multinomial, and the AOMC program's rounding
backend      When compiled kernels pay: numba's start-up costs as much as a few million photons in plain numpy
jit          The only decorator of the package's kernels: strict IEEE, no GIL, noalias, widest vectors, and a cache ...
"""
