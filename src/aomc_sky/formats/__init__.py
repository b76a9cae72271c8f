"""One file or room per file format: numbers and where they stood, no physics.

report          Problems of a file, gathered until it has been read to its end, and how their messages show values.
text_file       Reading a file that a person may have broken: kind, size, encoding, line ends; and writing one.
hdf5_storage    What is looked at before data of an HDF5 file are read.
units           Numbers with units: a closed table of exact factors, because general unit libraries guess.
aomc/           The files that the AOMC program reads: amc.inp, lambbot.inp, difcol.inp, skydist.inp.
sky_toml/       sky.toml, beside amc.inp: weather, sun, background skies, atmosphere.
spectrum_csv    Spectra as two columns of numbers, and their means over the bins of a wavelength grid.
radiance_csv    Measured radiances of the sky as a table of text.
radiance_words  The words of such tables: names of columns, units, where azimuths count from.
weather         Hourly weather files (EPW, TMY2, TMY3): when each hour began, and its irradiances.
netcdf          netCDF files that hold a radiance over directions.
mcpl/           MCPL files (Monte Carlo Particle Lists, formats 2 and 3).
"""
