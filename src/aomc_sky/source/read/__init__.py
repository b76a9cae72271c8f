"""The AOMC files and sky.toml become a scene.

scene            amc.inp and the files beside it become a scene
files            The files of a scene, all read before the first problem is told
table            A sky file as a scene: bins, weighting, wavelengths, and what to tell the user
program_reading  How the AOMC program would read a sky file, in the numbers of the run's table: mean cosine and Ed/Eo
sun_and_sky      A scene lit by the sun and a sky model: how each waveband is split between the two, and what shines
atmosphere       A scene lit by the sun and the clear sky of an atmosphere description, in absolute units
"""
