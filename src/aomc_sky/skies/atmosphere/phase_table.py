"""A phase function given as a table: linear in the scattering angle, of integral 1 by a closed form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True, slots=True)
class PhaseTable:
    """The content of a file, before it is normalised."""

    path: str  #: The file, for messages
    text: str  #: The value of the key that names it
    angle_deg: np.ndarray  #: float64 (n_angle,), from 0, straight on, rising to 180
    wavelength_nm: np.ndarray  #: float64 (n_column,), rising; without meaning where there is one column
    value: np.ndarray  #: float64 (n_column, n_angle), in any unit, 0 or more, none of them 0 everywhere


@dataclass(frozen=True, kw_only=True, slots=True)
class TabulatedPhase:
    """A phase function of some wavelengths, of integral 1 over the sphere; calling it reads the table. Pure."""

    angle_rad: np.ndarray  #: (n_angle,) from 0 to pi
    value: np.ndarray  #: (n_wl, n_angle) [sr-1]
    norm: np.ndarray  #: (n_wl,) integral over the sphere of what the file says, which it was divided by
    norm_error: np.ndarray  #: (n_wl,) what the steps of the angle leave open of it, as a share of it

    def __call__(self, mu: np.ndarray, row: int) -> np.ndarray:
        """Phase function at cosines of scattering angles (n,); one outside by rounding takes the end. [sr-1]"""
        angle = np.arccos(np.clip(np.asarray(mu, dtype=np.float64), -1.0, 1.0))
        return np.asarray(np.interp(angle, self.angle_rad, self.value[row]))


def tabulated_phase(table: PhaseTable, wavelength_nm: np.ndarray) -> TabulatedPhase:
    """Normalise the columns of a table, and interpolate between them, linear in the wavelength.

    The error of the norm is a third of its change when every second angle is left out (Richardson).
    """
    angle = np.radians(table.angle_deg)
    angle[-1] = np.pi
    norm = sphere_integrals(angle, table.value)
    half = np.union1d(np.arange(0, angle.size, 2), [angle.size - 1])
    error = np.abs(sphere_integrals(angle[half], table.value[:, half]) / norm - 1.0) / 3.0
    x = np.clip(wavelength_nm, table.wavelength_nm[0], table.wavelength_nm[-1])
    low = np.clip(np.searchsorted(table.wavelength_nm, x, side="right") - 1, 0, max(table.wavelength_nm.size - 2, 0))
    high = np.minimum(low + 1, table.wavelength_nm.size - 1)
    step = table.wavelength_nm[high] - table.wavelength_nm[low]
    share = np.divide(x - table.wavelength_nm[low], step, out=np.zeros_like(x), where=step > 0.0)

    def between(column: np.ndarray) -> np.ndarray:
        weight = share.reshape(-1, *[1] * (column.ndim - 1))
        return np.asarray((1.0 - weight) * column[low] + weight * column[high])

    value = between(table.value / norm[:, None])
    value.flags.writeable = False
    return TabulatedPhase(angle_rad=angle, value=value, norm=between(norm), norm_error=between(error))


def sphere_integrals(angle_rad: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Integrals over the sphere, (n_column,), of functions (n_column, n_angle) that are linear in the angle.

    A step d around the middle m has the values p and q at its ends. Its integral of the value times sin is (p + q)
    sin(m) sin(d/2) + (q - p) cos(m) (sin(d/2) / (d/2) - cos(d/2)).
    """
    middle, half = 0.5 * (angle_rad[1:] + angle_rad[:-1]), 0.5 * np.diff(angle_rad)
    sine = np.sin(half)
    # below 0.03 the two terms cancel: their series, exact to 1e-17
    square = half * half
    series = square * (1.0 / 3.0 - square * (1.0 / 30.0 - square * (1.0 / 840.0 - square / 45360.0)))
    bent = np.where(half < 0.03, series, sine / half - np.cos(half))
    low, high = value[:, :-1], value[:, 1:]
    terms = (low + high) * (np.sin(middle) * sine) + (high - low) * (np.cos(middle) * bent)
    return np.asarray(2.0 * np.pi * terms.sum(axis=1))
