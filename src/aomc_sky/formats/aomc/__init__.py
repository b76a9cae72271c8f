"""The files that the AOMC program reads, as Fortran reads them.

scanner  One scanner for both ways in which Fortran reads: fixed columns, and list-directed values.
amc      amc.inp, lambbot.inp and difcol.inp.
sky_head The header of skydist.inp: its four counts, and the wavelengths.
skydist  skydist.inp: radiances or masses over zenith and azimuth indices.
"""
