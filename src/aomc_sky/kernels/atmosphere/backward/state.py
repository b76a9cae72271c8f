"""The state of paths that are followed backwards: what its rows are, and where the light of a path goes."""

from __future__ import annotations

from aomc_sky.kernels.jit import inlined_reader

ALTITUDE, VX, VY, VZ, UX, UY, UZ, MU, TO_END, WEIGHT, LEAST, LIGHT, TOTAL, ONCE = range(14)
N_STATE = 14
"""Rows of the paths' state."""

PATH, LIVE, KIND, CELL, SHELL, END = range(6)
N_MARK = 6
"""Rows of whole numbers: numbers of the paths under way, where their state stands, what scatters them, and the step of
its table; of each state its shell, and 1 where it is on the ground or looks at it."""


@inlined_reader
def settle(state, k, sums, block, row):
    """Add a path's light of an order, and its square, to the sums of its block."""
    light = state[LIGHT, k]
    if light > 0.0:
        sums[block, row, 0] += light
        sums[block, row, 1] += light * light
        state[TOTAL, k] += light
        state[LIGHT, k] = 0.0
