"""Checks of a run, and of photons that anybody made: counts, hashes, directions.

foreign/  Photons that another code made.
sky/      Directions of photons against the sky they come from.
stored/   The files of a run folder against its plan.
counts    Tests of photon counts against the masses they come from: for our own counts and for anybody's
report    What a verification found: checks in order, the level of its tests, and the maps of those that failed
tails     Tails of the laws that tests compare with, and neighbouring cells put together until they expect enough
thinning  Keyed random choices of a verification: a fair coin for each photon, and blocks to look at
threads   Threads of a verification: numpy and SHA-256 let each other run
"""
