"""A Perez sky as the integration of its patches sees it: numbers, distances to the sun, sums over tiles."""

from __future__ import annotations

import sys
import threading
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from aomc_sky.kernels.perez.limits import SNAP

ROUNDING = 1e-15

PLAIN_PATCHES = 100_000
"""Patches that a process integrates in plain numpy before it compiles or loads the kernels (half a second)."""

_KERNELS = "aomc_sky.kernels.perez.mass"
_lock = threading.Lock()
_made = 0


def sums_for(n_patches: int) -> Any:
    """Module whose sums serve the next patches: plain numpy at first, the kernels once they pay.

    Parameters
    ----------
    n_patches : int
        Number of patches that are about to be integrated.

    Returns
    -------
    module
        `aomc_sky.kernels.perez.plain_mass` or `aomc_sky.kernels.perez.mass`; both give the same bits.
    """
    global _made  # noqa: PLW0603
    with _lock:
        _made += n_patches
        pays = _made > PLAIN_PATCHES
    return import_module(_KERNELS if pays or _KERNELS in sys.modules else "aomc_sky.kernels.perez.plain_mass")


def expect_patches(n_patches: int) -> None:
    """Load the kernels at once for a job of so many patches that they pay anyway.

    Parameters
    ----------
    n_patches : int
        Patches that the job will integrate in all.
    """
    if n_patches > PLAIN_PATCHES:
        import_module(_KERNELS)


@dataclass(frozen=True, kw_only=True, slots=True)
class TiledSky:
    """A sky's numbers and the module whose sums are used.

    Parameters
    ----------
    numbers : ndarray, float64, shape (8 or more,)
        a to e, zenith angle and azimuth of the sun in quarter turns, sine of the former.
    roots : ndarray, float64, shape (n_root,)
        sin^2(gamma/2) where the second factor changes its sign, ascending.
    x_zero : float
        Zenith angle where the first factor is 0, or -1. [quarter turns]
    sums : module
        `aomc_sky.kernels.perez.mass` or `aomc_sky.kernels.perez.plain_mass`.
    """

    numbers: np.ndarray
    roots: np.ndarray
    x_zero: float
    sums: Any

    @property
    def has_cusp(self) -> bool:
        """Whether the sun is a point in x and y; at the zenith it is a whole line."""
        return bool(self.numbers[7] > 0)

    @property
    def scale(self) -> float:
        """Rounding of the luminance in the units of f."""
        a, _, c, _, e = np.abs(self.numbers[:5]).tolist()
        return ROUNDING * (1.0 + a) * (1.0 + c + e)

    def sin_cos(self, x: np.ndarray) -> np.ndarray:
        """Sine and cosine of x quarter turns, shape (2, ...)."""
        out = np.empty((2, x.size))
        self.sums.each_sin_cos(x.ravel(), out)
        return out.reshape(2, *x.shape)

    def sun_beyond(self, y0: np.ndarray, y1: np.ndarray) -> np.ndarray:
        """Azimuth of the sun as the first one not before y0, snapped to the edges of [y0, y1]."""
        rest = self.numbers[6] - y0
        y = y0 + (rest - 4.0 * np.floor(0.25 * rest))
        y = np.where(y0 + 4.0 - y < SNAP, y0, y)
        return np.where(np.abs(y - y1) < SNAP, y1, y)
