"""Radiance of a clear sky at sea level in given directions: order 1 through shells, and successive orders."""

from __future__ import annotations

import dataclasses
import os
import time
import warnings
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.atmosphere.backward.monte_carlo import solve_paths
from aomc_sky.atmosphere.backward.result import MOST_LISTED, PathsResult
from aomc_sky.atmosphere.lights.moon import Moon
from aomc_sky.atmosphere.medium.constituents import Medium
from aomc_sky.atmosphere.numerics.sky_field import azimuth_basis
from aomc_sky.atmosphere.order_one.eclipse import solve_eclipsed_order_one
from aomc_sky.atmosphere.order_one.radiance import solve_order_one
from aomc_sky.atmosphere.sky.means import patch_means
from aomc_sky.atmosphere.sky.method import chosen_lights
from aomc_sky.atmosphere.sky.solve_sky import SkyAndRings, relative_errors, solve_sky_and_rings
from aomc_sky.atmosphere.sky.solved import SolvedSky
from aomc_sky.errors import ModelLimitWarning, UsageError
from aomc_sky.grid import PatchGrid

_FLUX_BINS = (45, 72)
_FLUX_BINS_TWILIGHT = (18, 12)
_FLUX_TOLERANCE = 1e-4

MOST_PATHS, FEWEST_PATHS = 65536, 4096
"""Paths of each direction and wavelength: the first, unless all directions together had more than `ALL_PATHS`."""

ALL_PATHS = 512 * MOST_PATHS

_MODEL_ERROR = 2e-4
"""Of tables and shells, as a share of the light that paths bring."""


@dataclass(frozen=True, kw_only=True, slots=True)
class AtmosphereResult:
    """What a solution of an atmosphere brings, in the directions asked for.

    Parameters
    ----------
    wavelength_nm : ndarray, float64, shape (n_wl,)
        Wavelengths. [nm]
    radiance : ndarray, float64, shape (n_wl, n_zenith, n_azimuth)
        Of the sky without the direct beam, all orders that count. [W m-2 sr-1 nm-1]
    radiance_by_order : ndarray, float64, shape (n_wl, n_order, n_zenith, n_azimuth)
        The same by number of interactions, 1 first; where more than 24 count, row 24 holds all the later ones.
    standard_error : ndarray, float64, shape (n_wl, n_zenith, n_azimuth)
        Estimated error of the radiance as a standard deviation; light in orders left out is no part of it.
    direct_irradiance, diffuse_irradiance : ndarray, float64, shape (n_wl,)
        On the horizontal ground, of the beam and of the sky. [W m-2 nm-1]
    truncation : ndarray, float64, shape (n_wl,)
        Estimated share of the sky's irradiance in the orders that were left out; NaN for order 1 alone.
    method : str
        "order1", "sos" or "mc".
    n_orders : int
        Most interactions that count.
    dropped : tuple of str
        What the atmosphere has and the solution has not.
    seconds : dict of str to float
        Time that each part of the work took. [s]
    under_sampled : ndarray, bool, shape (n_wl, n_zenith, n_azimuth), or None
        Of "mc": where hardly any path reaches the air that the sun lights, and the error may be larger than stated; see
        `aomc_sky.atmosphere.backward.monte_carlo.solve_paths`. None where no path was followed for the sun's light.
    """

    wavelength_nm: np.ndarray
    radiance: np.ndarray
    radiance_by_order: np.ndarray
    standard_error: np.ndarray
    direct_irradiance: np.ndarray
    diffuse_irradiance: np.ndarray
    truncation: np.ndarray
    method: str
    n_orders: int
    dropped: tuple[str, ...] = ()
    seconds: dict[str, float] = field(default_factory=dict)
    under_sampled: np.ndarray | None = None


def solve(
    medium: Medium,
    *,
    sun_zenith_rad: float,
    sky_zenith_rad: ArrayLike,
    azimuth_from_sun_rad: ArrayLike,
    method: str = "auto",
    n_orders: int | None = None,
    dropped: tuple[str, ...] = (),
    moon: Moon | None = None,
    ground_radiance: np.ndarray | None = None,
    n_paths: int | None = None,
) -> AtmosphereResult:
    """Solve an atmosphere in the directions asked for, on all pairs of zenith angles and azimuths.

    Azimuths are counted from the sun's; arguments and errors as of `solve_sky`, `dropped` is what the maker of the
    medium left out, for the result.

    No interpolation: every direction is solved. Azimuths left and right of the sun are one, so half of them are, unless
    the Moon stands beside the sun's vertical plane. "mc" follows 65536 paths in each direction and wavelength, fewer
    where more than 512 directions are asked for, 4096 at least; two suns have numbers of their own. The irradiance of
    the sky is that of patches, good to 1e-4, and of "mc" has the noise of the whole sky's paths.
    """
    started = time.perf_counter()
    zenith, azimuth = _angles(sky_zenith_rad, "zenith angles"), _angles(azimuth_from_sun_rad, "azimuths")
    if not np.all((zenith >= 0) & (zenith <= np.pi / 2 * (1 + 1e-15))):
        raise UsageError("zenith angles looked into must lie within 0 and 90 degrees")
    lights = chosen_lights(
        medium, sun_zenith_rad, method=method, n_orders=n_orders, moon=moon, ground_radiance=ground_radiance,
        n_paths=n_paths,
    )  # fmt: skip
    rings, ring = np.unique(np.minimum(zenith, np.pi / 2), return_inverse=True)
    found = solve_sky_and_rings(medium, sun_zenith_rad, rings, lights, n_listed=MOST_LISTED)
    sky = found.sky
    grid = PatchGrid.regular(*(_FLUX_BINS if sun_zenith_rad <= np.pi / 2 else _FLUX_BINS_TWILIGHT))
    mean, _ = patch_means(sky, grid, 0.0, tolerance=_FLUX_TOLERANCE)
    after_flux = time.perf_counter()
    by_order, error, flagged = _by_order(found, rings, azimuth, lights.n_paths)
    by_order, error = by_order[:, :, ring], error[:, ring]
    if found.glow is not None:
        by_order = by_order + found.glow[:, :, ring, None]
        error = np.hypot(error, sky.glow_error * found.glow.sum(axis=1)[:, ring, None])
    return AtmosphereResult(
        wavelength_nm=medium.wavelength_nm,
        radiance=by_order.sum(axis=1),
        radiance_by_order=by_order,
        standard_error=error,
        direct_irradiance=sky.direct_irradiance,
        diffuse_irradiance=mean.sum(axis=1) @ grid.projected_solid_angle_sr,
        truncation=sky.truncation,
        method=sky.method,
        n_orders=sky.n_orders,
        dropped=dropped,
        seconds={"irradiance": after_flux - started, "directions": time.perf_counter() - after_flux},
        under_sampled=None if flagged is None else flagged[:, ring],
    )


def _angles(given: ArrayLike, what: str) -> np.ndarray:
    angles = np.atleast_1d(np.asarray(given, dtype=np.float64))
    if angles.ndim != 1 or not angles.size or not np.all(np.isfinite(angles)):
        raise UsageError(f"{what} looked into must be finite numbers in one row")
    return angles


def _by_order(
    found: SkyAndRings, rings: np.ndarray, azimuth: np.ndarray, n_paths: int | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """The sun's light by order on all pairs, (n_wl, n_order, n_ring, n_azimuth), its error, and whether it is flagged.

    A distinct azimuth is worked out once.
    """
    sky = found.sky
    turned = np.fmod(azimuth, 2 * np.pi)  # exact, so that mirror images stay so to the bit
    turned -= np.where(np.abs(turned) > np.pi, np.copysign(2 * np.pi, turned), 0.0)
    columns, column = np.unique(np.round(np.abs(turned) if sky.is_mirrored else turned, 15), return_inverse=True)
    theta, phi = (angle.ravel() for angle in np.meshgrid(rings, columns, indexing="ij"))
    shape = rings.size, columns.size
    if sky.method == "mc" and sky.more is not None:
        paths = directed_paths(sky, theta, phi, n_paths)
        rows = paths.radiance_by_order.reshape(*paths.radiance_by_order.shape[:2], *shape)
        error, flagged = (each.reshape(-1, *shape)[..., column] for each in (paths.standard_error, paths.under_sampled))
        return rows[..., column], error, flagged
    if sky.moon is None:
        once = solve_order_one(sky.medium, sky.sun_zenith_rad, theta, phi)
    else:
        once = solve_eclipsed_order_one(sky.medium, sky.sun_zenith_rad, theta, phi, sky.moon)
    rows = np.zeros((once.shape[0], sky.n_listed, *shape))
    rows[:, 0] = once.reshape(-1, *shape)
    if found.later is not None:
        terms = azimuth_basis(columns, found.later.shape[2], is_mirrored=sky.is_mirrored)
        rows[:, 1:] = np.maximum(found.later.swapaxes(2, 3) @ terms.T, 0.0)
    once_error, later_error = relative_errors(sky)
    error = np.hypot(once_error * rows.sum(axis=1), later_error * rows[:, 1:].sum(axis=1))
    return rows[..., column], error[..., column], None


def directed_paths(
    sky: SolvedSky, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray, n_paths: int | None = None
) -> PathsResult:
    """Follow paths in single directions.

    `n_paths` None is as many as the number of directions allows. The result's `standard_error` has 2e-4 of orders 2 and
    up besides the scatter of the paths; it warns of directions whose error is not to be trusted.

    The random numbers are those of the sun: two suns have errors of their own, and the whole sky others again.
    """
    found = solve_paths(
        sky.medium, sun_zenith_rad=sky.sun_zenith_rad, sky_zenith_rad=sky_zenith_rad,
        azimuth_from_sun_rad=azimuth_from_sun_rad, n_orders=sky.n_orders, visible=sky.moon, seed=_seed(sky),
        n_paths=n_paths or int(np.clip(ALL_PATHS // max(sky_zenith_rad.size, 1), FEWEST_PATHS, MOST_PATHS)),
        threads=os.cpu_count() or 1,
    )  # fmt: skip
    if found.under_sampled.any():
        warnings.warn(
            f"in {found.under_sampled.sum()} of {found.under_sampled.size} directions and wavelengths looked into "
            "hardly any path reaches the air that the sun lights; errors there may be larger than stated",
            ModelLimitWarning,
            stacklevel=5,
        )
    later = found.radiance_by_order[:, 1:].sum(axis=1)
    return dataclasses.replace(found, standard_error=np.hypot(found.standard_error, _MODEL_ERROR * later))


def _seed(sky: SolvedSky) -> int:
    return int(np.float64(sky.sun_zenith_rad + 0.0).view(np.uint64))
