"""skydist.inp: radiances or masses over zenith and azimuth indices.

fast_rows  The rows of a skydist.inp without a doubtful character, through numpy's own text reader
head       The first two records of skydist.inp, and the declaration after the data of files that we wrote
rows       The rows of skydist.inp, read slowly, with a message for everything that is wrong
table      skydist.inp: radiances or masses over zenith and azimuth indices, for one or more wavelengths
"""
