"""The plan of a run: what every shard, export and check reads and never recomputes.

options  How a scene is sampled: the choices of one run, resolved from the scene's preset and the caller
counts   The photon counts, made from the masses of a plan
plan     The plan itself: counts, cells, keys, options; its hash names the run; and plan.npz, read as a stranger's file
footprint  The area of the surface that photons enter
laws     What each law answers, by its number in a plan; those of slices are loaded late
check    What must hold before a kernel reads by the numbers of a plan
sampling/  Masses to integer counts, and the streams of random numbers
"""
