"""A run on a Dask cluster.

block_range   A stretch of a waveband, written by any process into the middle of the files of a run; and the end of ...
dask_cluster  A Dask cluster: the connection to one or a new one here, and work that is handed to its workers
run           A run on a Dask cluster: stretches of wavebands as tasks; a task that is lost is done again elsewhere
"""
