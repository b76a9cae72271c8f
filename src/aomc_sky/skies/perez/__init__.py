"""The all-weather sky of Perez, Seals and Michalsky (1993).

functions     The paper's functions in one place, public as `aomc_sky.perez`: radiance, luminance, their integral
clearness     Clearness, brightness and air mass: what the sky is made from
table         Table 1 of the paper, and nothing else
coefficients  Coefficients a to e from clearness, brightness and the sun, eqs. (6) to (8)
elementary    Exponential and power with + - x / alone, for coefficients of the same bits on every machine
sky           PerezSky: limits, warnings, radiance, and the component that the sampler gets
patches       Mass and moments of every patch of a grid
tiles         Tiles of patches, cut where the luminance is not smooth, halved until two orders agree
bounds        Bounds of the luminance over every patch, for the exact rejection inside it
"""
