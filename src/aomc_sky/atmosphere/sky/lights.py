"""What lights an atmosphere: the sun, whole or behind the Moon, and a ground that glows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.atmosphere.backward.monte_carlo import checked_paths
from aomc_sky.atmosphere.lights.moon import Moon
from aomc_sky.atmosphere.medium.constituents import Medium
from aomc_sky.atmosphere.sky.method import NIGHT_DEG, chosen_method, reason_of


@dataclass(frozen=True, kw_only=True, slots=True)
class Lights:
    """Settled: what shines, and how it is solved.

    Parameters
    ----------
    has_sun : bool
        False in deep night.
    moon : Moon or None
        What hides part of the sun.
    ground_radiance : ndarray, float64, shape (n_wl,), or None
        Of a ground that glows. [W m-2 sr-1 nm-1]
    method, n_orders
        As `chosen_method` gives them.
    n_paths : int or None
        Paths of each direction and wavelength, where somebody says how many.
    reason : str
        Why "auto" took the method; empty where the method was asked for.
    """

    has_sun: bool
    moon: Moon | None
    ground_radiance: np.ndarray | None
    method: str
    n_orders: int
    n_paths: int | None
    reason: str = ""


def chosen_lights(
    medium: Medium,
    sun_zenith_rad: float,
    *,
    method: str,
    n_orders: int | None,
    moon: Moon | None,
    ground_radiance: np.ndarray | None,
    n_paths: int | None = None,
) -> Lights:
    """Settle what counts; arguments and errors as `solve_sky` has them."""
    glows = ground_radiance is not None and bool(np.any(ground_radiance > 0))
    across = 2.0 * (medium.earth_radius_m + medium.top_m)
    hides = moon is not None and moon.reaches(sun_zenith_rad, medium.sun_angular_radius_rad, across_m=across)
    is_night = float(np.rad2deg(sun_zenith_rad)) > NIGHT_DEG + 1e-9
    is_eclipsed = hides and not is_night
    chosen, orders = chosen_method(medium, sun_zenith_rad, method, n_orders, is_eclipsed=is_eclipsed, is_glowing=glows)
    return Lights(
        has_sun=not is_night and bool(np.any(medium.toa_irradiance > 0)),
        moon=moon if is_eclipsed else None,
        ground_radiance=ground_radiance if glows else None,
        method=chosen,
        n_orders=orders,
        n_paths=None if n_paths is None else checked_paths(n_paths),
        reason=reason_of(chosen, sun_zenith_rad, is_eclipsed=is_eclipsed) if method == "auto" else "",
    )
