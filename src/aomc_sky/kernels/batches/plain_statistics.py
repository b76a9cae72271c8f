"""The sums of `statistics` in plain numpy, equal to the bit."""

from __future__ import annotations

import numpy as np


def block_sums(uz: np.ndarray) -> tuple[float, float]:
    """Sums of mu and 1 / mu in the order of the photons; numpy's cumsum adds one after the other."""
    mu = -uz.astype(np.float64)
    with np.errstate(divide="ignore"):
        inverse = 1.0 / mu
    return float(np.cumsum(mu)[-1]), float(np.cumsum(inverse)[-1])


def weighted_block_sums(uz: np.ndarray, weight: np.ndarray) -> tuple[float, float]:
    """Sum of the weight w and of w / mu, in the order of the photons; numpy's cumsum adds one after the other."""
    w = weight.astype(np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        scalar = w / -uz.astype(np.float64)
    return float(np.cumsum(w)[-1]), float(np.cumsum(scalar)[-1])
