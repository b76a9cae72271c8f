"""aomc-sky info: what a file or folder contains.

command     ``aomc-sky info``: a scene, a run, one of the files below, or where the C headers are
atmo        The description of an atmosphere
background  A background-sky file
mcpl        An MCPL file
"""
