"""Tables beside photons: counts, masses, radiances.

atmosphere        Skies of an atmosphere under several suns: as a dataset with CF conventions, and as skydist.inp
atmosphere_saves  More about the skies of an atmosphere, on demand: orders, source functions, the light of the ...
colour_radiance   Tristimulus values X, Y, Z and scotopic luminance W of a spectral radiance
counts_csv        counts.csv: one line per waveband and patch with mass
lobes             Lobes of background skies over patches: as skydist.inp and as a dataset with CF conventions
netcdf            Counts and masses of a run as an xarray dataset, and as a netCDF file with CF conventions
netcdf_photons    Photons of a small run as variables of a dataset: one long dimension, waveband after waveband
pull_map          How far photons lie from what is expected, cell by cell: the map that shows where a test failed
significand       Numbers whose significands are cut to fewer bits: they need less space once the file is compressed
"""
