"""The AOMC 1.2.2 program's weight of a table entry, in 32-bit arithmetic."""

from __future__ import annotations

import numpy as np

_PI = np.float32(3.14159265)
_RING = np.float32(0.01745329)
_FIRST_AND_LAST_RING = np.float32(0.0261799)


def aomc_weight(radiance: np.ndarray) -> np.ndarray:
    """Weight of each entry of a table: L sin z cos z and constants, z whole degrees.

    Parameters
    ----------
    radiance : ndarray, shape (n_zenith, n_azimuth)
        Listed values; row k is zenith index k + 1. [>= 0]

    Returns
    -------
    ndarray, float32, shape of `radiance`
        The program's products in its order, ((((L sin) c1) c2) cos), c1 half as large again for
        rings 1 and 89. Sine and cosine are rounded from float64, as glibc's are for whole degrees.
        Entries beyond 90 degrees, where the program's cosine is negative, are never read.
    """
    index = np.arange(1, radiance.shape[0] + 1)
    angle = (index.astype(np.float32) * _PI) / np.float32(180)
    sine = np.sin(angle.astype(np.float64)).astype(np.float32)[:, None]
    cosine = np.cos(angle.astype(np.float64)).astype(np.float32)[:, None]
    first = np.where((index == 1) | (index == 89), _FIRST_AND_LAST_RING, _RING)[:, None]
    return (((radiance.astype(np.float32) * sine) * first) * _RING) * cosine
