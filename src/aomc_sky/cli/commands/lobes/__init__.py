"""aomc-sky lobes: background skies without AMC files.

command  ``aomc-sky lobes``: background-sky files at one time, without AMC files
files    What ``aomc-sky lobes`` writes: a table of radiances, a dataset, a picture, a run folder of photons
report   What ``aomc-sky lobes`` prints of background skies at one time
"""
