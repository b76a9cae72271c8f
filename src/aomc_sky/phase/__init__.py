"""Phase functions as triples sample / pdf / cdf, and the scattering step that uses them.

rayleigh           Rayleigh scattering, anisotropy of molecules, depolarisation of dry air [bucholtz1995]
henyey_greenstein  Henyey-Greenstein: p(mu) = (1 - g^2) / (4 pi (1 + g^2 - 2 g mu)^(3/2)) per steradian, mean mu = g
scattering         One scattering step: a direction, a scattering angle and an azimuth give the next direction
vectorised         Formulas of the kernels over whole arrays: checks, precision, broadcasting, blocks for the cache
"""
