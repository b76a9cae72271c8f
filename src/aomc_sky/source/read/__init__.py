"""The AOMC files and sky.toml become a scene.

scene           amc.inp and the files beside it become a scene
files           The files of a scene, with the problems of all of them together
table           A sky file as the sky of a scene: bins, weighting, wavelengths, and notes
kind            Kind of a file or folder, for commands and for messages about a wrong kind
measured        A measured sky: a table of radiances as a sky model
field           The radiance field of a file, and the measured sky that sky.toml names, as the sky of a scene
radiance_scene  The scene of radiances that are named alone: a measured sky, or a radiance field
solve           `solve_atmosphere`: the sky of a description for Python
atmosphere      Sun and clear sky of an atmosphere description, in absolute units
"""
