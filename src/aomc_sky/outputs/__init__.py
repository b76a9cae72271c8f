"""What a run writes.

aomc/           Files from which the AOMC program launches our photon counts.
folder/         A run folder: its layout, its lock, its files.
hashes/         The content hash of a run: a tree of SHA-256 over blocks of photons.
manifest/       Manifests: what a finished run or shard holds.
photons/        Photon files: one file per photon format.
tables/         Tables beside photons: counts, masses, radiances.
year/           The folder of a year of skies.
beam_direction  Where a beam or a disc stands in the sky, from the parameters of its cell
chunk_pool      Chunks of a band's photons, made on threads ahead of the one that is written, in bounded memory
exact_sum       A sum of any number of floats, held exactly in bounded memory
in_order        Work on threads whose results come in the order of the items, in bounded memory
picture         Pictures of matplotlib as files: whole or not at all, and the same bytes for the same picture
shard           Shards of a run: which photons each one makes, and how its files are told apart
statistics      What a run says of its photons: means, and standard errors from replicates, that no split of the ...
"""
