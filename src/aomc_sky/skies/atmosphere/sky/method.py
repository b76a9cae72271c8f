"""The lights of an atmosphere, the method of its solution, and the suns that a method is good for."""

from __future__ import annotations

import logging
import math
import warnings
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from aomc_sky.errors import ModelLimitWarning, SceneError, UsageError, require_one_of
from aomc_sky.skies.atmosphere.backward import checked_paths
from aomc_sky.skies.atmosphere.lights import Moon
from aomc_sky.skies.atmosphere.medium import Medium
from aomc_sky.whole_number import as_index_within, as_number_of

_LOG = logging.getLogger(__name__)
logging.getLogger("aomc_sky").addHandler(logging.NullHandler())

SolverWord = Literal["auto", "order1", "sos", "mc"]
METHODS = get_args(SolverWord)
"""What a caller may ask for."""

LOWEST_SUN_DEG = 80.0
"""Zenith angle up to which a pseudo-spherical beam over flat scattering is good to a percent."""

MOST_ORDERS = 2**31 - 1

NIGHT_DEG = 108.0
"""Zenith angle of the sun beyond which the sky has no light of it: the end of astronomical twilight."""


def chosen_method(
    medium: Medium,
    sun_zenith_rad: float,
    method: str,
    n_orders: int | None,
    *,
    is_eclipsed: bool = False,
    is_glowing: bool = False,
) -> tuple[str, int]:
    """Settle method and number of orders, by default the medium's.

    "order1": light scattered once; exact shells for any sun. "sos": order 1 and successive orders of scattering, for
    any sun above the horizon. "mc": order 1, and backward paths through shells for the others, for any sun. "auto":
    "order1" for one order, "sos" for a sun 10 degrees up and higher or an atmosphere that is flat beside its ground,
    else "mc"; "mc" too before the Moon, where "sos" is refused, and over a ground that glows in deep night.
    """
    require_one_of(METHODS, method, "method")
    requested = medium.n_orders if n_orders is None else as_number_of(n_orders, "orders", 1, MOST_ORDERS)
    degrees = math.degrees(sun_zenith_rad)
    if is_glowing and NIGHT_DEG < degrees <= 180.0:
        orders = int(requested)
        return ("order1", 1) if method == "order1" or orders == 1 else ("mc", orders)
    if not 0.0 <= degrees <= NIGHT_DEG + 1e-9:
        raise SceneError(
            f"the sun's zenith angle must lie within 0 and {NIGHT_DEG:g} degrees, got {degrees:g}: deeper below the "
            "horizon than 18 degrees it gives no light; only a ground that glows does"
        )
    orders = 1 if method == "order1" else int(requested)
    if orders == 1:
        return "order1", 1
    if is_eclipsed:
        if method == "sos":
            raise UsageError('method "sos" cannot solve an eclipse', 'use "mc" or "auto"')
        return "mc", orders
    is_low = degrees > LOWEST_SUN_DEG + 1e-9 and is_curved(medium, sun_zenith_rad)
    if method == "mc" or (method == "auto" and (is_low or degrees > 90.0 + 1e-9)):
        return "mc", orders
    if degrees > 90.0 + 1e-9:
        raise UsageError(f'method "sos" needs the sun above the horizon, got zenith {degrees:g}', 'use "mc"')
    if is_low:
        warnings.warn(
            f"the sun stands {90 - degrees:.4g} degrees above the horizon; below {90 - LOWEST_SUN_DEG:g} degrees, "
            'orders of scattering above 1 are wrong by some per cent; use "mc"',
            ModelLimitWarning,
            stacklevel=3,
        )
    return "sos", orders


def reason_of(chosen: str, sun_zenith_rad: float, *, is_eclipsed: bool) -> str:
    """Why "auto" takes a method, a clause without a full stop; it is logged too."""
    height = 90.0 - math.degrees(sun_zenith_rad)
    low = f"the sun is {-height:.4g} degrees below the horizon"
    sun = f"the sun stands {height:.4g} degrees high" if height >= 0 else low
    if chosen == "order1":
        why = "only one order of scattering was asked for"
    elif chosen == "sos":
        is_high = height > 90.0 - LOWEST_SUN_DEG - 1e-9
        why = f"{sun}, high enough for it" if is_high else f"{sun}, and the atmosphere is thin beside its planet"
    elif height < 90.0 - NIGHT_DEG:
        why = "the sun is far below the horizon, and the ground gives the light"
    else:
        why = "the Moon hides part of the sun" if is_eclipsed else f"{sun}, too low for flat layers"
    _LOG.info("method %s: %s", chosen, why)
    return why


def is_curved(medium: Medium, sun_zenith_rad: float) -> bool:
    """Whether the beam's path through the medium differs from one through flat layers by more than a percent."""
    cosine = max(math.cos(sun_zenith_rad), 1e-3)
    return medium.top_m / (2.0 * medium.earth_radius_m * cosine**2) > 0.01


@dataclass(frozen=True, kw_only=True, slots=True)
class Lights:
    """Settled: what shines, and how it is solved."""

    has_sun: bool  #: False in deep night
    moon: Moon | None  #: It hides part of the sun
    ground_radiance: np.ndarray | None  #: (n_wl,) of a ground that glows. [W m-2 sr-1 nm-1]
    #: method, n_orders: as `chosen_method` gives them
    method: str
    n_orders: int
    n_paths: int | None  #: Paths of each direction and wavelength, where somebody says how many
    seed: int = 0  #: Of the paths. [0 to 2^64 - 1]
    reason: str = ""  #: Why "auto" took the method; empty where the method was asked for


def chosen_lights(
    medium: Medium,
    sun_zenith_rad: float,
    *,
    method: str,
    n_orders: int | None,
    moon: Moon | None,
    ground_radiance: np.ndarray | None,
    n_paths: int | None = None,
    seed: int = 0,
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
        seed=as_index_within(seed, "seed", 0, 2**64 - 1),
        reason=reason_of(chosen, sun_zenith_rad, is_eclipsed=is_eclipsed) if method == "auto" else "",
    )
