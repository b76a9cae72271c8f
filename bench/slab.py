"""A photon's way through a slab of water without a surface, for the tallies of `bias.py` and `every_sky.py`."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numba
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples" / "slab"))

from scattering import sample_henyey_greenstein, turned

G, ALBEDO, DEPTH = 0.92, 0.9, 2.0
"""Mean cosine, single scattering albedo, optical depth."""


@numba.njit(nogil=True)
def seeded(seed: int) -> None:
    """Seed the generator that `left` draws from, which is that of compiled code."""
    np.random.seed(seed)  # noqa: NPY002 - numba's own generator


@numba.njit(nogil=True)
def left(ux: float, uy: float, uz: float) -> tuple[int, float, float]:
    """Return 1 for a photon that leaves upwards, -1 downwards, 0 for an absorbed one; and its ux and uz there."""
    depth = 0.0
    while True:
        depth += uz * math.log(1.0 - np.random.random())  # noqa: NPY002
        if depth < 0.0:
            return 1, ux, uz
        if depth > DEPTH:
            return -1, ux, uz
        if np.random.random() > ALBEDO:  # noqa: NPY002
            return 0, ux, uz
        mu = sample_henyey_greenstein(G, np.random.random())  # noqa: NPY002
        ux, uy, uz = turned(ux, uy, uz, mu, np.random.random())  # noqa: NPY002
