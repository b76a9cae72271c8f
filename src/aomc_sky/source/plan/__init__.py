"""The plan of a run: what every shard, export and check reads and never recomputes.

options  How a scene is sampled: the choices of one run, resolved from the scene's preset and the caller
counts   The photon counts, made from the masses of a plan
plan     The plan itself: counts, cells, keys, options; its hash names the run; and plan.npz, read as a stranger's file
schema   What a plan may be: one table of its arrays, one of its options, and what ties them together
laws     How a rule of a plan is refused, and the rules of its components: parameters of cells, the tables of a law
"""
