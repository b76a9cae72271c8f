"""A run on a Dask cluster, whose workers fill the files of the run from all sides.

block_range  Blocks of a waveband, written by any process into the middle of its files; and the end of these files
run          The job of a cluster: the connection, the tasks, and what comes next
"""
