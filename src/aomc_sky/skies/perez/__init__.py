"""The all-weather sky of Perez, Seals and Michalsky (1993).

bounds        Rigorous bounds of the Perez luminance over each patch, for the exact rejection inside it
clip          How much of a Perez sky has a negative luminance
coefficients  Coefficients a to e of the Perez sky from clearness, brightness and the sun: eqs. (6) to (8)
elementary    Exponential and power with + - x / alone, so that a sky's coefficients have the same bits on every ...
functions     The all-weather sky of Perez, Seals and Michalsky (1993) [perez1993]: its functions in one place
inputs        What the Perez sky is made from: clearness and brightness of the sky, from irradiances and the sun
integral      The denominator of eq. (3) of the Perez sky: the integral of f cos xi over the hemisphere
mass          Integral of the Perez luminance times cos xi over each patch of a grid, refined until two orders agree
moments       Means of mu and of 1/mu over the photons of each patch of a Perez sky
refine        Refinement of the tiles of a Perez sky that two orders of Gauss points do not agree on
sky           The Perez sky as a sky model: limits, warnings, radiance, patch masses
table         Table 1 of Perez, Seals and Michalsky (1993), and nothing else
tiles         A Perez sky as the integration of its patches sees it: numbers, distances to the sun, sums over tiles
tilt          The tilt of the Perez luminance inside each patch, and rigorous bounds of what it leaves over
zeros         Where the two factors of the Perez luminance are 0, in numbers that are the same on every machine
"""
