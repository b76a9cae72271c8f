"""sky.toml, beside amc.inp: weather, sun, background skies, atmosphere.

file   `read_sky_toml`: good values, and a report with its span of everything else; where the keys of a text stand.
keys   What may be said about the light of a scene: sections, keys, their ranges, and which of them go together.
rules  Kinds of values: what each accepts, what is wrong with another one, and how it is read.
"""
