"""Unit vectors and energies as MCPL packs them into three numbers, unpacked in libmcpl's own order of operations."""

from __future__ import annotations

import numpy as np


def unpack(packed: np.ndarray, version: int) -> tuple[np.ndarray, np.ndarray]:
    """Energies and directions of packed triples.

    Parameters
    ----------
    packed : ndarray, float64, shape (n, 3)
        Two numbers of the direction, and the energy with the sign of the third.
    version : int
        Version of the format. [2: octahedral, 3: adaptive projection]

    Returns
    -------
    energy : ndarray, float64, shape (n,)
        [MeV]
    direction : ndarray, float64, shape (n, 3)
        Unit vectors.
    """
    return (_octahedral if version == 2 else _adaptive)(packed)


def _adaptive(packed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The smaller components as they are, with 1/z in the place of the largest; its sign is that of the energy."""
    a, b, c = packed.T
    is_x, is_y = np.abs(a) > 1.0, np.abs(b) > 1.0
    is_y &= ~is_x
    first = np.where(is_x, b, a)
    with np.errstate(divide="ignore"):
        second = np.where(is_x, 1.0 / a, np.where(is_y, 1.0 / b, b))
    largest = np.copysign(np.sqrt(np.maximum(0.0, 1.0 - (first * first + second * second))), c)
    direction = np.empty_like(packed)
    direction[:, 0] = np.where(is_x, largest, a)
    direction[:, 1] = np.where(is_y, largest, b)
    direction[:, 2] = np.where(is_x | is_y, second, largest)
    return np.abs(c), direction


def _octahedral(packed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    a, b, c = packed.T
    z = 1.0 - np.abs(a) - np.abs(b)
    is_lower = z < 0
    x = np.where(is_lower, (1.0 - np.abs(b)) * np.where(a >= 0.0, 1.0, -1.0), a)
    y = np.where(is_lower, (1.0 - np.abs(a)) * np.where(b >= 0.0, 1.0, -1.0), b)
    scale = 1.0 / np.sqrt(x * x + y * y + z * z)
    direction = np.stack([x * scale, y * scale, z * scale], axis=-1)
    direction[np.signbit(c), 2] = 0.0  # the sign of the energy marks a horizontal direction
    return np.abs(c), direction
