"""Jobs: one scene into a run folder or a stream.

run          A run folder, or a stream of photons: plan, counts, photons, manifest
shards       Shards of a run: each writes its photons into files of full size, and the last one finishes the run
cluster      A run on a Dask cluster: its tasks are shards
stored_run   A run folder that is opened again: its plan as a photon source, and its manifest
export       Other formats from the plan of a run, which needs no stored photons
export_formats  The formats of ``export`` by name
atmosphere   One atmosphere under several suns: tables and a report
"""
