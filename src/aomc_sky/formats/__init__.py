"""One room or file per file format: numbers and where they stood, no physics.

amc/            amc.inp, lambbot.inp and difcol.inp of the AOMC program.
atmo/           Atmosphere descriptions (.atmo), the format of CalcMySky.
background/     Background-sky files (DIRSIG BackgroundSkyData, HDF5).
mcpl/           MCPL files (Monte Carlo Particle Lists, formats 2 and 3).
sky_toml/       sky.toml, beside amc.inp: weather, sun, background skies, sampling.
skydist/        skydist.inp: radiances or masses over zenith and azimuth indices.
weather/        Hourly weather files: EPW, TMY2 and TMY3.
bad_value       What is wrong with a piece of a value, before it is known where in which file the value stands
file_reference  Files that another file names: they may not lie outside its folder, whatever links say
photons_npy     Photons in a numpy file: rows of travel directions, with a weight in a fourth column where there is ...
photopic        How bright the eye sees light: the photopic luminous efficiency V(wavelength), which the unit cd/m2 ...
scanner         One scanner for both ways in which Fortran reads: fixed columns, and list-directed values
spectrum_csv    Spectra as two columns of numbers, and their means over the bins of a wavelength grid
text_file       Reading a text file a person may have broken: encodings, endings, sizes; and writing one atomically
units           Numbers with units: a closed table of exact factors, because general unit libraries guess
"""
