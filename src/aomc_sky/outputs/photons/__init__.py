"""Photon files: one class per photon format.

files   What a writer says of its files, the formats by name, and the threads that fill the files
rows    Rows of numbers: numpy arrays (npy), bare float32 records (raw), text with all digits (csv)
mcpl    One MCPL file, byte for byte what libmcpl writes for the same photons and head
"""
