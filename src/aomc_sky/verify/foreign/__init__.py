"""Photons that another code made.

check        Photons that another code made, tested against the sky of a scene
origin       Where an MCPL file says that its photons come from, and what that settles: the tests, and whether a ...
photon_file  Photons that any code has written, as blocks of one waveband: numpy files and MCPL
"""
