"""Radiance fields as xarray has them: a value for each wavelength, zenith angle and azimuth."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike


def field_of(
    values: ArrayLike,
    zenith_deg: ArrayLike,
    azimuth_deg: ArrayLike,
    wavelength_nm: ArrayLike | None = None,
    *,
    name: str = "radiance",
    zenith: dict[str, str] | None = None,
    azimuth: dict[str, str] | None = None,
) -> Any:
    """A DataArray in degrees, with further attributes of its axes; skips where xarray cannot store one."""
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    axes = {
        "wavelength": ("wavelength", wavelength_nm, {"units": "nm"}),
        "zenith": ("zenith", zenith_deg, {"units": "degree", **(zenith or {})}),
        "azimuth": ("azimuth", azimuth_deg, {"units": "degree", **(azimuth or {})}),
    }
    axes = {axis: given for axis, given in axes.items() if given[1] is not None}
    return xarray.DataArray(np.asarray(values), dims=tuple(axes), coords=axes, name=name)
