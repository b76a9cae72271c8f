"""One backward path for each of many directions, addressed by its number: any part of them is followed by itself."""

from __future__ import annotations

import math

import numpy as np

from aomc_sky.kernels.backward_paths import first_flight, follow
from aomc_sky.kernels.jit import reader

_U64 = np.uint64


@reader
def follow_each(
    scales, shells, table, phases, guide, sun, moon, ground, limits, first, address, view, flight, sums, light
):  # fmt: skip
    """Light of one path in each direction.

    Parameters
    ----------
    scales, shells, table, phases, guide, sun, moon, ground
        As for `backward_paths.follow_paths`.
    limits : tuple of 3 int
        Most interactions, 1, and which directions count for the sun's order 1: every so many by their numbers.
    first : int
        Number of the first direction. [0 to 2^32 - 1]
    address : tuple of 3 uint64
        Stream, wavelength, key.
    view : ndarray, float64, shape (n, 3)
        Directions, z up at the eye.
    flight, sums : ndarray, float64, shape (n_shell + 1, 2) and (1, 1, 2)
        Room to work in.
    light : ndarray, float64, shape (n, 2)
        Without the sun's order 1, and that where it counts, else 0; filled.
    """
    for k in range(view.shape[0]):
        here = (view[k, 0], view[k, 1], view[k, 2])
        first_flight(scales[0], shells, here[2], flight)
        forcing = -math.expm1(-flight[shells.shape[0], 0])
        place_of = (_U64(first + k), address[0], address[1], address[2])
        light[k, 0], light[k, 1] = follow(
            scales, shells, table, phases, guide, sun, moon, ground, limits, place_of, here, flight, forcing, sums, 0,
            (first + k) % limits[2] == 0,
        )  # fmt: skip
