"""Skies of an atmosphere under several suns: as a dataset with CF conventions, and as skydist.inp."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import aomc_sky
from aomc_sky.atmosphere.optical_depth import vertical_optical_depth
from aomc_sky.extras import optional_module
from aomc_sky.formats.skydist import Bins, SkyTable, Values, write_skydist
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.manifest import CONVENTIONS
from aomc_sky.outputs.tables.atmosphere_saves import SavedVariables
from aomc_sky.outputs.tables.netcdf import EXTRA, grid_bounds, grid_coordinates, netcdf_bytes
from aomc_sky.skies.atmosphere import AtmosphereSky

_RADIANCE = "W m-2 sr-1 nm-1"
_IRRADIANCE = "W m-2 nm-1"
_PATCHES = ("sun_zenith", "wavelength", "zenith", "azimuth")


def require_netcdf() -> None:
    """Fail before the work, not after it, where the packages for netCDF are not installed."""
    for name in ("xarray", "h5netcdf", "h5py"):
        optional_module(name, extra=EXTRA)


def atmosphere_dataset(skies: Sequence[AtmosphereSky], *, description: str) -> Any:  # xarray.Dataset
    """The skies of one medium and grid under several suns, rising in zenith angle, as an xarray.Dataset.

    Dimensions `sun_zenith`, `wavelength`, `order`, `zenith`, `azimuth` [degree, nm]. `radiance` and
    `standard_error` over sun, wavelength and patch; `radiance_by_order` with the order besides;
    `direct_irradiance`, `diffuse_irradiance`, `direct_normal_irradiance` and `truncation` over sun and
    wavelength; what the medium is over the wavelength. Radiances are means over the patches, weighted with the
    cosine of the zenith angle. `description` is the path of the description, for the attributes.
    """
    xr = optional_module("xarray", extra=EXTRA)
    grid = skies[0].grid
    variables = _light(skies) | _medium(skies[0]) | grid_bounds(grid, "")
    coordinates = grid_coordinates(grid, "") | _axes(skies)
    return xr.Dataset(variables, coordinates, _attributes(skies[0], description))


def _axes(skies: Sequence[AtmosphereSky]) -> dict[str, Any]:
    last = skies[0].n_listed < skies[0].solved.n_orders
    meaning = "number of interactions, the last of them with air; a reflection by the ground is one"
    return {
        "sun_zenith": (
            "sun_zenith",
            np.array([sky.sun_zenith_deg for sky in skies]),
            {"long_name": "zenith angle of the sun", "standard_name": "solar_zenith_angle", "units": "degree"},
        ),
        "wavelength": (
            "wavelength",
            skies[0].medium.wavelength_nm,
            {"long_name": "wavelength in vacuum", "standard_name": "radiation_wavelength", "units": "nm"},
        ),
        "order": (
            "order",
            np.arange(1, skies[0].n_listed + 1),
            {"long_name": meaning + ("; the last row holds all later orders too" if last else ""), "units": "1"},
        ),
    }


def _light(skies: Sequence[AtmosphereSky]) -> dict[str, Any]:
    grid = skies[0].grid
    by_order = np.stack([sky.patch_mean for sky in skies]).reshape(
        len(skies), -1, skies[0].n_listed, grid.n_zenith, grid.n_azimuth
    )
    error = np.stack([sky.patch_error for sky in skies]).reshape(by_order.sum(axis=2).shape)
    mean = "mean over the patch, weighted with the cosine of the zenith angle"
    sun = ("sun_zenith", "wavelength")
    return {
        "radiance": (
            _PATCHES,
            by_order.sum(axis=2),
            {"long_name": f"radiance of the sky without the direct beam, {mean}", "units": _RADIANCE},
        ),
        "standard_error": (
            _PATCHES,
            error,
            {"long_name": "estimated error of the radiance, as a standard deviation", "units": _RADIANCE},
        ),
        "radiance_by_order": (
            ("sun_zenith", "wavelength", "order", "zenith", "azimuth"),
            by_order,
            {"long_name": f"radiance of the sky by the number of interactions, {mean}", "units": _RADIANCE},
        ),
        **{
            name: (sun, np.stack(rows), {"long_name": text, "units": units})
            for name, rows, text, units in (
                (
                    "direct_irradiance",
                    [sky.direct_irradiance for sky in skies],
                    "irradiance of the direct beam on the horizontal ground",
                    _IRRADIANCE,
                ),
                (
                    "direct_normal_irradiance",
                    [sky.solved.direct_normal for sky in skies],
                    "irradiance of the direct beam on a plane normal to it",
                    _IRRADIANCE,
                ),
                (
                    "diffuse_irradiance",
                    [sky.diffuse_irradiance for sky in skies],
                    "irradiance of the sky on the horizontal ground",
                    _IRRADIANCE,
                ),
                (
                    "truncation",
                    [sky.solved.truncation for sky in skies],
                    "estimated share of the sky's irradiance in the orders that were left out",
                    "1",
                ),
            )
        },
    }


def _medium(sky: AtmosphereSky) -> dict[str, Any]:
    medium = sky.medium
    return {
        "solar_irradiance": (
            "wavelength",
            medium.toa_irradiance,
            {"long_name": "irradiance of the sun above the atmosphere, normal to the beam", "units": _IRRADIANCE},
        ),
        "ground_albedo": ("wavelength", medium.ground_albedo, {"long_name": "albedo of the ground", "units": "1"}),
        "optical_depth": (
            ("wavelength", "species"),
            vertical_optical_depth(medium),
            {"long_name": "vertical optical depth of the whole atmosphere by species", "units": "1"},
        ),
        "species": ("species", [part.name for part in medium.constituents], {"long_name": "name of a species"}),
    }


def _attributes(sky: AtmosphereSky, description: str) -> dict[str, Any]:
    return {
        "Conventions": "CF-1.11",
        "title": "Clear sky at sea level of a physical atmosphere",
        "source": f"aomc-sky {aomc_sky.__version__}",
        "description_file": Path(description).name,
        "scattering_orders": sky.solved.n_orders,
        "sun_azimuth_deg": sky.sun_azimuth_deg,
        "sun_angular_radius_deg": float(np.rad2deg(sky.medium.sun_angular_radius_rad)),
        "azimuth_convention": CONVENTIONS["azimuth"],
        "directions": "zenith and azimuth point from the ground to where the light comes from",
    }


def write_atmosphere_netcdf(
    skies: Sequence[AtmosphereSky],
    path: Path,
    *,
    description: str,
    more: SavedVariables | None = None,
    significand_bits: int | None = None,
) -> None:
    """Write the dataset of `atmosphere_dataset` as a netCDF-4 file, whole or not at all.

    With `significand_bits` [1 to 24] all variables but the axes have so many bits, in float32.
    """
    dataset = atmosphere_dataset(skies, description=description)
    if more is not None:
        dataset = dataset.assign(more.variables).assign_coords(more.coordinates)
    if significand_bits is not None:
        _shorten(dataset, significand_bits)
    RunFolder(path.parent).write(path.name, netcdf_bytes(dataset))


def _shorten(dataset: Any, n_bits: int) -> None:
    """Round the variables of a dataset that have units; edges of patches and names stay what they are."""
    for variable in dataset.data_vars.values():
        if "units" in variable.attrs:
            variable.data = rounded_significand(variable.values, n_bits)
    dataset.attrs["significand_bits"] = n_bits


def rounded_significand(values: np.ndarray, n_bits: int) -> np.ndarray:
    """Round to the nearest float32 with significands of so many bits [1 to 24], ties to even.

    Within 2^-n_bits of the values, as a share of them, where these lie in the range of float32's normal numbers,
    1.2e-38 to 3.4e38. Zeros, NaN and infinities stay what they are.
    """
    fraction, exponent = np.frexp(np.asarray(values, dtype=np.float64))
    return np.ldexp(np.rint(np.ldexp(fraction, n_bits)), exponent - n_bits).astype(np.float32)


def write_atmosphere_skydist(sky: AtmosphereSky, path: Path) -> None:
    """Write the patches of one sky, without the direct beam, as skydist.inp.

    Read back it gives the masses of the model again, for mass = radiance x projected solid angle.
    """
    grid = sky.grid
    radiance = sky.patch_mean.sum(axis=1).reshape(-1, grid.n_zenith, grid.n_azimuth)
    table = SkyTable(
        wavelength_nm=sky.medium.wavelength_nm,
        radiance=radiance,
        path=str(path),
    )
    write_skydist(table, path, bins=Bins.EQUAL, values=Values.RADIANCE)
