"""Photons of the lobes of background skies.

cells  Directions of photons of one lobe at a time; the law and the words are explained in `plain_lobe`
plain  Photons of the lobes of background skies: the formulas, for arrays and for `lobe_cells`, and the plain form
queue  Photons of lobes wait in a queue of their lobe, over the blocks of a call, until there are enough for long ...
"""
