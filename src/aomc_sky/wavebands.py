"""Wavebands of a run, and the rule that gives each the nearest wavelength of a sky."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True, kw_only=True, slots=True)
class Wavebands:
    """The wavebands of lambbot.inp, in file order.

    Parameters
    ----------
    wavelength_nm : ndarray, float64, shape (n_band,)
        Wavelength of each band. [nm]
    bottom_reflectance, bottom_specular_fraction : ndarray, float64, shape (n_band,), or None
        Reflectance of the bottom and its specular share. [0 to 1]
    target_reflectance, target_specular_fraction : ndarray, float64, shape (n_band,), or None
        The same for the bottom target, where amc.inp has one. [0 to 1]
    """

    wavelength_nm: np.ndarray
    bottom_reflectance: np.ndarray | None = None
    bottom_specular_fraction: np.ndarray | None = None
    target_reflectance: np.ndarray | None = None
    target_specular_fraction: np.ndarray | None = None

    @property
    def n_bands(self) -> int:
        """Number of wavebands."""
        return int(self.wavelength_nm.size)


def nearest_wavelength_index(wavelength_nm: ArrayLike, table_wavelength_nm: ArrayLike) -> np.ndarray:
    """Index of the numerically closest table wavelength; a tie goes to the longer one.

    The order of the table does not matter; of equal table wavelengths the first is taken.
    """
    table = np.asarray(table_wavelength_nm, dtype=np.float64)
    bands = np.atleast_1d(np.asarray(wavelength_nm, dtype=np.float64))
    order = np.lexsort((np.arange(table.size), table))
    ordered = table[order]
    right = np.searchsorted(ordered, bands, side="left").clip(0, table.size - 1)
    left = (right - 1).clip(0)
    nearer_left = np.abs(bands - ordered[left]) < np.abs(ordered[right] - bands)
    chosen = np.where(nearer_left, left, right)
    # of equal wavelengths the first in the file
    return order[np.searchsorted(ordered, ordered[chosen], side="left")]


def midpoint_wavelength_index(wavelength_nm: ArrayLike, table_wavelength_nm: ArrayLike) -> np.ndarray:
    """Index of the table wavelength that the AOMC 1.2.2 program takes: midpoints in file order.

    The first j with band < (w[j] + w[j+1]) / 2 in 32-bit floats, else the last one.
    """
    table = np.asarray(table_wavelength_nm, dtype=np.float32)
    bands = np.atleast_1d(np.asarray(wavelength_nm, dtype=np.float32))
    if table.size == 1:
        return np.zeros(bands.size, dtype=np.intp)
    middle = (table[:-1] + table[1:]) / np.float32(2)
    below = bands[:, None] < middle[None, :]
    return np.where(below.any(axis=1), below.argmax(axis=1), table.size - 1)
