"""Tables beside photons: counts, masses, radiances.

netcdf            Counts, masses and photons of a run as an xarray dataset and as a netCDF file
atmosphere        Skies of an atmosphere under several suns: a dataset, skydist.inp, and optional contents
"""
