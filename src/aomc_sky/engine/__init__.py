"""Jobs: one scene into a run folder or a stream.

run          A run folder, or a stream of photons: plan, counts, photons, manifest
shards       Shards of a run: each writes its photons in place; whoever sees all marks ends the run
cluster      A run on a Dask cluster: its shards are the tasks
stored_run   A run folder, opened again: its plan as a photon source, and what its manifest says
export       Other formats from the plan of a run; no photon needs to have been stored
atmosphere   One atmosphere under several suns: tables and a report
"""
