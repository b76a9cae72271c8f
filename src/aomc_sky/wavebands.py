"""Wavebands of a run, and the rule that gives each the nearest wavelength of a sky."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import SceneError, UsageError, floats
from aomc_sky.options import in_nm
from aomc_sky.record import same_content
from aomc_sky.whole_number import as_index

MAX_NM = 1e9  #: A metre: light of longer waves has no sky here.


@dataclass(eq=False, frozen=True, slots=True)
class Wavebands:
    """The wavebands of lambbot.inp, in file order.

    Parameters
    ----------
    wavelength_nm : array_like, float64, shape (n_band,)
        Wavelength of each band. [nm, 0 to 1e9]
    bottom_reflectance, bottom_specular_fraction : array_like, float64, shape (n_band,), or None
        Reflectance of the bottom and its specular share. [0 to 1]
    target_reflectance, target_specular_fraction : array_like, float64, shape (n_band,), or None
        The same for the bottom target, where amc.inp has one. [0 to 1]

    Examples
    --------
    >>> bands = sky.Wavebands([440.0, 550.0, 670.0])
    >>> bands.wavelength_nm
    array([440., 550., 670.])
    """

    wavelength_nm: np.ndarray
    _: KW_ONLY
    bottom_reflectance: np.ndarray | None = None
    bottom_specular_fraction: np.ndarray | None = None
    target_reflectance: np.ndarray | None = None
    target_specular_fraction: np.ndarray | None = None

    __eq__ = same_content

    def __repr__(self) -> str:
        nm = self.wavelength_nm
        return (
            f"<Wavebands: {nm[0]:g} nm>" if nm.size == 1 else f"<Wavebands: {nm.size}, {nm.min():g} to {nm.max():g} nm>"
        )

    def __post_init__(self) -> None:
        n_bands = floats("wavelength_nm", self.wavelength_nm).size
        for field in fields(self):
            value = getattr(self, field.name)
            if value is None and field.name != "wavelength_nm":
                continue
            numbers = np.array(floats(field.name, value))
            numbers = numbers.reshape(-1) if numbers.ndim == 0 else numbers
            if numbers.shape != (n_bands,) or n_bands == 0:
                raise SceneError(f"{field.name} must hold one number for each waveband, got shape {numbers.shape}")
            if not np.all(np.isfinite(numbers) & (numbers >= 0)):
                raise SceneError(f"{field.name} must be finite and not negative, got {value!r}")
            if field.name == "wavelength_nm" and numbers.max() > MAX_NM:
                raise SceneError(f"wavelength_nm is at most {MAX_NM:g} nm, got {numbers.max():g}", "write nanometres")
            numbers.flags.writeable = False
            object.__setattr__(self, field.name, numbers)

    @property
    def n_bands(self) -> int:
        """Number of wavebands."""
        return int(self.wavelength_nm.size)


def as_wavebands(value: Wavebands | ArrayLike) -> Wavebands:
    """Wavebands as they are, or those of wavelengths from a caller; wavelengths in micrometres are refused."""
    bands = value if isinstance(value, Wavebands) else Wavebands(value)  # type: ignore[arg-type]
    least = float(bands.wavelength_nm.min())
    if bands is not value and (advice := in_nm(least, f"{least:g}")):
        raise SceneError(advice)
    return bands


def absent_waveband(number: int, wavelength_nm: np.ndarray) -> UsageError:
    """The error for a waveband that does not exist, from 1; a wavelength gets the number of its waveband as advice."""
    n, low, high = wavelength_nm.size, wavelength_nm.min(), wavelength_nm.max()
    there = f"there {'is' if n == 1 else 'are'} {n}, counted from 1, {low:g}{f' to {high:g}' * (n > 1)} nm"
    near = int(np.abs(wavelength_nm - number).argmin())
    is_wavelength = 0.9 * low <= number <= 1.1 * high
    hint = f"; {wavelength_nm[near]:g} nm is waveband {near + 1}" if is_wavelength else ""
    return UsageError(f"there is no waveband {number}; {there}{hint}")


def nearest_wavelength_index(wavelength_nm: ArrayLike, table_wavelength_nm: ArrayLike) -> np.ndarray:
    """Index of the numerically closest table wavelength; a tie goes to the longer one.

    The order of the table does not matter; of equal table wavelengths the first is taken.
    """
    table = np.asarray(table_wavelength_nm, dtype=np.float64)
    bands = np.atleast_1d(floats("wavelength_nm", wavelength_nm))
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
    bands = np.atleast_1d(floats("wavelength_nm", wavelength_nm).astype(np.float32))
    if table.size == 1:
        return np.zeros(bands.size, dtype=np.intp)
    middle = (table[:-1] + table[1:]) / np.float32(2)
    below = bands[:, None] < middle[None, :]
    return np.where(below.any(axis=1), below.argmax(axis=1), table.size - 1)


def listed_bands(wavebands: Sequence[int] | None) -> list[int] | None:
    """The chosen bands, each once, in order."""
    return None if wavebands is None else sorted({as_index(b, "a waveband") for b in wavebands})


def only_bands(n_photons: np.ndarray, wavebands: Sequence[int] | None, wavelength_nm: np.ndarray) -> np.ndarray:
    """Photons of the chosen bands, from 1, and none of the others."""
    if wavebands is None:
        return n_photons
    chosen = listed_bands(wavebands)
    if not chosen:
        raise UsageError(f"no waveband is chosen; there are {n_photons.size}, from 1")
    for number in chosen:
        if not 1 <= number <= n_photons.size:
            raise absent_waveband(number, wavelength_nm)
    kept = np.zeros_like(n_photons)
    index = np.array(chosen) - 1
    kept[index] = n_photons[index]
    return kept
