"""The files of a run folder against its plan.

run       A whole verification: files, counts, photons, directions
parts     From a run folder to the parts that are verified: the whole run, or its finished shards
photons   Photons of one waveband out of the files that can be read, each block against its leaf and the plan
manifest  The manifest, the file of counts and the plan made again
"""
