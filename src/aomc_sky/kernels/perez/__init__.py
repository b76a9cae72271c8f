"""The Perez sky: its luminance, its masses, its photons.

law          Luminance in float64 with + - x / sqrt alone: the same bits on every machine, no branches
nodes        Gauss points and weights on (0, 1), from 40 digits
points       Points of the integrals: lines of constant zenith angle, ranges of azimuth, sums over many points
mass         Sums of luminance times cos xi over the points of many tiles of the sky
limits       When two orders of Gauss points agree on a tile: numbers that both forms of the sums share
tiles        Tiles of the patches, halved until two orders of Gauss points agree on them
edges        Integrals over tiles that the edge of an unlit region crosses
cells        Photons inside a cell: exact rejection, so that the emitted law does not depend on the cells
plain_law    `law` in plain numpy, equal to the bit
plain_mass   `mass` and `tiles` in plain numpy, equal to the bit: a first sky need not wait for the compiler
plain_edges  `edges` in plain numpy, equal to the bit
plain_cells  The rejection of `cells` in plain numpy, equal to the bit
"""
