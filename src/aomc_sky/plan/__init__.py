"""The plan of a run, which every shard, export and check reads and never recomputes.

options  How a scene is sampled: the choices of one run, from the scene's preset and the caller
counts   The photon counts, made from the masses of a plan
plan     The plan itself: bands, components, counts, options, and the hash that names the run
band     One waveband of a plan
file     plan.npz: the records of a plan as arrays by name, the file of them, and the hash over them
footprint  The area of the surface that photons enter
laws     Properties of each law, by its number in a plan; those of slices are loaded late
check    Checks of a plan before a kernel uses its numbers as indices
sampling/  Masses to integer counts, and the streams of random numbers
"""
