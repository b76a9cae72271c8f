"""Photons inside another code's own loop.

sampler       One photon at a time, for a transport code that asks by index: the photons that `emit` makes in blocks
next_photons  The C function that delivers a range of photons of a band: `emit` behind an address
"""
