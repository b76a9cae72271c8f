"""Background-sky files become the light of a scene.

absolute_units  Scenes in absolute units: what [sky] of sky.toml says of sun and sky, and the backgrounds added to ...
light           The [[background]] tables of sky.toml: their files, and the lobes that shine at their times
read            Background-sky files become a sky
scene           Background-sky files at one time, ready to be shown and sampled without AMC files
"""
