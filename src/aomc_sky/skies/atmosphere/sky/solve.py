"""Solve an atmosphere: for the whole sky at sea level, or in single directions."""

from __future__ import annotations

import dataclasses
import os
import time
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import UsageError
from aomc_sky.grid import PatchGrid
from aomc_sky.record import same_content, short_repr
from aomc_sky.skies.atmosphere.backward import MOST_LISTED, PathsResult, seed_of, solve_paths
from aomc_sky.skies.atmosphere.eclipse import eclipsed_once, solve_order_one, visible_share
from aomc_sky.skies.atmosphere.lights import Moon, ground_beam, is_mirrored
from aomc_sky.skies.atmosphere.medium import Medium, scatterers, unlit
from aomc_sky.skies.atmosphere.optical_depth import vertical_optical_depth
from aomc_sky.skies.atmosphere.order_one import scattering_cosine, with_phases
from aomc_sky.skies.atmosphere.scattering_orders.diffuse import LaterOrders, solve_orders
from aomc_sky.skies.atmosphere.sky.method import LOWEST_SUN_DEG, Lights, chosen_lights
from aomc_sky.skies.atmosphere.sky.path_orders import glow_orders, path_orders, warn_of_under_sampling
from aomc_sky.skies.atmosphere.sky.solved import (
    ExactOrderOne,
    SkyField,
    SolvedSky,
    azimuth_basis,
    field_of_modes,
    fit_field,
    patch_means,
    zenith_nodes,
)

ORDER_ONE_ERROR = 1e-5
"""Relative error of order 1 as its solver states it."""

_CURVATURE_OF_EARTH = 120.0 / 6371.0
_KEPT_ORDERS = 8  # one by one; where more count, the last row holds all the later ones

LATER_NODES = 64
"""Nodes of zenith angle for orders 2 and up."""

ORDER_ONE_NODES = (48, 7)
ORDER_ONE_NODES_LOW_SUN = (96, 13)
"""Nodes of zenith angle and azimuth for light scattered once; the second pair for a sun below 10 degrees."""

ORDER_ONE_NODES_ECLIPSE = (48, 13)
"""The same where the Moon hides part of the sun."""

_LOWEST_OF_SERIES_DEG = 90.0
"""Zenith angle of the sun beyond which the shadow of the earth cuts paths, and a series of order 1 fails."""


def solve_sky(
    medium: Medium,
    *,
    sun_zenith_rad: float,
    method: str = "auto",
    n_orders: int | None = None,
    moon: Moon | None = None,
    ground_radiance: np.ndarray | None = None,
    n_paths: int | None = None,
    seed: int = 0,
) -> SolvedSky:
    """Solve for the whole sky.

    The sun's zenith angle is 0 to 0.6 pi, with `ground_radiance` 0 to pi. This is the ground's own light (n_wl,) [W m-2
    sr-1 nm-1]; with it, the sun is left out in deep night. Arguments `method` and `n_orders` are as for
    `chosen_method`. A Moon is left out if it reaches no part of the sun from anywhere in the atmosphere. By default
    `n_paths` is 32768 for the ground. For the sun it is 4096, or four times as many if their median error is above 5 %.

    Between the nodes the field of order 1 follows its solver to 2e-8 under a sun at 40 degrees, 1e-7 at 80, 7e-6 at 90.
    """
    lights = chosen_lights(
        medium, sun_zenith_rad, method=method, n_orders=n_orders, moon=moon, ground_radiance=ground_radiance,
        n_paths=n_paths, seed=seed,
    )  # fmt: skip
    return _solved_sky(medium, sun_zenith_rad, lights, np.empty(0), n_listed=_KEPT_ORDERS)[0]


def _solved_sky(
    medium: Medium, sun_zenith_rad: float, lights: Lights, ring_rad: np.ndarray, *, n_listed: int
) -> tuple[SolvedSky, np.ndarray]:
    """Solve for the whole sky; orders from `n_listed` on share the last row.

    Also series in the azimuth (n_wl, n_row, n_modes, n_ring) of orders 2, 3, ... in the zenith angles `ring_rad`, of
    "sos" alone.
    """
    if not lights.has_sun:
        medium = unlit(medium)
    nodes, n_rows = zenith_nodes(LATER_NODES), min(n_listed, lights.n_orders)
    mirrored = is_mirrored(lights.moon)
    order_one = order_one_field(medium, sun_zenith_rad, lights)
    later = _later(medium, sun_zenith_rad, np.append(nodes, ring_rad), lights, n_rows, order_one)
    modes = np.empty(0) if later is None else later.modes
    glow, glow_error = _glow(medium, nodes, lights, n_rows)
    share = 1.0 if lights.moon is None else visible_share(medium, sun_zenith_rad, lights.moon)
    direct = ground_beam(medium, sun_zenith_rad)
    sky = SolvedSky(
        medium=medium,
        sun_zenith_rad=sun_zenith_rad,
        order_one=order_one,
        later_orders=None if later is None else field_of_modes(modes[..., :LATER_NODES], is_mirrored=mirrored),
        direct=dataclasses.replace(direct, irradiance=share * direct.irradiance),
        method=lights.method,
        n_orders=lights.n_orders,
        truncation=np.full(medium.wavelength_nm.size, np.nan) if later is None else later.truncation,
        resolution_error=0.0 if later is None else later.resolution_error,
        moon=lights.moon,
        visible_share=share,
        glow=None if glow is None else field_of_modes(glow[:, :, None]),
        glow_error=glow_error,
        node_error=None if later is None else later.node_error,
        n_paths=0 if later is None else later.n_paths,
        reason=lights.reason,
    )
    return sky, modes[..., LATER_NODES:]


def _glow(medium: Medium, zenith: np.ndarray, lights: Lights, n_rows: int) -> tuple[np.ndarray | None, float]:
    if lights.ground_radiance is None or not scatterers(medium):
        return None, 0.0
    return glow_orders(
        medium, lights.ground_radiance, zenith, lights.n_orders, n_listed=n_rows, n_paths=lights.n_paths,
        seed=lights.seed,
    )  # fmt: skip


def _later(
    medium: Medium,
    sun_zenith_rad: float,
    zenith: np.ndarray,
    lights: Lights,
    n_rows: int,
    order_one: SkyField | ExactOrderOne,
) -> LaterOrders | None:
    if lights.method == "order1" or not lights.has_sun:
        return None
    if not np.any(vertical_optical_depth(medium)[:, scatterers(medium)] > 0.0):
        return None
    if lights.method == "sos":
        return solve_orders(medium, sun_zenith_rad, zenith, lights.n_orders, n_listed=n_rows)

    def radiance(theta: np.ndarray, phi: np.ndarray) -> np.ndarray:
        return with_phases(medium, order_one.at(theta, phi), scattering_cosine(sun_zenith_rad, theta, phi))

    return path_orders(
        medium, sun_zenith_rad, zenith[:LATER_NODES], lights.n_orders, n_listed=n_rows, moon=lights.moon,
        n_paths=lights.n_paths, order_one=radiance, seed=lights.seed,
    )  # fmt: skip


def relative_errors(sky: SolvedSky) -> tuple[float, float]:
    """Estimated errors: of quadratures as a share of the radiance, of the later orders as a share of them."""
    if sky.method == "mc":
        return ORDER_ONE_ERROR, sky.resolution_error
    low = max(float(np.rad2deg(sky.sun_zenith_rad)) - LOWEST_SUN_DEG, 0.0) / (90.0 - LOWEST_SUN_DEG)
    curvature = sky.medium.top_m / sky.medium.earth_radius_m / _CURVATURE_OF_EARTH
    return ORDER_ONE_ERROR, sky.resolution_error + min(curvature, 1.0) * (0.004 + 0.026 * low)


def order_one_field(medium: Medium, sun_zenith_rad: float, lights: Lights) -> SkyField | ExactOrderOne:
    """Light scattered once before the phase functions, over the whole sky: a series, or in twilight solved anew."""
    if not lights.has_sun:
        return SkyField(coefficient=np.zeros((medium.wavelength_nm.size, len(scatterers(medium)), 1, 1)))
    degrees = float(np.rad2deg(sun_zenith_rad))
    if lights.moon is not None:
        n_zenith, n_azimuth = ORDER_ONE_NODES_ECLIPSE
    elif degrees > _LOWEST_OF_SERIES_DEG:
        return ExactOrderOne(medium=medium, sun_zenith_rad=sun_zenith_rad)
    else:
        n_zenith, n_azimuth = ORDER_ONE_NODES if degrees <= LOWEST_SUN_DEG else ORDER_ONE_NODES_LOW_SUN
    mirrored = is_mirrored(lights.moon)
    return fit_field(
        lambda zenith, azimuth: eclipsed_once(medium, sun_zenith_rad, zenith, azimuth, lights.moon),
        n_zenith=n_zenith,
        n_azimuth=n_azimuth if mirrored else 2 * n_azimuth - 1,
        is_mirrored=mirrored,
    )


_FLUX_BINS = (45, 72)
_FLUX_BINS_TWILIGHT = (18, 12)
_FLUX_TOLERANCE = 1e-4

MOST_PATHS, FEWEST_PATHS = 65536, 4096
"""Paths of each direction and wavelength: the first, unless all directions together had more than `ALL_PATHS`."""

ALL_PATHS = 512 * MOST_PATHS

_MODEL_ERROR = 2e-4
"""Of tables and shells, as a share of the light that paths bring."""


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class AtmosphereResult:
    """Radiance of an atmosphere in the directions asked for, with its irradiances and errors.

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
        `aomc_sky.skies.atmosphere.backward.solve_paths`. None where no path was followed for the sun's light.

    Examples
    --------
    >>> solved = sky.solve_atmosphere(
    ...     "inputs/atmosphere/molecules_only.atmo",
    ...     wavelength_nm=[600.0],
    ...     sun_zenith_deg=30.0,
    ...     sky_zenith_deg=[0.0, 45.0],
    ...     azimuth_from_sun_deg=[90.0],
    ...     method="order1",
    ... )
    >>> solved.radiance.shape, solved.method
    ((1, 2, 1), 'order1')
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
    seconds: dict[str, float] = field(default_factory=dict, compare=False)
    under_sampled: np.ndarray | None = None

    __eq__ = same_content
    __repr__ = short_repr


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
    seed: int = 0,
) -> AtmosphereResult:
    """Solve an atmosphere in all pairs of zenith angles and azimuths from the sun, each solved for itself.

    Arguments and errors as of `solve_sky`; `dropped` is what the maker of the medium left out. The two sides of the
    sun's vertical plane are equal unless the Moon lies off it. Method "mc" follows 65536 paths in each direction and
    wavelength. For more than 512 directions it follows fewer, 4096 at least. Two suns have numbers of their own. The
    irradiance of the sky is that of patches, good to 1e-4, and of "mc" has the noise of the whole sky's paths.
    """
    started = time.perf_counter()
    zenith, azimuth = _angles(sky_zenith_rad, "zenith angles"), _angles(azimuth_from_sun_rad, "azimuths")
    if not np.all((zenith >= 0) & (zenith <= np.pi / 2 * (1 + 1e-15))):
        raise UsageError("zenith angles of directions must lie within 0 and 90 degrees")
    lights = chosen_lights(
        medium, sun_zenith_rad, method=method, n_orders=n_orders, moon=moon, ground_radiance=ground_radiance,
        n_paths=n_paths, seed=seed,
    )  # fmt: skip
    rings, ring = np.unique(np.minimum(zenith, np.pi / 2), return_inverse=True)
    sky, modes = _solved_sky(medium, sun_zenith_rad, lights, rings, n_listed=MOST_LISTED)
    grid = PatchGrid.regular(*(_FLUX_BINS if sun_zenith_rad <= np.pi / 2 else _FLUX_BINS_TWILIGHT))
    mean, _ = patch_means(sky, grid, 0.0, tolerance=_FLUX_TOLERANCE)
    after_flux = time.perf_counter()
    by_order, error, flagged = _by_order(sky, modes, rings, azimuth, lights)
    glow, glow_error = _glow(medium, rings, lights, sky.n_listed)
    if glow is not None:
        by_order = by_order + glow[..., None]
        error = np.hypot(error, glow_error * glow.sum(axis=1)[..., None])
    by_order, error = by_order[:, :, ring], error[:, ring]
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
        raise UsageError(f"{what} of directions must be finite numbers in one row")
    return angles


def _by_order(
    sky: SolvedSky, modes: np.ndarray, rings: np.ndarray, azimuth: np.ndarray, lights: Lights
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """The sun's light by order on all pairs, (n_wl, n_order, n_ring, n_azimuth), its error, and where it is flagged."""
    turned = np.fmod(azimuth, 2 * np.pi)  # exact, so that mirror images stay so to the bit
    turned -= np.where(np.abs(turned) > np.pi, np.copysign(2 * np.pi, turned), 0.0)
    columns, column = np.unique(np.round(np.abs(turned) if sky.is_mirrored else turned, 15), return_inverse=True)
    theta, phi = (angle.ravel() for angle in np.meshgrid(rings, columns, indexing="ij"))
    shape = rings.size, columns.size
    if sky.method == "mc" and sky.later_orders is not None:
        paths = directed_paths(sky, theta, phi, lights.n_paths, lights.seed)
        rows = paths.radiance_by_order.reshape(*paths.radiance_by_order.shape[:2], *shape)
        error, flagged = (each.reshape(-1, *shape)[..., column] for each in (paths.standard_error, paths.under_sampled))
        return rows[..., column], error, flagged
    order_one = solve_order_one(sky.medium, sky.sun_zenith_rad, theta, phi, sky.moon)
    rows = np.zeros((order_one.shape[0], sky.n_listed, *shape))
    rows[:, 0] = order_one.reshape(-1, *shape)
    if sky.later_orders is not None:
        terms = azimuth_basis(columns, modes.shape[2], is_mirrored=sky.is_mirrored)
        rows[:, 1:] = np.maximum(modes.swapaxes(2, 3) @ terms.T, 0.0)
    once_error, later_error = relative_errors(sky)
    error = np.hypot(once_error * rows.sum(axis=1), later_error * rows[:, 1:].sum(axis=1))
    return rows[..., column], error[..., column], None


def directed_paths(
    sky: SolvedSky,
    sky_zenith_rad: np.ndarray,
    azimuth_from_sun_rad: np.ndarray,
    n_paths: int | None = None,
    seed: int = 0,
) -> PathsResult:
    """Follow paths in single directions; `n_paths` None is as many as the number of directions allows.

    Two suns have errors of their own, and the whole sky others again.
    """
    stream = int(np.float64(sky.sun_zenith_rad + 0.0).view(np.uint64))
    found = solve_paths(
        sky.medium, sun_zenith_rad=sky.sun_zenith_rad, sky_zenith_rad=sky_zenith_rad,
        azimuth_from_sun_rad=azimuth_from_sun_rad, n_orders=sky.n_orders, visible=sky.moon,
        seed=seed_of(stream, seed),
        n_paths=n_paths or int(np.clip(ALL_PATHS // max(sky_zenith_rad.size, 1), FEWEST_PATHS, MOST_PATHS)),
        threads=os.cpu_count() or 1,
    )  # fmt: skip
    if found.under_sampled.any():
        warn_of_under_sampling(found.under_sampled, stacklevel=6)
    later = found.radiance_by_order[:, 1:].sum(axis=1)
    return dataclasses.replace(found, standard_error=np.hypot(found.standard_error, _MODEL_ERROR * later))
