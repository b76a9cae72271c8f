"""Every job: one scene into a run folder or a stream, and the hours of a year into one set of files.

atmosphere/  The clear sky of an atmosphere description as tables.
cluster/     A run on a Dask cluster.
shards/      Shards: parts of a run made apart and joined.
export       ``export``: other formats from the plan of a run; no photon needs to have been stored
finished     A run or shard that was finished before: its manifest, if every file still is what it says
job          The photon files of a run or shard, made where they are missing or damaged
run          Every job: photons in chunks on threads, written in order, statistics that no split can change
stored_run   A run folder, opened again: its plan as a photon source, and what its manifest knows
year         A year of skies: a weather file in, the photon counts of every hour out, any photon of any hour on demand
"""
