"""Background-sky files become the light of a scene.

absolute_units  Scenes in absolute units: irradiances that [sky] of sky.toml gives, and backgrounds added to them
light           Background-sky files become skies, and their lobes the light that shines at one time
"""
