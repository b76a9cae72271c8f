"""What a run writes.

statistics  Sums over the photons of a block, held exactly, and what a run says of its photons
photon_formats  The formats of photons by name
shard       Which photons each part of a run makes, and the names of the files in a run folder
counts      counts.csv: one line per waveband and patch with mass
manifest    manifest.json: what a finished run holds
folder/     A run folder: its lock, its files, what may be replaced.
photons/    Photon files: one file per photon format.
tables/     Tables beside photons: counts, masses, radiances.
aomc/       Files from which the AOMC program launches our photon counts.
envmap      The diffuse light of a run as a latitude-longitude map of radiance for renderers, with the beam beside it
picture     Pictures of matplotlib as files: complete or not at all, and the same bytes for the same picture
"""
