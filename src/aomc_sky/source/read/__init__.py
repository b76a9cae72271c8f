"""The AOMC files and sky.toml become a scene.

scene        amc.inp and the files beside it become a scene
files        The files of a scene, with the problems of all of them together
table        A sky file as the components of a scene: bins, weighting, wavelengths, and notes
sun_and_sky  A scene lit by the sun and a sky model: with the split of each waveband between the two
kind         Kind of a file or folder, for commands and for messages about a wrong kind
measured     A measured sky: a table of radiances as a sky model, and as a scene of its own
field        The radiance field that sky.toml names, as the diffuse sky of a scene
absolute_units  Scenes in absolute units: irradiances in [sky] of sky.toml, and the backgrounds
solve        `solve_atmosphere`: the sky of a description for Python
atmosphere   A scene lit by the sun and the clear sky of an atmosphere description, in absolute units
"""
