"""aomc-sky perez: one Perez sky, or a year of them, without AMC files.

command  ``aomc-sky perez``: one Perez sky without AMC files, or a year of them from a weather file
files    What ``aomc-sky perez`` writes of one sky: a table of radiances, photon counts, a picture
report   What ``aomc-sky perez`` prints of one sky
sky      Which sky the options of ``aomc-sky perez`` describe
year     ``aomc-sky perez --every hour``: a year of skies from a weather file
"""
