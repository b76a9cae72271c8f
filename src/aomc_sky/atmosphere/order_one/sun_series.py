"""Columns from points of the air towards a high sun, as polynomials of the cosine of its zenith angle there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.atmosphere.medium.optical_depth import columns_to_top
from aomc_sky.atmosphere.medium.profile import Profile
from aomc_sky.atmosphere.order_one.ray_panels import widest_angle

N_NODES = 12
"""Cosines in which columns are solved for each altitude."""

_LOWEST_COSINE = 0.1  # below it a polynomial would want more nodes
_CHECKED = np.array([-0.97, -0.5, 0.1, 0.7, 0.99])
_TOLERANCE = 1e-7  # of a column


@dataclass(frozen=True, kw_only=True, slots=True)
class SunSeries:
    """For each of some altitudes the columns to the top under all cosines that the observer's sky has there.

    Parameters
    ----------
    profile : Profile
        Densities.
    altitude_m : ndarray, float64, shape (n,)
        [m]
    middle, half : ndarray, float64, shape (n,)
        Of the range of cosines at each altitude.
    coefficient : ndarray, float64, shape (n, n_constituent, N_NODES), or None
        Of Chebyshev polynomials over the range; None where the sun is too low for them, and every ray is solved.
        [m-2]
    """

    profile: Profile
    altitude_m: np.ndarray
    middle: np.ndarray
    half: np.ndarray
    coefficient: np.ndarray | None

    def columns(self, which: np.ndarray, mu: np.ndarray) -> np.ndarray:
        """Columns (n_which, n_constituent) from the altitudes `which`, bool (n,), under cosines (n_which,). [m-2]"""
        if self.coefficient is None:
            return columns_to_top(self.profile, self.altitude_m[which], mu)
        x = np.clip((mu - self.middle[which]) / self.half[which], -1.0, 1.0)
        terms = np.polynomial.chebyshev.chebvander(x, N_NODES - 1)
        return np.asarray((self.coefficient[which] @ terms[:, :, None])[:, :, 0])


def sun_series(profile: Profile, altitude_m: np.ndarray, sun_zenith_rad: float) -> SunSeries:
    """Solve columns in `N_NODES` cosines of each altitude.

    Parameters
    ----------
    profile : Profile
        Densities.
    altitude_m : ndarray, float64, shape (n,)
        Altitudes. [m]
    sun_zenith_rad : float
        Zenith angle of the sun at the observer. [rad, 0 to pi]

    Returns
    -------
    SunSeries

    Notes
    -----
    Accuracy: 1e-7 of a column, measured in five cosines of each altitude; where that is not met, or the sun lower than
    6 degrees from anywhere in the sky, there is no series.
    """
    width = widest_angle(profile, altitude_m)
    low = np.cos(np.minimum(sun_zenith_rad + width, np.pi))
    high = np.cos(np.maximum(sun_zenith_rad - width, 0.0))
    middle, half = 0.5 * (high + low), np.maximum(0.5 * (high - low), 1e-12)
    coefficient = None
    if low.min(initial=1.0) > _LOWEST_COSINE:
        coefficient = _fitted(profile, altitude_m, middle, half)
    return SunSeries(profile=profile, altitude_m=altitude_m, middle=middle, half=half, coefficient=coefficient)


def _fitted(profile: Profile, altitude_m: np.ndarray, middle: np.ndarray, half: np.ndarray) -> np.ndarray | None:
    angle = (np.arange(N_NODES) + 0.5) * np.pi / N_NODES
    on_nodes = columns_to_top(profile, altitude_m, middle + half * np.cos(angle)[:, None])
    series = np.cos(np.outer(np.arange(N_NODES), angle)) * (2.0 / N_NODES)
    series[0] /= 2.0
    coefficient = np.ascontiguousarray(np.einsum("kj,jnp->npk", series, on_nodes))
    exact = columns_to_top(profile, altitude_m, middle + half * _CHECKED[:, None])
    terms = np.polynomial.chebyshev.chebvander(_CHECKED, N_NODES - 1)
    found = np.einsum("ck,npk->cnp", terms, coefficient)
    return coefficient if np.all(np.abs(found - exact) <= _TOLERANCE * np.abs(exact) + 1e-300) else None
