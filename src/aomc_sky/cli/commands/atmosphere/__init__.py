"""aomc-sky atmosphere: the clear sky of an atmosphere description.

calcmysky_options  The options that ``calcmysky``, the tool the description format comes from, has too
command            ``aomc-sky atmosphere``: the clear sky of an atmosphere description as tables, under one sun or ...
report             What ``aomc-sky atmosphere`` prints of a description and its skies
"""
