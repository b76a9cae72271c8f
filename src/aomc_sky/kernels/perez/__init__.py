"""The Perez sky: its luminance, its masses, its photons.

cells        Photons of the Perez sky inside a cell: exact rejection, so that the emitted law does not depend on ...
edges        Integral over tiles of the sky that the edge of an unlit region crosses: circles about the sun where ...
law          The Perez luminance in float64 with + - x / sqrt alone: the same bits on every machine, no branches
limits       When two orders of Gauss points agree on a tile of a Perez sky: numbers that both forms of the sums share
mass         Sums of the Perez luminance times cos xi over the points of many tiles of the sky
nodes        Gauss points and weights on (0, 1), from 40 digits: numpy computes them with a library that may differ
plain_cells  The exact rejection of `perez_cells` in plain numpy, equal to the bit
plain_edges  The integrals of `perez_edges` in plain numpy, equal to the bit
plain_law    The Perez luminance of `perez_law` in plain numpy, equal to the bit
plain_mass   The sums of `perez_mass` in plain numpy, equal to the bit: a first sky need not wait for the compiler
points       Points of a Perez sky's integrals: lines of constant zenith angle, ranges of azimuth, sums over many ...
tiles        Tiles of a Perez sky's patches, halved until two orders of Gauss points agree on them
"""
