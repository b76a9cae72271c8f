"""sky.toml, beside amc.inp: weather, sun, background skies, atmosphere.

file      `read_sky_toml`, and what it returns.
keys      What may be said about the light of a scene: sections, keys, their ranges, and which of them go together.
rules     Kinds of values: what each accepts, what is wrong with another one, and how it is read.
moon      The direction of the Moon before the sun: its keys in sky.toml, as options and as arguments.
sections  Sections of a parsed file: good values, and a report with its span of everything else.
spans     Where every key of a TOML text stands: the standard library's reader gives values without spans.
"""
