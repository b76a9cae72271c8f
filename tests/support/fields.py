"""Radiance fields as xarray has them: a value for each wavelength, zenith angle and azimuth."""

import numpy as np
import pytest

from aomc_sky.formats.netcdf import open_netcdf

NM = np.array([440.0, 550.0])
FROM_EAST = {"azimuth_convention": "counterclockwise from east"}


def field_of(values, zenith_deg, azimuth_deg, wavelength_nm=None, *, name="radiance", zenith=None, azimuth=None):
    """A DataArray in degrees, with further attributes of its axes; skips where xarray cannot store one."""
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    axes = {
        "wavelength": ("wavelength", wavelength_nm, {"units": "nm"}),
        "zenith": ("zenith", zenith_deg, {"units": "degree", **(zenith or {})}),
        "azimuth": ("azimuth", azimuth_deg, {"units": "degree", **FROM_EAST, **(azimuth or {})}),
    }
    axes = {axis: given for axis, given in axes.items() if given[1] is not None}
    return xarray.DataArray(np.asarray(values), dims=tuple(axes), coords=axes, name=name)


def through_a_file(made, path, engine="h5netcdf", encoding=None):
    """The dataset that a file of a field holds."""
    pytest.importorskip("h5netcdf")
    made.to_netcdf(path, engine=engine, encoding=encoding)
    with open_netcdf(path, decode_times=False) as (stored, _):
        return stored.load()


def radiance(zenith_deg, azimuth_deg, wavelength_nm):
    """A sky that is brightest at azimuth 100 and redder at the horizon."""
    zenith, azimuth = np.deg2rad(zenith_deg), np.deg2rad(np.asarray(azimuth_deg) - 100)
    return 1 + np.sin(zenith) * (1 + np.cos(azimuth)) * wavelength_nm / 500


def angles_of(dimension, zenith, azimuth):
    return {
        "zenith": (dimension, zenith, {"units": "deg"}),
        "azimuth": (dimension, azimuth, {"units": "deg", **FROM_EAST}),
    }
