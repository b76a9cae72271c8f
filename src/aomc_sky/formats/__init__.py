"""One file or room per file format: numbers and where they stood, no physics.

report          Problems of a file, gathered to its end, and texts of their messages.
text_file       Reading a text file with checks, and writing one.
hdf5_storage    Checks of an HDF5 file before its data are read.
units           Numbers with units: a closed table of exact factors, because general unit libraries guess.
aomc/           The files that the AOMC program reads: amc.inp, lambbot.inp, difcol.inp, skydist.inp.
sky_models      Sky models by name: ours, and those of other packages.
sky_toml/       sky.toml, beside amc.inp: weather, sun, background skies, atmosphere.
spectrum_csv    Spectra as two columns of numbers, and their means over the bins of a wavelength grid.
radiance_csv    Measured radiances of the sky as a table of text.
radiance_words  The words of such tables: names of columns, units, where azimuths count from.
radiance_unit   Units of spectral radiance.
azimuth         From where azimuths count and which way.
quote           What a file says in words is shown to a person, and changes nothing.
weather         Hourly weather files (EPW, TMY2, TMY3): when each hour began, and its irradiances.
netcdf          netCDF files that hold a radiance over directions.
mcpl/           MCPL files (Monte Carlo Particle Lists, formats 2 and 3).
"""
