"""Radiance as a function of sky direction and wavelength: no file knows, no sampling.

model        What every sky model promises, the models by name, and how one that only knows its radiance is sampled
uniform      A sky of equal radiance everywhere
tabulated    A sky given as a table of values, also with the AOMC 1.2.2 program's own weights in 32-bit arithmetic
direct_beam  The direct beam of the sun: a direction, or the solar disc
perez/       The all-weather sky of Perez, Seals and Michalsky (1993)
lobes/       Background skies: lobes that move and change with time, each with a spectrum
atmosphere   The clear sky of a physical atmosphere as a sky model, in absolute units, and its direct beam
"""
