"""aomc-sky plot: pictures of skies, runs and files.

background  Pictures of a background-sky file for ``aomc-sky plot``: one time, times side by side, an animation
command     ``aomc-sky plot``: the sky dome of a scene before its run, of a run, and of the files of the package
files       What ``aomc-sky plot`` draws of each kind of path, and where it writes it
report      What ``aomc-sky plot`` prints
"""
