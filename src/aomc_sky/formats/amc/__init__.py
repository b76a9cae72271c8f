"""amc.inp, lambbot.inp and difcol.inp of the AOMC program.

amc_inp    amc.inp: 30 fixed-column values, one per line, from column 49 on (31 in the older layout)
band_rows  The common form of lambbot.inp and difcol.inp: a count, then a row of reals per waveband
difcol     difcol.inp: share of the direct beam and relative intensity of every waveband (flag 0)
lambbot    lambbot.inp: the wavebands of a run and the reflectances of the bottom
layout     The lines of amc.inp: label, name, columns and range of every value
lines      One line of amc.inp: what Fortran reads, what a person reads, and the difference as a message
"""
