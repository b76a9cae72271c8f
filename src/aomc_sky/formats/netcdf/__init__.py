"""netCDF files, classic or netCDF-4, that hold a radiance over directions.

field  `read_field`: one variable with its coordinates, from a file that nobody vouches for.
child  The process that opens it, for a damaged file can end or hang the libraries.
"""
