"""What the transport counts, in whole numbers: sums that are exact in any order, on any number of threads."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

ONE_PHOTON = 2**32
"""A photon's weight; parts of a photon are whole numbers of 1 / 2^32."""
MAX_PHOTONS = 2**30
"""Photons of one tally: a level is crossed several times per photon, and sums must stay below 2^63."""

REFLECTED, LEAVING, ABSORBED, BOTTOM = range(4)
"""How a photon's light ends: reflected by the surface, leaving the water, absorbed by it, absorbed by the bottom."""

N_MU, N_AZIMUTH = 12, 24
"""Cells of the histogram of refracted directions: equal in mu^2 (equal flux, were it diffuse) and in azimuth."""


class Tally(NamedTuple):
    """Weights, int64, in parts of `ONE_PHOTON`."""

    fate: np.ndarray
    """By its end, shape (4,)."""
    down: np.ndarray
    """Crossing each depth downwards, shape (n_depth,)."""
    up: np.ndarray
    """Crossing each depth upwards, shape (n_depth,)."""
    refracted: np.ndarray
    """Entering the water, by direction, shape (N_MU, N_AZIMUTH)."""


def empty_tally(n_depth: int) -> Tally:
    """Return a tally of zeros."""
    return Tally(
        np.zeros(4, np.int64),
        np.zeros(n_depth, np.int64),
        np.zeros(n_depth, np.int64),
        np.zeros((N_MU, N_AZIMUTH), np.int64),
    )


def sum_of(tallies: list[Tally]) -> Tally:
    """Add tallies up."""
    return Tally(*(np.sum(parts, axis=0) for parts in zip(*tallies, strict=True)))


@numba.njit(nogil=True)
def add_refracted(refracted: np.ndarray, ux: float, uy: float, mu: float, index: float, weight: int) -> None:
    """Add a photon that enters the water to the histogram of directions.

    The rows share the flux of a uniform sky evenly: mu^2 of the water runs from 1 - 1 / n^2 to 1, and
    (mu_air)^2 = 1 - n^2 (1 - mu^2) is uniform there.
    """
    share = 1.0 - index * index * (1.0 - mu * mu)
    turn = np.arctan2(uy, ux) / (2.0 * np.pi)
    row = min(max(int(share * N_MU), 0), N_MU - 1)
    column = min(int((turn + 1.0 if turn < 0.0 else turn) * N_AZIMUTH), N_AZIMUTH - 1)
    refracted[row, column] += weight
