"""Radiance as a function of sky direction and wavelength: no file knows, no sampling.

model        What every sky model promises, and how one that only knows its radiance reaches the sampler
registry     The sky models by name, those of entry points too
uniform      A sky of equal radiance everywhere
tabulated    A sky given as a table of values over patches and wavelengths
aomc_weight  The AOMC 1.2.2 program's weight of a table entry, in 32-bit arithmetic
direct_beam  The direct beam of the sun: a direction, or the solar disc
perez/       The all-weather sky of Perez, Seals and Michalsky (1993)
lobes/       Background skies: lobes that move and change with time, each with a spectrum
atmosphere   The clear sky of a physical atmosphere as a sky model, in absolute units, and its direct beam
"""
