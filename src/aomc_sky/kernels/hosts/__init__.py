"""Photons inside another code's own loop.

sampler       One photon at a time, for a transport code that asks by index: the photons that `emit` makes in blocks
tables        Arguments of a kernel behind one address, so that code outside Python can hand them to it
next_photons  The C function that delivers a range of photons of a band: `emit` behind an address
"""
