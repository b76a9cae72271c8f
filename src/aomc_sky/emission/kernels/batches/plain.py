"""Sums over the photons of a batch, and their MCPL records, in plain numpy, equal to `compiled` to the bit."""

from __future__ import annotations

import numpy as np

_BLOCK = 4096  # what is between two steps stays in the cache


def block_sums(uz: np.ndarray) -> tuple[float, float]:
    """Sums of mu and 1 / mu in the order of the photons."""
    mu = -uz.astype(np.float64)
    with np.errstate(divide="ignore"):
        return _sums(mu, 1.0 / mu)


def weighted_block_sums(uz: np.ndarray, weight: np.ndarray) -> tuple[float, float]:
    """Sum of the weight w and of w / mu, in the order of the photons."""
    w = weight.astype(np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        return _sums(w, w / -uz.astype(np.float64))


def _sums(first: np.ndarray, second: np.ndarray) -> tuple[float, float]:
    """Two sums, one number after the other, as `cumsum` adds them: side by side as the parts of a complex one."""
    both = np.empty(first.size, np.complex128)
    both.real, both.imag = first, second
    last = np.cumsum(both, out=both)[-1]
    return float(last.real), float(last.imag)


def pack(
    ux: np.ndarray,
    uy: np.ndarray,
    uz: np.ndarray,
    cell: np.ndarray,
    energy: np.floating,
    flags: np.uint32,
    n_flagged: int,
    first: np.ndarray,
    second: np.ndarray,
    signed_energy: np.ndarray,
    user_flags: np.ndarray,
) -> None:
    """Write direction, energy and user flags of photons; parameters as of `compiled.pack`."""
    for start in range(0, ux.size, _BLOCK):
        part = slice(start, start + _BLOCK)
        x, y, z = ux[part], uy[part], uz[part]
        far_x, far_y = np.abs(x), np.abs(y)
        is_flat = np.abs(z) < np.maximum(far_x, far_y)
        is_x = is_flat & (far_x >= far_y)
        is_y = is_flat ^ is_x
        with np.errstate(divide="ignore", over="ignore"):
            inverse = 1 / np.where(z == 0, np.abs(z), z)  # infinity without a sign, also of -0
        first[part] = np.where(is_x, inverse, x)
        second[part] = np.where(is_y, inverse, y)
        signed_energy[part] = np.copysign(energy, np.where(is_x, x, np.where(is_y, y, z)))
        own = cell[part]
        user_flags[part] = np.where(own < n_flagged, flags + own.astype(np.uint32), np.uint32(0))
