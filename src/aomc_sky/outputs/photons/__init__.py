"""Photon files: one file per photon format.

csv             Photons as text: one CSV file per waveband, every number with all its digits in columns of fixed width
directions_npy  Photons as numpy files: directions (n, 3), positions (n, 2), weights (n,), one set per waveband
files           Photon files while they are made: which wavebands share one, whether it is finished, its bytes and ...
mcpl            Photons as one MCPL file, byte for byte what libmcpl writes for the same photons and head
npy_header      The head of a numpy file, as `numpy.save` writes it
npy_parts       Numpy files that several processes fill: names until they are whole, and how to write into their ...
raw             Photons as bare little-endian float32 records: ux, uy, uz, then x, y and the weight where there are ...
registry        The photon formats by name: the only place that knows them all
stored          Photons as they stand in finished files, read block by block with their hash and their sums
waveband_files  What the writers have in common whose every file holds one waveband
"""
