"""One backward path for each of many directions, addressed by its number: any part of them is followed by itself."""

from __future__ import annotations

import math

from aomc_sky.kernels.atmosphere.backward.flight import first_flight, open_path
from aomc_sky.kernels.atmosphere.backward.numbers import COSINE, FLIGHT, SINE, SPARE, TURN, fill_numbers
from aomc_sky.kernels.atmosphere.backward.paths import ABREAST, follow
from aomc_sky.kernels.atmosphere.backward.state import ONCE, PATH, TOTAL
from aomc_sky.kernels.jit import reader


@reader
def follow_each(
    scales, shells, table, phases, guide, sun, moon, ground, limits, first, address, view, flight, numbers, state,
    marks, sums, light,
):  # fmt: skip
    """Fill `light` (n, 2) with that of one path in each direction of `view` (n, 3), z up at the eye.

    Its columns are the light without the sun's order 1, and that order where it counts, else 0. `limits`: most
    interactions, 1, and which directions count for the sun's order 1: every so many by their numbers, which begin with
    `first` [to 2^32 - 1]. `address` (uint64): stream, wavelength, key. `sums` (1, 1, 2) is scratch; the other
    parameters are those of `paths.follow_paths`.
    """
    for start in range(0, view.shape[0], ABREAST):
        n = min(ABREAST, view.shape[0] - start)
        for i in range(n):
            marks[PATH, i] = first + start + i
        fill_numbers(
            address, 0, marks[PATH], n, numbers[FLIGHT], numbers[TURN], numbers[COSINE], numbers[SINE], numbers[SPARE]
        )
        for i in range(n):
            here = (view[start + i, 0], view[start + i, 1], view[start + i, 2])
            first_flight(scales[0], shells, here[2], flight)
            weight = -math.expm1(-flight[0, shells.shape[1]])
            open_path(scales[0], shells, flight, weight, here, i, numbers, state, marks)
        follow(
            scales, shells, table, phases, guide, sun, moon, ground, limits, address, first + start, n, numbers, state,
            marks, sums, 0,
        )  # fmt: skip
        for i in range(n):
            light[start + i, 0], light[start + i, 1] = state[TOTAL, i], state[ONCE, i]
