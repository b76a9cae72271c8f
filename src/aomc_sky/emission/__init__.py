"""Photons by their index: tables of a band, the photon source and the kernels that emit."""
