"""The plan of a run, which every shard, export and check reads and never recomputes.

options     How a scene is sampled: the choices of one run, from the scene's preset and the caller, and its footprint
streams     Keys of the random streams: one per seed, method and purpose, so that no two uses ever share numbers
allocation  Masses of any scale as probabilities, and photons shared out over them in integers: the counts of a plan
bias        Photons shared out otherwise than light: the factor of every cell
plan        The plan: bands, components, counts and options, its file plan.npz, and the hash that names the run
laws        Properties of each law, by its number in a plan; those of slices are loaded late
check       Checks of a plan before a kernel uses its numbers as indices
"""
