"""Where a ray from the ground is cut into panels, so that few Gauss nodes in each see smooth light."""

from __future__ import annotations

import numpy as np

from aomc_sky.atmosphere.medium.optical_depth import columns, lowest_altitude
from aomc_sky.atmosphere.medium.profile import Profile

DEPTH_OF_PANEL = 2.0
"""Most optical depth of a panel, along the vertical, and most change of the sun's."""

_GROWTH = 4.0  # of the altitude from edge to edge near the ground, where a level ray gains height with the square
_LOWEST = 1e-6  # first edge above the ground, of the top's altitude
_LEVEL_DEPTH = 0.1  # most optical depth of a level ray below the first edge
_LOW_SUN = 0.05  # cosine of its zenith angle: then it stands level at an altitude all over the sky
_N_BELOW_KINK = 4
_NO_LIGHT = 60.0  # optical depth behind which nothing is resolved any more
_MOST_PANELS = 2000


def ray_panels(profile: Profile, sun_zenith_rad: float) -> np.ndarray:
    """Altitudes where rays from the ground are cut.

    From 0 to the top, the profile's edges among them. In each panel the altitude grows by at most a factor of 4, and at
    no wavelength do the vertical depth or the sun's depth change by more than `DEPTH_OF_PANEL`, short of darkness. [m]
    """
    edges = _near_ground(profile)
    if abs(np.cos(sun_zenith_rad)) < _LOW_SUN:
        edges = np.union1d(edges, _below_kinks(profile))
    while True:
        wide = _change(profile, edges, sun_zenith_rad) > DEPTH_OF_PANEL
        if not wide.any() or edges.size + wide.sum() > _MOST_PANELS:
            return edges
        edges = np.sort(np.concatenate([edges, 0.5 * (edges[1:] + edges[:-1])[wide]]))


def _near_ground(profile: Profile) -> np.ndarray:
    """The profile's edges, and a geometric sequence down to where even a level ray is thin."""
    extinction = float((profile.density(np.zeros(1)) @ profile.extinction_m2.T).max(initial=0.0))
    first = _LOWEST * profile.top_m
    if extinction > 0.0:
        first = min(first, (_LEVEL_DEPTH / extinction) ** 2 / (2.0 * profile.earth_radius_m))
    first = max(first, 1e-15 * profile.top_m)
    steps = int(np.ceil(np.log(profile.top_m / first) / np.log(_GROWTH)))
    grown = profile.top_m * _GROWTH ** -np.arange(1.0, steps + 1)
    apart = np.abs(profile.edge_m[:, None] / grown - 1.0).min(axis=0) > 1e-3  # no sliver beside an edge
    return np.union1d(profile.edge_m, grown[apart])


def _below_kinks(profile: Profile) -> np.ndarray:
    """A geometric sequence up to each kink and the top: a level ray of the sun leaves a layer like a root."""
    ends = np.append(profile.kink_m, profile.top_m)
    width = ends - profile.edge_m[np.searchsorted(profile.edge_m, ends) - 1]
    return (ends[:, None] - width[:, None] * _GROWTH ** -np.arange(1.0, _N_BELOW_KINK + 1)).ravel()


def _change(profile: Profile, edges: np.ndarray, sun_zenith_rad: float) -> np.ndarray:
    """Largest change (n_panel,) of optical depth over each panel, at any wavelength, where there is light."""
    n_wl = profile.extinction_m2.shape[0]
    if n_wl == 0 or profile.extinction_m2.size == 0:
        return np.zeros(edges.size - 1)
    sigma = profile.extinction_m2.T
    vertical = columns(profile, edges, 1.0, profile.top_m) @ sigma
    change = -np.diff(vertical, axis=0)
    over = vertical[0] - vertical
    for sun_mu in (np.full(edges.size, np.cos(sun_zenith_rad)), np.cos(sun_zenith_rad + widest_angle(profile, edges))):
        depth = _clipped_columns(profile, edges, sun_mu) @ sigma
        seen = np.minimum(depth[1:] + over[1:], depth[:-1] + over[:-1]) < _NO_LIGHT + vertical[0]
        change = np.maximum(change, np.where(seen, np.abs(np.diff(depth, axis=0)), 0.0))
    return change.max(axis=1)


def widest_angle(profile: Profile, altitude_m: np.ndarray) -> np.ndarray:
    """Largest angle at the earth's centre between the observer and a point it sees at an altitude. [rad]"""
    level = np.sqrt(altitude_m * (altitude_m + 2.0 * profile.earth_radius_m))
    return np.arctan2(level, profile.earth_radius_m)


def _clipped_columns(profile: Profile, altitude_m: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """Columns to the top; in the shadow those of the ray that touches the ground."""
    rising = columns(profile, altitude_m, np.abs(mu), profile.top_m)
    lowest = np.maximum(lowest_altitude(profile.earth_radius_m, altitude_m, np.minimum(mu, 0.0)), 0.0)
    return np.where(mu[:, None] < 0.0, 2.0 * columns(profile, lowest, 0.0, profile.top_m) - rising, rising)
