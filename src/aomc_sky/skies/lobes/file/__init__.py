"""Background-sky files (DIRSIG BackgroundSkyData, HDF5).

data          What a file holds: lobe animations and the spectra they share; built from lobes that a person describes
file          `read_background_file` and `write_background`: members made into data, checked, and written.
hdf5_members  Members of an HDF5 file that nobody vouches for.
"""
