"""Photon files: one file per photon format.

writer     What a writer says of its files and makes of a block of photons; the formats by name
npy        Numpy files: directions (n, 3), positions (n, 2), weights (n,), one set per waveband
csv        Text: every number with all its digits in columns of fixed width
raw        Bare little-endian float32 records: ux, uy, uz, then x, y and the weight where there are any
mcpl       One MCPL file, byte for byte what libmcpl writes for the same photons and head
leaves     ``blocks-0001.npy``: the leaves of the content hash, written as photons are
files      The files of one writer while they are made: names appear when they are complete
stored     Photons as they stand in finished files, read block by block and compared with their leaves
npy_parts  Numpy files that several processes fill
"""
