"""Mass, integer counts and streams: numbers and arrays only, never a sky or a file.

streams     Keys of the random streams: one per seed, method and purpose, so that no two uses ever share numbers
walk        The order in which systematic allocation goes through the patches of a grid
allocation  Masses of any scale as probabilities, and a number of photons shared out over them in integers
"""
