"""Tests of means."""

import numpy as np
from scipy.special import ndtr


def mean_p(sample, mean, variance=None):
    """Two-sided p-value of a sample's mean by the normal law; variance known, or the sample's own."""
    sample = np.asarray(sample, dtype=np.float64)
    spread = sample.var(ddof=1) if variance is None else variance
    if spread == 0:
        return float(sample.mean() == mean)
    return float(2 * ndtr(-abs(sample.mean() - mean) / np.sqrt(spread / sample.size)))
