"""Mass, integer counts and streams: numbers and arrays only, never a sky or a file.

mass         Masses of any scale as probabilities: float64, and exact fixed point with 62 bits
fixed_point  Fixed point with 62 bits, for whole arrays: cumulative sums rounded exactly, products of 128 bits exact
streams      Keys of the random streams: one per seed, method and purpose, so that no two uses ever share numbers
allocation   Sharing a number of photons out over masses, in integers
"""
