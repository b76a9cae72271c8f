"""Background-sky files (DIRSIG BackgroundSkyData, HDF5).

file          `read_background_file` and `write_background`, and the bytes that are written.
data          What a file holds: lobe animations and the spectra they share, and its names, units and layouts.
parts         The members of a file made into animations and spectra.
checks        What the values of a file must fulfil, whether they are read or to be written.
hdf5_members  Members of an HDF5 file that nobody vouches for, read by a process of its own.
hdf5_child    That process, for a damaged file can end or hang the HDF5 library.
builder       The content of a file from lobes as a person describes them: an axis on the sky, a shape, a spectrum.
"""
