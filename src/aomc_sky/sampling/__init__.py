"""Mass, integer counts and streams: numbers and arrays only, never a sky or a file.

mass        Masses of any scale as probabilities: float64, and fixed point with 62 bits
streams     Keys of the random streams: one per seed, method and purpose, so that no two uses ever share numbers
allocation  Sharing a number of photons out over masses, in integers
"""
