"""More about the skies of an atmosphere, on demand: orders, source functions, the light of the ground, X, Y, Z, W."""

from __future__ import annotations

import dataclasses
import os
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from aomc_sky.atmosphere.backward.monte_carlo import solve_paths
from aomc_sky.atmosphere.medium import Medium
from aomc_sky.atmosphere.scattering_orders.diffuse import source_functions
from aomc_sky.errors import ModelLimitWarning, UsageError
from aomc_sky.extras import optional_module
from aomc_sky.skies.atmosphere import AtmosphereSky

EXTRA = "colour"
"""The extra that installs colour-science."""

PHOTOPIC_LM_W, SCOTOPIC_LM_W = 683.0, 1700.0
"""Luminous efficacies at the peaks of the eye's daylight and night functions. [lm W-1]"""

COMPONENTS = ("X", "Y", "Z", "W")

_TABLE_NM = np.arange(360.0, 831.0)
_WIDEST_STEP_NM = 20.0
_MISSED = 0.01


def require_colour() -> None:
    """Fail before the work where colour-science is not installed."""
    optional_module("colour", extra=EXTRA)


def xyzw_weights(wavelength_nm: np.ndarray) -> np.ndarray:
    """Factors (n_wl, 4) by which spectral radiances at rising wavelengths add up to X, Y, Z and W.

    In cd m-2 per W m-2 sr-1 nm-1: Y is the luminance with 683 lm W-1, W the scotopic one with 1700 lm W-1.
    The spectrum is linear between the wavelengths and zero outside them. Its products with the CIE 1931 2-degree
    colour-matching functions and the CIE 1951 scotopic function are summed in steps of 1 nm, 360 to 830 nm
    (CIE 15:2018, section 7.1), so that wide steps of the radiance do not cut the functions.
    """
    between = np.stack([np.interp(_TABLE_NM, wavelength_nm, row, 0.0, 0.0) for row in np.eye(wavelength_nm.size)])
    return between @ _eye()


def check_wavelengths(wavelength_nm: np.ndarray) -> None:
    """Refuse rising wavelengths that no colour follows from, and warn of those that it follows from badly.

    Refused: fewer than two. Warned of: steps wider than 20 nm, or more than 1 % of an equal-energy spectrum's
    X, Y, Z or W outside the wavelengths.
    """
    require_colour()
    if wavelength_nm.size < 2:
        raise UsageError("X, Y, Z and W are sums over a spectrum: they need two wavelengths or more")
    widest = float(np.diff(wavelength_nm).max())
    inside = xyzw_weights(wavelength_nm).sum(axis=0) / _eye().sum(axis=0)
    if widest > _WIDEST_STEP_NM:
        text = f"wavelengths are up to {widest:.4g} nm apart; X, Y, Z and W want {_WIDEST_STEP_NM:g} nm or less"
        warnings.warn(text, ModelLimitWarning, stacklevel=2)
    if inside.min() < 1.0 - _MISSED:
        missed = ", ".join(f"{name} {100 * (1 - share):.2g} %" for name, share in zip(COMPONENTS, inside, strict=True))
        text = f"of an even spectrum so much lies outside the wavelengths and is missing: {missed}"
        warnings.warn(text, ModelLimitWarning, stacklevel=2)


def xyzw(radiance: np.ndarray, wavelength_nm: np.ndarray) -> np.ndarray:
    """X, Y, Z and W, (..., 4) [cd m-2], of spectral radiances (..., n_wl) [W m-2 sr-1 nm-1]."""
    return np.asarray(radiance @ xyzw_weights(wavelength_nm))


def _eye() -> np.ndarray:
    """Colour-matching functions and scotopic function with their efficacies and the step, (n, 4). [lm W-1 nm]"""
    colour = optional_module("colour", extra=EXTRA)
    matching = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    night = optional_module("colour.colorimetry", extra=EXTRA).SDS_LEFS["CIE 1951 Scotopic Standard Observer"]
    columns = [
        PHOTOPIC_LM_W * np.interp(_TABLE_NM, matching.wavelengths, matching.values[:, k], 0.0, 0.0) for k in range(3)
    ]
    columns.append(SCOTOPIC_LM_W * np.interp(_TABLE_NM, night.wavelengths, night.values, 0.0, 0.0))
    return np.stack(columns, axis=1)


SOURCE_DEG = np.arange(0.0, 181.0, 15.0)
"""Zenith angles, and azimuths from the sun, of source functions. [deg]"""

MOST_SOURCES = 200 * SOURCE_DEG.size**2
"""Values of one source function at most: a column has less than 200 nodes."""

GLOW_PATHS = 20_000
"""Paths of each zenith angle and wavelength of the light of the ground."""

_PATCHES = ("sun_zenith", "wavelength", "zenith", "azimuth")
_SOURCE_UNITS = "W m-3 sr-1 nm-1"
_GLOW_UNITS = "W m-2 sr-1 nm-1 per cd m-2"


@dataclass(frozen=True, kw_only=True, slots=True)
class Saves:
    """What is wanted besides radiances and irradiances."""

    irradiance: bool = False  #: irradiances order by order
    source_from_ground: bool = False  #: source function of order 2, of light that the ground sends up
    source: bool = False  #: source functions of orders 2 and up
    cumulative: bool = False  #: radiance of all orders up to each
    glow: bool = False  #: radiance of the light that a ground of 1 cd m-2 gives off by itself, order by order
    xyzw: bool = False  #: X, Y, Z and scotopic luminance

    @property
    def any_source(self) -> bool:
        """Whether source functions are worked out."""
        return self.source or self.source_from_ground


def check_saves(saves: Saves, *, wavelength_nm: np.ndarray, methods: Sequence[str], glow: np.ndarray | None) -> None:
    """Refuse before the work what cannot be saved, and warn as `check_wavelengths` does.

    `wavelength_nm` rises; `methods` are those of the suns; `glow` is the radiance of a ground of 1 cd m-2, where the
    description has it.
    """
    if saves.any_source and "sos" not in methods:
        raise UsageError("source functions are known to --method sos and two orders or more; no sun is solved so")
    if saves.glow and (glow is None or not np.any(glow > 0)):
        raise UsageError('--save-light-pollution: the description has no "light pollution relative radiance" above 0')
    if saves.xyzw:
        check_wavelengths(wavelength_nm)


@dataclass(kw_only=True, slots=True)
class SavedVariables:
    """Variables and coordinates of a dataset, as xarray takes them: dimensions, values, attributes."""

    variables: dict[str, Any] = field(default_factory=dict)
    coordinates: dict[str, Any] = field(default_factory=dict)


def saved_variables(
    skies: Sequence[AtmosphereSky], saves: Saves, *, glow: np.ndarray | None = None, n_glow_rows: int = 1
) -> SavedVariables:
    """Work out what is wanted besides, for skies of one medium and grid.

    Source functions are those of skies of method "sos", NaN under other suns. `glow` (n_wl,), the radiance of a
    ground of 1 cd m-2 [W m-2 sr-1 nm-1], is needed with `saves.glow`; its light has `n_glow_rows` zenith angles.
    """
    saved = SavedVariables()
    if saves.irradiance:
        saved.variables |= _irradiance(skies)
    if saves.cumulative:
        saved.variables |= _cumulative(skies)
    if saves.xyzw:
        _add_xyzw(saved, skies)
    if saves.any_source:
        _add_sources(saved, skies, saves)
    if saves.glow:
        assert glow is not None, "the caller has asked for it"
        _add_glow(saved, skies[0].medium, glow, n_glow_rows, skies[0].solved.n_orders)
    return saved


def _by_order(skies: Sequence[AtmosphereSky]) -> np.ndarray:
    grid = skies[0].grid
    shape = (len(skies), -1, skies[0].n_listed, grid.n_zenith, grid.n_azimuth)
    return np.stack([sky.patch_mean for sky in skies]).reshape(shape)


def _irradiance(skies: Sequence[AtmosphereSky]) -> dict[str, Any]:
    area = skies[0].grid.projected_solid_angle_sr
    values = np.stack([sky.patch_mean @ area for sky in skies])
    text = "irradiance of the sky on the horizontal ground by the number of interactions"
    dimensions = ("sun_zenith", "wavelength", "order")
    return {"irradiance_by_order": (dimensions, values, {"long_name": text, "units": "W m-2 nm-1"})}


def _cumulative(skies: Sequence[AtmosphereSky]) -> dict[str, Any]:
    text = "radiance of the sky of all orders up to this one, mean over the patch"
    dimensions = ("sun_zenith", "wavelength", "order", "zenith", "azimuth")
    values = np.cumsum(_by_order(skies), axis=2)
    return {"radiance_up_to_order": (dimensions, values, {"long_name": text, "units": "W m-2 sr-1 nm-1"})}


def _add_xyzw(saved: SavedVariables, skies: Sequence[AtmosphereSky]) -> None:
    radiance = np.moveaxis(_by_order(skies).sum(axis=2), 1, -1)
    text = (
        "CIE 1931 2-degree X, Y, Z with 683 lm W-1 (Y is the luminance) and scotopic luminance W with 1700 lm W-1, "
        "mean over the patch"
    )
    dimensions = (*(name for name in _PATCHES if name != "wavelength"), "eye")
    values = xyzw(radiance, skies[0].medium.wavelength_nm)
    saved.variables["xyzw"] = (dimensions, values, {"long_name": text, "units": "cd m-2"})
    saved.coordinates["eye"] = ("eye", list(COMPONENTS), {"long_name": "response of the eye"})


def _add_sources(saved: SavedVariables, skies: Sequence[AtmosphereSky], saves: Saves) -> None:
    angle = np.deg2rad(SOURCE_DEG)
    solved = {
        k: source_functions(sky.medium, np.deg2rad(sky.sun_zenith_deg), angle, angle, n_orders=max(sky.n_listed, 2))
        for k, sky in enumerate(skies)
        if sky.solved.method == "sos" and sky.solved.more is not None
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
        saved.variables["source_by_order"] = (dimensions, by_order, {"long_name": text, "units": _SOURCE_UNITS})
        saved.coordinates |= {
            "source_order": _axis("source_order", np.arange(2, 2 + by_order.shape[2]), "interactions", "1"),
            "source_azimuth": _axis("source_azimuth", SOURCE_DEG, "azimuth from the sun", "degree"),
        }
    if saves.source_from_ground:
        text = "light that a volume of air scatters into order 2 out of the direct beam reflected by the ground"
        saved.variables["source_from_ground"] = (
            ("sun_zenith", "wavelength", "altitude", "source_zenith"),
            from_ground,
            {"long_name": text, "units": _SOURCE_UNITS},
        )
    saved.coordinates |= {
        "altitude": _axis("altitude", some.altitude_m, "altitude above the ground", "m"),
        "source_zenith": _axis("source_zenith", SOURCE_DEG, "zenith angle looked into; beyond 90 down", "degree"),
    }


def _add_glow(saved: SavedVariables, medium: Medium, glow: np.ndarray, n_rows: int, n_orders: int) -> None:
    zenith = (np.arange(n_rows) + 0.5) * 90.0 / n_rows
    light = solve_paths(
        _unlit(medium), sun_zenith_rad=0.0, sky_zenith_rad=np.deg2rad(zenith), azimuth_from_sun_rad=np.zeros(n_rows),
        n_paths=GLOW_PATHS, n_orders=n_orders, ground_radiance=glow, threads=os.cpu_count() or 1,
    )  # fmt: skip
    dimensions = ("wavelength", "glow_order", "glow_zenith")
    text = "radiance of the sky by the light of a ground of luminance 1 cd m-2, by the number of interactions"
    saved.variables["glow_by_order"] = (dimensions, light.radiance_by_order, {"long_name": text, "units": _GLOW_UNITS})
    saved.variables["glow_standard_error"] = (
        dimensions,
        light.standard_error_by_order,
        {"long_name": "standard error of glow_by_order", "units": _GLOW_UNITS},
    )
    saved.coordinates |= {
        "glow_order": _axis(
            "glow_order", np.arange(1, 1 + light.radiance_by_order.shape[1]), "interactions after the ground", "1"
        ),
        "glow_zenith": _axis("glow_zenith", zenith, "zenith angle looked into", "degree"),
    }


def _unlit(medium: Medium) -> Medium:
    """The medium at night: without a sun."""
    return dataclasses.replace(medium, toa_irradiance=np.zeros_like(medium.toa_irradiance))


def _axis(name: str, values: np.ndarray, text: str, units: str) -> tuple[str, np.ndarray, dict[str, str]]:
    return name, values, {"long_name": text, "units": units}
