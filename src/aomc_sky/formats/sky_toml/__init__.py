"""sky.toml, beside amc.inp: weather, sun, background skies, atmosphere.

file   `read_sky_toml`: good values, and a problem with its span for each bad one.
keys   Sections and keys, their ranges, and the sets that belong together.
rules  Kinds of values: each reads a good value and refuses a bad one.
"""
