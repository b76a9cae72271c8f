"""The clear sky of an atmosphere description as tables.

files    The files of a solved table of an atmosphere
keys     What becomes of the sizes and numbers of points that a description asks for
report   What is said of a table of an atmosphere
request  What a table of an atmosphere is to hold
table    One atmosphere under several suns: checked, then solved
"""
