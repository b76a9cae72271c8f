"""Solve an atmosphere for the whole sky at sea level."""

from __future__ import annotations

import dataclasses
import time
from dataclasses import dataclass

import numpy as np

from aomc_sky.atmosphere.direct_beam import direct_beam
from aomc_sky.atmosphere.exact_once import ExactOnce
from aomc_sky.atmosphere.medium import Medium
from aomc_sky.atmosphere.method import LOWEST_SUN_DEG, chosen_method
from aomc_sky.atmosphere.order_one import scattered_once, scatterers
from aomc_sky.atmosphere.path_orders import PathOrders, path_orders
from aomc_sky.atmosphere.sky_field import SkyField, field_of_modes, fit_field, zenith_nodes
from aomc_sky.atmosphere.solved_sky import SolvedSky
from aomc_sky.atmosphere.successive_orders import ALL_ORDERS, DiffuseSky, solve_orders

ONCE_NODES = (48, 7)
ONCE_NODES_LOW_SUN = (96, 13)
"""Nodes of zenith angle and azimuth for light scattered once; the second pair for a sun below 10 degrees."""

_LOWEST_OF_SERIES_DEG = 90.0
"""Zenith angle of the sun beyond which the shadow of the earth cuts paths, and a series of order 1 fails."""

ONCE_ERROR = 1e-5
"""Relative error of order 1 as its solver states it."""

_CURVATURE_OF_EARTH = 120.0 / 6371.0

MORE_NODES = 64
"""Nodes of zenith angle for orders 2 and up."""

MOST_LISTED = 24
"""Orders that are kept one by one; where more count, the last row holds all the later ones together."""


@dataclass(frozen=True, kw_only=True, slots=True)
class LaterOrders:
    """Orders 2 and up in some zenith angles.

    Parameters
    ----------
    modes : ndarray, float64, shape (n_wl, n_row, n_modes, n_zenith)
        Factors of cos(m phi) of orders 2, 3, ... [W m-2 sr-1 nm-1]
    truncation : ndarray, float64, shape (n_wl,)
        Estimated share of the sky's irradiance in the orders that do not count.
    found : DiffuseSky
        What the solver says of itself.
    """

    modes: np.ndarray
    truncation: np.ndarray
    found: DiffuseSky

    @property
    def resolution_error(self) -> float:
        """Estimated error of cutting angles, depths and moments, as a share of the radiance."""
        return self.found.resolution_error


def later_orders(
    medium: Medium, sun_zenith_rad: float, sky_zenith_rad: np.ndarray, n_orders: int, *, n_listed: int
) -> LaterOrders:
    """Orders 2 to `n_orders`, and what the orders above them would bring.

    Parameters
    ----------
    medium : Medium
        The atmosphere; its own number of orders does not count.
    sun_zenith_rad : float
        Zenith angle of the sun. [rad]
    sky_zenith_rad : ndarray, float64, shape (n_zenith,)
        Zenith angles looked into. [rad]
    n_orders : int
        Most interactions that count. [2 or more]
    n_listed : int
        Orders that are listed one by one, order 1 among them; the last row holds the rest where more count. [2 or more]
    """
    if n_orders <= n_listed:
        everything = dataclasses.replace(medium, n_orders=ALL_ORDERS)
        found = solve_orders(everything, sun_zenith_rad, sky_zenith_rad, n_listed=n_orders)
        left = found.irradiance_by_order[:, -1]
        whole = found.irradiance_by_order.sum(axis=1)
        truncation = np.divide(left, whole, out=np.zeros_like(left), where=whole > 0)
        return LaterOrders(modes=found.later_modes[:, :-1], truncation=truncation, found=found)
    limited = dataclasses.replace(medium, n_orders=n_orders)
    found = solve_orders(limited, sun_zenith_rad, sky_zenith_rad, n_listed=n_listed - 1)
    return LaterOrders(modes=found.later_modes, truncation=_geometric_rest(found, n_orders, n_listed), found=found)


def _geometric_rest(found: DiffuseSky, n_orders: int, n_listed: int) -> np.ndarray:
    """Share beyond many orders, by the ratio of the last two that are listed."""
    if n_orders >= ALL_ORDERS:
        return np.zeros(found.irradiance_by_order.shape[0])
    before, last = found.irradiance_by_order[:, -3], found.irradiance_by_order[:, -2]
    ratio = np.divide(last, before, out=np.zeros_like(last), where=before > 0)
    rest = last * ratio ** (n_orders - n_listed + 2) / np.maximum(1.0 - ratio, 1e-6)
    whole = found.irradiance_by_order.sum(axis=1)
    return np.divide(rest, whole, out=np.zeros_like(rest), where=whole > 0)


def solve_sky(
    medium: Medium,
    *,
    sun_zenith_rad: float,
    method: str = "auto",
    n_orders: int | None = None,
    n_listed: int = 8,
) -> SolvedSky:
    """Solve for the whole sky.

    Parameters
    ----------
    medium : Medium
        The atmosphere.
    sun_zenith_rad : float
        Zenith angle of the sun. [rad, 0 to 0.6 pi]
    method, n_orders
        As `aomc_sky.atmosphere.method.chosen_method` has them.
    n_listed : int
        Orders that are kept one by one; where more count, the last row holds all the later ones. [2 or more]

    Returns
    -------
    SolvedSky

    Raises
    ------
    UsageError, SceneError
        What the method is not good for.

    Notes
    -----
    Accuracy: the fields follow the solvers to `SolvedSky.series_error`, the largest difference found in 64 directions
    between the nodes: 2e-8 under a sun at 40 degrees, 1e-7 at 80, 7e-6 at 90. Cost: 0.1 s a wavelength; see the page.
    """
    chosen, orders = chosen_method(medium, sun_zenith_rad, method, n_orders)
    return solve_sky_and_rings(medium, sun_zenith_rad, np.empty(0), method=chosen, n_orders=orders, n_listed=n_listed)[
        0
    ]


def solve_sky_and_rings(
    medium: Medium, sun_zenith_rad: float, ring_rad: np.ndarray, *, method: str, n_orders: int, n_listed: int
) -> tuple[SolvedSky, np.ndarray | None]:
    """Solve for the whole sky, and look into more zenith angles with the same solution.

    Parameters
    ----------
    medium, sun_zenith_rad, n_listed
        As for `solve_sky`.
    ring_rad : ndarray, float64, shape (n_ring,)
        Zenith angles. [rad, 0 to pi/2]
    method, n_orders
        As `chosen_method` gives them.

    Returns
    -------
    SolvedSky
    ndarray, float64, shape (n_wl, n_row, n_modes, n_ring), or None
        Factors of cos(m phi) of orders 2, 3, ... in the zenith angles; None where order 1 is all.
    """
    started = time.perf_counter()
    once = _once(medium, sun_zenith_rad)
    after_once = time.perf_counter()
    later: LaterOrders | PathOrders | None = None
    if method != "order1" and scatterers(medium):
        zenith = np.concatenate([zenith_nodes(MORE_NODES), ring_rad])
        law = later_orders if method == "sos" else path_orders
        later = law(medium, sun_zenith_rad, zenith, n_orders, n_listed=min(n_listed, n_orders))
    seconds = {"order 1": after_once - started, "later orders": time.perf_counter() - after_once}
    sky = SolvedSky(
        medium=medium,
        sun_zenith_rad=sun_zenith_rad,
        once=once,
        more=None if later is None else field_of_modes(later.modes[..., :MORE_NODES]),
        direct=direct_beam(medium, sun_zenith_rad),
        method=method,
        n_orders=n_orders,
        truncation=np.full(medium.wavelength_nm.size, np.nan) if later is None else later.truncation,
        resolution_error=0.0 if later is None else later.resolution_error,
        series_error=series_error(medium, sun_zenith_rad, once),
        seconds=seconds,
    )
    return sky, None if later is None else later.modes[..., MORE_NODES:]


def _once(medium: Medium, sun_zenith_rad: float) -> SkyField | ExactOnce:
    degrees = float(np.rad2deg(sun_zenith_rad))
    if degrees > _LOWEST_OF_SERIES_DEG:
        return ExactOnce(medium=medium, sun_zenith_rad=sun_zenith_rad)
    n_zenith, n_azimuth = ONCE_NODES if degrees <= LOWEST_SUN_DEG else ONCE_NODES_LOW_SUN
    return fit_field(
        lambda zenith, azimuth: scattered_once(medium, sun_zenith_rad, zenith, azimuth),
        n_zenith=n_zenith,
        n_azimuth=n_azimuth,
    )


def series_error(medium: Medium, sun_zenith_rad: float, once: SkyField | ExactOnce) -> float:
    """Largest relative difference of order 1 from its solver in 64 directions that are no nodes."""
    if isinstance(once, ExactOnce):
        return 0.0
    k = np.arange(64)
    zenith = np.arccos(((k + 0.5) / 64) ** 1.5)
    azimuth = np.pi * np.mod(0.5 + k * 0.6180339887498949, 1.0)
    exact = scattered_once(medium, sun_zenith_rad, zenith, azimuth).sum(axis=1)
    found = once.at(zenith, azimuth).sum(axis=1)
    scale = exact + 1e-6 * exact.max(axis=1, keepdims=True, initial=0.0)
    return float(
        np.max(np.divide(np.abs(found - exact), scale, out=np.zeros_like(exact), where=scale > 0), initial=0.0)
    )


def relative_errors(sky: SolvedSky) -> tuple[float, float]:
    """Estimated errors of the solvers.

    Parameters
    ----------
    sky : SolvedSky
        The sky.

    Returns
    -------
    once : float
        Of quadratures and resolutions, as a share of the radiance.
    later : float
        Of the orders above as a share of them: what flat layers under spherical paths make of a curved atmosphere.

    Notes
    -----
    The second is 0.4 % of the earth's atmosphere for suns above 10 degrees, and rises to 3 % at the horizon: deviations
    from spherical Monte Carlo tables in 945 directions, their own noise included. It falls with the height of an
    atmosphere over the radius of its ground. Of "mc" it is the standard error of a direction.
    """
    if sky.method == "mc":
        return ONCE_ERROR, sky.resolution_error
    low = max(float(np.rad2deg(sky.sun_zenith_rad)) - LOWEST_SUN_DEG, 0.0) / (90.0 - LOWEST_SUN_DEG)
    curvature = sky.medium.top_m / sky.medium.earth_radius_m / _CURVATURE_OF_EARTH
    return ONCE_ERROR + sky.resolution_error, min(curvature, 1.0) * (0.004 + 0.026 * low)
