"""The Perez sky: its luminance, its masses, its photons.

law     Luminance in float64 with + - x / sqrt alone: the same bits on every machine, no branches
nodes   Gauss points of the integrals over tiles, and when two orders of them agree
mass    Integrals over patches and tiles in plain numpy: a first sky need not wait for the compiler
sums    The sums over the patches of a sky, compiled
tiles   Tiles of the patches, halved until two orders of Gauss points agree on them, compiled
cells   Photons inside a cell: exact rejection, so that the emitted law does not depend on the cells
reject  The rejection for the photons of a block, compiled
"""
