"""Jobs: one scene into a run folder or a stream.

run          A run folder, one shard of it, or a stream of photons: plan, counts, photons, manifest
merge        Shards of a run, gathered and joined into the files that the run makes in one go
cluster      A run on a Dask cluster, whose workers fill the files of the run from all sides
stored_run   A run folder, opened again: its plan as a photon source, and what its manifest knows
export       Other formats from the plan of a run; no photon needs to have been stored
atmosphere   One atmosphere under several suns: tables and a report
"""
