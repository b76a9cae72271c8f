"""sky.toml, beside amc.inp: weather, sun, background skies, atmosphere.

file      `read_sky_toml`: good values, and a problem with its span for each bad one.
sections  The sections as records, made from good values.
keys      The rule of each key, and the keys that belong together.
"""
