"""The AOMC files and sky.toml become a scene.

atmosphere       A scene lit by the sun and the clear sky of an atmosphere description, in absolute units
band_split       How the light of every waveband is split between beam and sky, and who says so
difcol           A scene lit by the sun and a sky model (light-source flag 0): how the bands share photons between ...
files            The files of a scene, all read before the first problem is told
program_reading  How the AOMC program would read a sky file, in the numbers of the run's table: mean cosine and Ed/Eo
scene            amc.inp and the files beside it become a scene
table            A sky file as the components of a scene: bins, weighting, wavelengths, and what to tell the user
"""
