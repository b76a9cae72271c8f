"""difcol.inp: share of the direct beam and relative intensity of every waveband (flag 0)."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from pathlib import Path

import numpy as np

from aomc_sky.formats.amc.band_rows import read_band_rows


@dataclass(frozen=True, kw_only=True, slots=True)
class DifcolTable:
    """`direct_fraction` [0 to 1] and `intensity` [0 or more, relative], float64, shape (n_band,)."""

    direct_fraction: np.ndarray
    intensity: np.ndarray


def read_difcol(path: str | Path, *, n_wavebands: int | None = None, lenient: bool = False) -> DifcolTable:
    """Read difcol.inp.

    Parameters
    ----------
    path : str or Path
        The file.
    n_wavebands : int, optional
        The count that amc.inp announces, to be compared.
    lenient : bool
        Accepted for symmetry; a fraction outside 0 to 1 or a negative intensity stays an error,
        because no photons can be shared out by it.

    Returns
    -------
    DifcolTable

    Raises
    ------
    InputFileError
        Every problem of the file.
    """
    rows = read_band_rows(path, ("direct fraction", "intensity"), (1.0, inf), n_wavebands, lenient=False)
    rows.flags.writeable = False
    return DifcolTable(direct_fraction=rows[:, 0], intensity=rows[:, 1])
