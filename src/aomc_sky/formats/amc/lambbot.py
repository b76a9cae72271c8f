"""lambbot.inp: the wavebands of a run and the reflectances of the bottom."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from pathlib import Path

import numpy as np

from aomc_sky.formats.amc.band_rows import read_band_rows

_NAMES = (
    "wavelength",
    "bottom reflectance",
    "bottom specular fraction",
    "target reflectance",
    "target specular fraction",
)
_HIGHEST = (inf, 1.0, 1.0, 1.0, 1.0)


@dataclass(frozen=True, kw_only=True, slots=True)
class LambbotTable:
    """Wavelengths [nm] and fractions [0 to 1], float64, shape (n_band,); target columns may be None."""

    wavelength_nm: np.ndarray
    bottom_reflectance: np.ndarray
    bottom_specular_fraction: np.ndarray
    target_reflectance: np.ndarray | None = None
    target_specular_fraction: np.ndarray | None = None


def read_lambbot(
    path: str | Path, *, n_wavebands: int | None = None, has_target: bool = False, lenient: bool = False
) -> LambbotTable:
    """Read lambbot.inp.

    Parameters
    ----------
    path : str or Path
        The file.
    n_wavebands : int, optional
        The count that amc.inp announces, to be compared.
    has_target : bool
        Read the two columns of the bottom target too.
    lenient : bool
        Fractions outside 0 to 1 become warnings.

    Returns
    -------
    LambbotTable
        Extra columns and text after the data are ignored.

    Raises
    ------
    InputFileError
        Every problem of the file.
    """
    n_columns = 5 if has_target else 3
    rows = read_band_rows(path, _NAMES[:n_columns], _HIGHEST[:n_columns], n_wavebands, lenient=lenient)
    rows.flags.writeable = False
    target = (rows[:, 3], rows[:, 4]) if has_target else (None, None)
    return LambbotTable(
        wavelength_nm=rows[:, 0],
        bottom_reflectance=rows[:, 1],
        bottom_specular_fraction=rows[:, 2],
        target_reflectance=target[0],
        target_specular_fraction=target[1],
    )
