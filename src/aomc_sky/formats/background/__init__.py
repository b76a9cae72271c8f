"""Background-sky files (DIRSIG BackgroundSkyData, HDF5).

builder       Background-sky files from lobes as a person describes them: an axis on the sky, a shape, a spectrum
checks        What the values of a background-sky file must fulfil, whether they are read or to be written
data          What a background-sky file holds: lobe animations and the spectra they share
encoding      The bytes of a background-sky file, and the content that a reader will find in them
file          Background-sky files (DIRSIG BackgroundSkyData, HDF5): reader and writer
hdf5_child    The process that opens an HDF5 file for us, for a damaged file can end or hang the HDF5 library
hdf5_members  Members of an HDF5 file that nobody vouches for, read by a process of its own
parts         The members of a background-sky file made into animations and spectra
schema        Names, units and record layouts of background-sky files, format version 1
"""
