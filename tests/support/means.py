"""Tests of means."""

from __future__ import annotations

import numpy as np
from scipy.special import ndtr


def mean_p(sample: np.ndarray, mean: float, variance: float | None = None) -> float:
    """Two-sided p-value of a sample's mean by the normal law; variance known, or the sample's own."""
    sample = np.asarray(sample, dtype=np.float64)
    spread = sample.var(ddof=1) if variance is None else variance
    if spread == 0:
        return float(sample.mean() == mean)
    return float(2 * ndtr(-abs(sample.mean() - mean) / np.sqrt(spread / sample.size)))
