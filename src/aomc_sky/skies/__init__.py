"""Radiance as a function of sky direction and wavelength: no file knows, no sampling.

lobes/       Background skies: lobes that move and change with time.
perez/       The all-weather sky of Perez, Seals and Michalsky (1993).
aomc_weight  The AOMC 1.2.2 program's weight of a table entry, in 32-bit arithmetic
atmosphere   The clear sky of a physical atmosphere as a sky model, in absolute units, and its direct beam
direct_beam  The direct beam of the sun: a direction, or the solar disc
model        What every sky model promises, and how a model that only knows its radiance reaches the sampler
registry     The sky models by name
tabulated    A sky given as a table of values over patches and wavelengths
uniform      A sky of equal radiance everywhere
"""
