"""The AOMC files and sky.toml become a scene.

scene        amc.inp and the files beside it become a scene
files        The files of a scene, all read before the first problem is reported
table        A sky file as the components of a scene: bins, weighting, wavelengths, and what to say of it
sun_and_sky  A scene lit by the sun and a sky model: how each waveband is split between the two, and what shines
plugin       The sky model of another package: which one, with which options, and what it gives
kind         What a path holds, for commands that take several kinds, or were given another
measured     A measured sky: a table of radiances as a sky model, and as a scene of its own
field        The radiance field that sky.toml names, as the diffuse sky of a scene
absolute_units  Scenes in absolute units: what [sky] of sky.toml says, and the backgrounds added to it
solve        `solve_atmosphere`: the sky of a description for Python
atmosphere   A scene lit by the sun and the clear sky of an atmosphere description, in absolute units
"""
