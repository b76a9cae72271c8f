"""sky.toml, beside amc.inp: weather, sun, background skies, sampling.

file      sky.toml, beside amc.inp: the weather of the Perez sky, the exact place of the sun, backgrounds, absolute ...
keys      What may be said about the light of a scene: sections, keys, their ranges, and which of them go together
moon      Where the Moon stands before the sun: its keys in sky.toml, as options and as arguments
rules     Kinds of values of sky.toml: what each accepts, what is wrong with another one, and how it is read
sections  Sections of a parsed sky.toml: good values, and a report with its place of everything else
spans     Where every key of a TOML text stands: the standard library's reader gives values without places
"""
