"""The plan of a run: what every shard, export and check reads and never recomputes.

plan    The plan itself: counts, cells, keys, options; its hash names the run; and plan.npz, read as a stranger's file
schema  What a plan may be: one table of its arrays, one of its options, and what ties them together
laws    The rules of a plan's components: parameters of cells, and the tables that a law reads besides
"""
