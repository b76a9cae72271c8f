"""The clear sky of an atmosphere description as tables.

keys   What becomes of the sizes and numbers of points that a description asks for
table  One atmosphere under several suns: asked for, checked, then solved
files  The files of a solved table, its report among them
"""
