"""aomc-sky atmosphere: the clear sky of an atmosphere description.

command            ``aomc-sky atmosphere``: the clear sky of an atmosphere description as tables, under one or more suns
calcmysky_options  The options that ``calcmysky``, the tool the description format comes from, has too
"""
