"""The all-weather sky of Perez, Seals and Michalsky (1993).

functions     The paper's functions, public as `aomc_sky.perez`: radiance, luminance, their integral
irradiances   Global, diffuse and direct irradiance: two of them give the third; what is refused
coefficients  From irradiances and the sun to clearness, brightness and the coefficients a to e, eqs. (4) to (8)
table         Table 1 of the paper, and nothing else
sky           PerezSky: limits, warnings, radiance, and the component that the sampler gets
patches       Mass and moments of every patch of a grid, by the rule in `skies.quadrature`
law           The law PEREZ as the spine asks for it: moments, rules of a plan, flux, tables of the rejection
kernels/      The luminance and its photons, for arrays and compiled
bounds        Bounds of the luminance over every patch, for the exact rejection inside it
"""
