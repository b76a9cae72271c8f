"""aomc-sky plot: pictures of skies, runs and files.

command     ``aomc-sky plot``: its options, and what it prints
files       What a path is, and the picture of it
background  A background sky: at one time, at times side by side, or moving
"""
