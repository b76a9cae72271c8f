"""Confidence intervals for shares and means."""

from __future__ import annotations

import numpy as np
from scipy.special import betaincinv, ndtr


def clopper_pearson(k: int, n: int, level: float) -> tuple[float, float]:
    """Interval for the probability behind k successes in n trials; misses it with chance at most `level`."""
    if not 0 <= k <= n:
        raise ValueError(f"{k} successes of {n} trials do not exist")
    low = 0.0 if k == 0 else float(betaincinv(k, n - k + 1, level / 2))
    high = 1.0 if k == n else float(betaincinv(k + 1, n - k, 1 - level / 2))
    return low, high


def mean_p(sample: np.ndarray, mean: float, variance: float | None = None) -> float:
    """Two-sided p-value of a sample's mean by the normal law; variance known, or the sample's own."""
    sample = np.asarray(sample, dtype=np.float64)
    spread = sample.var(ddof=1) if variance is None else variance
    if spread == 0:
        return float(sample.mean() == mean)
    return float(2 * ndtr(-abs(sample.mean() - mean) / np.sqrt(spread / sample.size)))
