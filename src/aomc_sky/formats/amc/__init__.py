"""amc.inp, lambbot.inp and difcol.inp of the AOMC program.

layout      The lines of amc.inp: label, name, columns and range of every value.
amc_inp     amc.inp: 30 fixed-column values, one per line; what Fortran reads, and what a person would read.
band_files  lambbot.inp and difcol.inp: a count, then a row of reals per waveband.
"""
