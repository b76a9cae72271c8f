"""aomc-sky info: what a file or folder contains.

atmo         What ``aomc-sky info`` tells of a description of an atmosphere: its numbers, species, spectra, optical ...
background   What ``aomc-sky info`` tells of a background-sky file: its animations, their keys, its spectra
build_flags  What a C or Fortran compiler wants to know: the folder of our headers, and the flags that link this ...
command      ``aomc-sky info``: what a scene, a run folder, or a file of one of the formats contains
mcpl         What ``aomc-sky info`` tells of an MCPL file: the head, and the bounds of everything in its records
"""
