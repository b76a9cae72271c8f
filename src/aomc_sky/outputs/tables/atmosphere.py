"""Skies of an atmosphere under several suns: as a dataset with CF conventions, and as skydist.inp.

Optional are orders, source functions and the light of the ground.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import aomc_sky
from aomc_sky.errors import UsageError
from aomc_sky.extras import optional_module
from aomc_sky.formats.aomc.skydist import Bins, SkyTable, Values, write_skydist
from aomc_sky.formats.netcdf import EXTRA
from aomc_sky.outputs.manifest import CONVENTIONS
from aomc_sky.outputs.run_folder import RunFolder
from aomc_sky.outputs.tables.netcdf import Table, Variable, grid_bounds, grid_coordinates, netcdf_bytes, variable
from aomc_sky.skies.atmosphere.backward import seed_of, solve_paths
from aomc_sky.skies.atmosphere.medium import unlit
from aomc_sky.skies.atmosphere.model import AtmosphereSky
from aomc_sky.skies.atmosphere.optical_depth import vertical_optical_depth
from aomc_sky.skies.atmosphere.scattering_orders.diffuse import source_functions

_RADIANCE = "W m-2 sr-1 nm-1"
_IRRADIANCE = "W m-2 nm-1"
_PATCHES = ("sun_zenith", "wavelength", "zenith", "azimuth")
_ORDERS = ("sun_zenith", "wavelength", "order", "zenith", "azimuth")


def require_netcdf() -> None:
    """Raise MissingExtraError, before the work, if the packages for netCDF are not installed."""
    for name in ("h5netcdf", "h5py"):
        optional_module(name, extra=EXTRA)


def _table(skies: Sequence[AtmosphereSky], description: str) -> Table:
    """Over `sun_zenith`, `wavelength`, `order`, `zenith`, `azimuth` [degree, nm]; radiances are means of patches."""
    sky, grid = skies[0], skies[0].grid
    variables = _light(skies) | _medium(sky) | grid_bounds(grid, "")
    last = "; the last row holds all later orders too" if sky.n_listed < sky.solved.n_orders else ""
    meaning = f"number of interactions, the last of them with air; a reflection by the ground is one{last}"
    suns, wavelength = np.array([one.sun_zenith_deg for one in skies]), sky.medium.wavelength_nm
    coordinates = grid_coordinates(grid, "") | {
        "sun_zenith": variable(
            "sun_zenith", suns, "zenith angle of the sun", "degree", standard_name="solar_zenith_angle"
        ),
        "wavelength": variable(
            "wavelength", wavelength, "wavelength in vacuum", "nm", standard_name="radiation_wavelength"
        ),
        "order": variable("order", np.arange(1, sky.n_listed + 1), meaning, "1"),
    }
    one_sun = {"sun_zenith_deg": sky.sun_zenith_deg} if len(skies) == 1 else {}
    return Table(variables, coordinates, {**_attributes(sky, description), **one_sun})


def _by_order(skies: Sequence[AtmosphereSky]) -> np.ndarray:
    grid = skies[0].grid
    shape = (len(skies), -1, skies[0].n_listed, grid.n_zenith, grid.n_azimuth)
    return np.stack([sky.patch_mean for sky in skies]).reshape(shape)


def _light(skies: Sequence[AtmosphereSky]) -> dict[str, Variable]:
    by_order = _by_order(skies)
    radiance = by_order.sum(axis=2)
    error = np.stack([sky.patch_error for sky in skies]).reshape(radiance.shape)
    mean = "mean over the patch, weighted with the cosine of the zenith angle"
    error_text = "estimated error of the radiance, as a standard deviation"
    beam, suns = "irradiance of the direct beam on", ("sun_zenith", "wavelength")

    def per_sun(rows: Iterable[np.ndarray], text: str, unit: str = _IRRADIANCE) -> Variable:
        return variable(suns, np.stack(list(rows)), text, unit)

    left_out = "estimated share of the sky's irradiance in the orders that were left out"
    return {
        "radiance": variable(_PATCHES, radiance, f"radiance of the sky without the direct beam, {mean}", _RADIANCE),
        "standard_error": variable(_PATCHES, error, error_text, _RADIANCE),
        "radiance_by_order": variable(
            _ORDERS, by_order, f"radiance of the sky by the number of interactions, {mean}", _RADIANCE
        ),
        "direct_irradiance": per_sun((sky.direct_irradiance for sky in skies), f"{beam} the horizontal ground"),
        "direct_normal_irradiance": per_sun((s.solved.direct_normal for s in skies), f"{beam} a plane normal to it"),
        "diffuse_irradiance": per_sun(
            (sky.diffuse_irradiance for sky in skies), "irradiance of the sky on the horizontal ground"
        ),
        "truncation": per_sun((sky.solved.truncation for sky in skies), left_out, "1"),
    }


def _medium(sky: AtmosphereSky) -> dict[str, Variable]:
    medium = sky.medium
    toa, depth = "irradiance of the sun above the atmosphere, normal to the beam", vertical_optical_depth(medium)
    depth_text = "vertical optical depth of the whole atmosphere by species"
    return {
        "solar_irradiance": variable("wavelength", medium.toa_irradiance, toa, _IRRADIANCE),
        "ground_albedo": variable("wavelength", medium.ground_albedo, "albedo of the ground", "1"),
        "optical_depth": variable(("wavelength", "species"), depth, depth_text, "1"),
        "species": variable("species", [part.name for part in medium.constituents], "name of a species"),
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
    saves: Saves,
    glow: np.ndarray | None = None,
    n_glow_rows: int = 1,
    significand_bits: int | None = None,
) -> None:
    """Write skies of one medium and grid under several suns, rising in zenith angle, atomically.

    `description` is the path of the description. Source functions are NaN for skies of other methods than "sos". The
    table of `saves.glow` needs `glow` (n_wl,), the radiance of a ground of 1 cd m-2 [W m-2 sr-1 nm-1], and has
    `n_glow_rows` zenith angles. All variables except the axes are rounded to `significand_bits` [1 to 24], in float32.
    """
    table = _table(skies, description)
    variables, axes = table.variables, table.coordinates
    if saves.irradiance:
        _add_irradiance(variables, skies)
    if saves.cumulative:
        text = "radiance of the sky of all orders up to this one, mean over the patch"
        variables["radiance_up_to_order"] = variable(_ORDERS, np.cumsum(_by_order(skies), axis=2), text, _RADIANCE)
    if saves.any_source:
        _add_sources(variables, axes, skies, saves)
    if saves.glow:
        assert glow is not None, "the caller has asked for it"
        _add_glow(variables, axes, skies[0], glow, n_glow_rows)
    if significand_bits is not None:
        for name, (dimensions, values, *attributes) in variables.items():
            if attributes and "units" in attributes[0]:  # edges of patches and names have none
                variables[name] = (dimensions, rounded_significand(values, significand_bits), *attributes)
        table.attributes["significand_bits"] = significand_bits
    RunFolder(path.parent).write(path.name, netcdf_bytes(table))


def rounded_significand(values: np.ndarray, n_bits: int) -> np.ndarray:
    """Round to the nearest float32 with significands of `n_bits` [1 to 24], ties to even.

    The relative error is at most 2^-n_bits for normal numbers of float32, 1.2e-38 to 3.4e38. Zeros, NaN and infinities
    do not change.
    """
    fraction, exponent = np.frexp(np.asarray(values, dtype=np.float64))
    return np.ldexp(np.rint(np.ldexp(fraction, n_bits)), exponent - n_bits).astype(np.float32)


def write_atmosphere_skydist(sky: AtmosphereSky, path: Path) -> None:
    """Write the patches of one sky, without the direct beam, as skydist.inp.

    Mass = radiance x projected solid angle, so a scene that reads the table has the masses of the model.
    """
    radiance = sky.patch_mean.sum(axis=1).reshape(-1, sky.grid.n_zenith, sky.grid.n_azimuth)
    table = SkyTable(wavelength_nm=sky.medium.wavelength_nm, radiance=radiance, path=str(path))
    write_skydist(table, path, bins=Bins.EQUAL, values=Values.RADIANCE)


SOURCE_DEG = np.arange(0.0, 181.0, 15.0)
"""Zenith angles, and azimuths from the sun, of source functions. [deg]"""

MOST_SOURCES = 200 * SOURCE_DEG.size**2
"""Values of one source function at most: a column has less than 200 nodes."""

GLOW_PATHS = 20_000
"""Paths of each zenith angle and wavelength of the light of the ground."""

_SOURCE = "W m-3 sr-1 nm-1"
_GLOW_UNITS = "W m-2 sr-1 nm-1 per cd m-2"


@dataclass(frozen=True, kw_only=True, slots=True)
class Saves:
    """Optional contents besides radiances and irradiances."""

    irradiance: bool = False  #: irradiances order by order
    source_from_ground: bool = False  #: source function of order 2, of light that the ground reflects
    source: bool = False  #: source functions of orders 2 and up
    cumulative: bool = False  #: radiance of all orders up to each
    glow: bool = False  #: radiance of light that a ground of 1 cd m-2 emits, order by order

    @property
    def any_source(self) -> bool:
        """Whether source functions are worked out."""
        return self.source or self.source_from_ground


def check_saves(saves: Saves, *, methods: Sequence[str], glow: np.ndarray | None) -> None:
    """Refuse, before the work, what the suns' `methods` or the radiance of a ground of 1 cd m-2 cannot give."""
    if saves.any_source and "sos" not in methods:
        raise UsageError("source functions need --method sos and two orders or more; no sun is solved in this way")
    if saves.glow and (glow is None or not np.any(glow > 0)):
        raise UsageError('--save-light-pollution: the description has no "light pollution relative radiance" above 0')


def _add_irradiance(variables: dict[str, Any], skies: Sequence[AtmosphereSky]) -> None:
    area = skies[0].grid.projected_solid_angle_sr
    values = np.stack([sky.patch_mean @ area for sky in skies])
    text = "irradiance of the sky on the horizontal ground by the number of interactions"
    variables["irradiance_by_order"] = variable(("sun_zenith", "wavelength", "order"), values, text, _IRRADIANCE)


def _add_sources(
    variables: dict[str, Any], axes: dict[str, Variable], skies: Sequence[AtmosphereSky], saves: Saves
) -> None:
    angle = np.deg2rad(SOURCE_DEG)
    solved = {
        k: source_functions(sky.medium, np.deg2rad(sky.sun_zenith_deg), angle, angle, n_orders=max(sky.n_listed, 2))
        for k, sky in enumerate(skies)
        if sky.solved.method == "sos" and sky.solved.later_orders is not None
    }
    if not solved:
        return
    some = next(iter(solved.values()))
    by_order = np.full((len(skies), *some.by_order.shape), np.nan)
    from_ground = np.full((len(skies), *some.from_ground.shape), np.nan)
    for k, each in solved.items():
        by_order[k], from_ground[k] = each.by_order, each.from_ground
    if saves.source:
        dimensions = ("sun_zenith", "wavelength", "source_order", "altitude", "source_zenith", "source_azimuth")
        text = "light that a volume of air scatters into an order, where one looks to see it"
        variables["source_by_order"] = variable(dimensions, by_order, text, _SOURCE)
        orders = np.arange(2, 2 + by_order.shape[2])
        axes["source_order"] = variable("source_order", orders, "interactions", "1")
        axes["source_azimuth"] = variable("source_azimuth", SOURCE_DEG, "azimuth from the sun", "degree")
    if saves.source_from_ground:
        text = "light that a volume of air scatters into order 2 out of the direct beam reflected by the ground"
        axes_of_ground = ("sun_zenith", "wavelength", "altitude", "source_zenith")
        variables["source_from_ground"] = variable(axes_of_ground, from_ground, text, _SOURCE)
    axes["altitude"] = variable("altitude", some.altitude_m, "altitude above the ground", "m")
    text = "zenith angle looked into; beyond 90 down"
    axes["source_zenith"] = variable("source_zenith", SOURCE_DEG, text, "degree")


def _add_glow(
    variables: dict[str, Any], axes: dict[str, Variable], sky: AtmosphereSky, glow: np.ndarray, n_rows: int
) -> None:
    zenith = (np.arange(n_rows) + 0.5) * 90.0 / n_rows
    light = solve_paths(
        unlit(sky.medium), sun_zenith_rad=0.0, sky_zenith_rad=np.deg2rad(zenith), azimuth_from_sun_rad=np.zeros(n_rows),
        n_paths=GLOW_PATHS, n_orders=sky.solved.n_orders, seed=seed_of(0, sky.seed), ground_radiance=glow,
        threads=os.cpu_count() or 1,
    )  # fmt: skip
    dimensions, values = ("wavelength", "glow_order", "glow_zenith"), light.radiance_by_order
    errors = light.standard_error_by_order
    text = "radiance of the sky by the light of a ground of luminance 1 cd m-2, by the number of interactions"
    variables["glow_by_order"] = variable(dimensions, values, text, _GLOW_UNITS)
    variables["glow_standard_error"] = variable(dimensions, errors, "standard error of glow_by_order", _GLOW_UNITS)
    orders = np.arange(1, 1 + values.shape[1])
    axes["glow_order"] = variable("glow_order", orders, "interactions after the ground", "1")
    axes["glow_zenith"] = variable("glow_zenith", zenith, "zenith angle looked into", "degree")
