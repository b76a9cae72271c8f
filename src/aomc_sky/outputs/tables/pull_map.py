"""How far photons lie from what is expected, cell by cell: the map that shows where a test failed."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

LEAST_EXPECTED = 20.0
"""Photons that a cell expects at least for its pull to say something."""


def pull_map(
    observed: ArrayLike, expected: ArrayLike, *, variance: ArrayLike | None = None, least: float = LEAST_EXPECTED
) -> np.ndarray:
    """Return (observed - expected) / sqrt(variance) of every cell: independent photons give a normal law of variance 1.

    The variance is that of independent photons, `expected`, by default. NaN where it is below `least`, so that a cell
    expects too little to say; +inf where a cell that expects nothing holds something.
    """
    counts, mean = np.asarray(observed, dtype=np.float64), np.asarray(expected, dtype=np.float64)
    spread = mean if variance is None else np.asarray(variance, dtype=np.float64)
    pulls = np.full(counts.shape, np.nan)
    enough = (spread >= least) & (spread > 0)
    pulls[enough] = (counts[enough] - mean[enough]) / np.sqrt(spread[enough])
    pulls[(mean == 0) & (counts > 0)] = np.inf
    return pulls
