"""Background-sky files (DIRSIG BackgroundSkyData, HDF5).

data          The content of a file, also built from lobes that a person describes.
check         Faults of animations and spectra, of a file or made by hand.
file          `read_background_file` and `write_background`: members become data, are checked, and are written.
hdf5_members  Members of an HDF5 file from an unknown source.
"""
