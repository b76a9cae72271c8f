"""aomc-sky perez: one Perez sky, or a year of them, without AMC files.

command  ``aomc-sky perez``: one sky, or with --every hour a year of them from a weather file
sky      Which sky the options describe
report   What is printed and written of one sky: numbers, a table of radiances, photon counts, a picture
"""
