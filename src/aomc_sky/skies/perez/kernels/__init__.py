"""The Perez sky: its luminance and its photons.

law     Luminance in float64 with + - x / sqrt alone: the same bits on every machine, no branches
cells   Photons inside a cell: exact rejection, so that the emitted law does not depend on the cells
reject  The rejection for the photons of a block, compiled
"""
