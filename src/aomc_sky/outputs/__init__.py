"""Files that a run writes.

statistics  Exact sums over photons, and the results of a waveband
photon_formats  The formats of photons by name
shard       Shards: equal parts of a run, each of whole blocks, and the marks of those that are made
counts      counts.csv: one line per waveband and patch with mass
manifest    manifest.json: the contents of a finished run
run_folder  The folder of one run: the names of its files, its lock, and files that appear when they are complete
photons/    Photon files: one file per photon format.
source_file The source in a file, which aomc_sky.h reads
tables/     Tables beside photons: counts, masses, radiances.
aomc/       Files from which the AOMC program launches our photon counts.
envmap      The diffuse light of a run as a latitude-longitude map of radiance for renderers, with the beam beside it
picture     Pictures of matplotlib as files: written atomically, with the same bytes for the same picture
"""
