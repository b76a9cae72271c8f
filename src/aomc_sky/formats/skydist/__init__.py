"""skydist.inp: radiances or masses over zenith and azimuth indices.

table  `read_skydist` and `write_skydist`, and what they read and write.
head   The first two records, and the declaration after the data of files that we wrote.
rows   The rows: plain ones through numpy's text reader, others slowly, with a message for everything that is wrong.
"""
