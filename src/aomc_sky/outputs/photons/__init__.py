"""Photon files: one class per photon format.

files   What a writer says of its files, the formats by name, and the threads that fill the files
npy     Numpy files: directions (n, 3), positions (n, 2), weights (n,)
rows    Rows of numbers: text with all digits (csv), bare float32 records (raw)
mcpl    One MCPL file, byte for byte what libmcpl writes for the same photons and head
"""
