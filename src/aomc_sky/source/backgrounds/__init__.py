"""Background-sky files become the light of a scene.

absolute_units  Scenes in absolute units: what [sky] of sky.toml says of sun and sky, and the backgrounds added to ...
light           Background-sky files become skies, and their lobes the light that shines at one time
scene           Background-sky files at one time, ready to be shown and sampled without AMC files
"""
