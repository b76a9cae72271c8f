"""The files of a run folder against its plan.

parts       From a run folder to the parts that are verified: the whole run, or its finished shards
run         A whole verification: files, counts, photons, directions
blocks      Blocks against the leaves of the manifest and against the plan
photons     Photons of one waveband out of the files that can be read
manifest    The manifest and the file of counts, made again
scene_plan  The plan made again from the scene's files
"""
