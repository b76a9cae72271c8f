"""Photon files: one file per photon format.

files   What a writer says of its files, the photons of a file, and the threads that fill the files
npy     Numpy arrays, written; read to verify
mcpl    One MCPL file, byte for byte what libmcpl writes for the same photons and head; read to verify
raw     Bare float32 records
csv     Text with all digits, for export
"""
