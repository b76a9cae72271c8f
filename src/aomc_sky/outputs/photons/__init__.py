"""Photon files: one file per photon format.

files   Photon files: their layouts, the writers that make their bytes, and the threads that fill them
npy     Numpy arrays, which `verify` reads too
mcpl    One MCPL file with the same bytes as libmcpl writes, which `verify` reads too
raw     Bare float32 records
csv     Text with all digits, for export
"""
