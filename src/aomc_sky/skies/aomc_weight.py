"""The AOMC 1.2.2 program's weight of a table entry, in 32-bit arithmetic."""

from __future__ import annotations

import numpy as np

_PI = np.float32(3.14159265)
_RING = np.float32(0.01745329)
_FIRST_AND_LAST_RING = np.float32(0.0261799)
_HORIZON = 90

# The program takes sine and cosine from its Fortran library, which is within 0.51 ulp but not correctly
# rounded. Whole degrees where it differs from the rounded float64 value, in units of the last place:
# measured with gfortran 12.2 and glibc 2.36; a test measures them again.
_SINE_ULP = {7: 1, 13: 1, 19: 1, 26: -1}
_COSINE_ULP = {49: 1, 74: 1}


def _as_the_library(values: np.ndarray, index: np.ndarray, ulp: dict[int, int]) -> np.ndarray:
    words = values.astype(np.float32).view(np.int32)
    words += np.array([ulp.get(int(z), 0) for z in index], dtype=np.int32)
    return words.view(np.float32)


def sine_and_cosine(index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sine and cosine of whole degrees as the program has them, float32, of its own angle index * 3.14159265 / 180.

    Degrees 1 to 90 agree with gfortran's library to the bit.
    """
    angle = ((index.astype(np.float32) * _PI) / np.float32(180)).astype(np.float64)
    return _as_the_library(np.sin(angle), index, _SINE_ULP), _as_the_library(np.cos(angle), index, _COSINE_ULP)


def aomc_weight(radiance: np.ndarray) -> np.ndarray:
    """Weight of each entry of a table, row k at zenith index k + 1: L sin z cos z and constants, z whole degrees.

    The program's float32 products in its order, ((((L sin) c1) c2) cos), c1 half as large again for rings 1 and 89. At
    90 degrees its cosine is -4e-8: its weights there round to no photon and vanish in its 32-bit sum, so they are 0.
    Beyond, where the cosine is negative, entries must be 0.
    """
    index = np.arange(1, radiance.shape[0] + 1)
    sine, cosine = sine_and_cosine(index)
    cosine = np.where(index == _HORIZON, np.float32(0), cosine)
    first = np.where((index == 1) | (index == 89), _FIRST_AND_LAST_RING, _RING)[:, None]
    return (((radiance.astype(np.float32) * sine[:, None]) * first) * _RING) * cosine[:, None]
