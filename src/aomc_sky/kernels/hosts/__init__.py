"""Photons inside another code's own loop.

loop          The smallest host of all: a loop that asks for every photon by its index and adds the directions up
next_photons  The C function that delivers a range of photons of a band: `emit` behind an address, for C, Fortran ...
sampler       One photon at a time, for a transport code that asks by index; the same photons as `emit` makes in ...
tables        Arguments of a kernel behind one address, so that code outside Python can hand them to it
"""
