"""Photons of the lobes of background skies.

law    The law of a lobe and its words: the formulas, for arrays and kernels, and the whole in plain numpy
cells  Directions of photons of one lobe at a time
queue  Photons wait in a queue of their lobe, over the blocks of a call, until there are enough for long loops
"""
