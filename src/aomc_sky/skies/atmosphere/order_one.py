"""Light scattered once: radiance at the ground by quadrature on the continuous spherical profile.

L = F0 sum_i p_i(angle to the sun) sigma_i int n_i(s) exp(-depth to the eye - depth to the sun) ds
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from aomc_sky.errors import UsageError
from aomc_sky.skies.atmosphere.medium import Medium, phase_laws, scatterers
from aomc_sky.skies.atmosphere.optical_depth import Profile, columns, columns_to_top, density_profile, halved

N_NODES = 6
"""Gauss nodes of a panel: 1e-6 and better; see docs/models/atmosphere.md."""

MOST_NODES = 64
"""Nodes that a wish for many points along a line may bring; 12 are at the rounding error."""


def scattered_once(
    medium: Medium, sun_zenith_rad: float, sky_zenith_rad: ArrayLike, azimuth_from_sun_rad: ArrayLike
) -> np.ndarray:
    """Light scattered once in the air, seen from the ground, before the phase functions. [W m-2 nm-1, >= 0]

    Shape (n_wl, n_scatterer, n), in the order of `scatterers`. The sun is a point, its azimuth 0, its zenith angle 0 to
    pi. Accuracy: 1e-6 relative where the densities are smooth between their declared kinks. Cost: 15 to 40 ms for
    the tables, then 10 to 60 us a direction.
    """
    from aomc_sky.skies.atmosphere.kernels.order_one import fill_order_one

    zenith, azimuth = checked_directions(sun_zenith_rad, sky_zenith_rad, azimuth_from_sun_rad)
    which = scatterers(medium)
    out = np.zeros((zenith.size, medium.wavelength_nm.size, len(which)))
    if not which or not zenith.size:
        return out.transpose(1, 2, 0)
    profile = density_profile(medium)
    panel_m = ray_panels(profile, sun_zenith_rad)
    least = -(-medium.least_line_points // (panel_m.size - 1))
    rule = _rule(max(N_NODES, min(least, MOST_NODES)))
    u_edge = np.sqrt(panel_m)
    u = 0.5 * (u_edge[1:] + u_edge[:-1])[:, None] + 0.5 * np.diff(u_edge)[:, None] * rule[0]
    density = np.ascontiguousarray(profile.density((u * u).ravel()).T)
    mixed = profile.extinction_m2 @ density
    level, to_sun = _level(profile), sun_columns(profile, panel_m, u * u, sun_zenith_rad)
    rays, ray_of = np.unique(zenith, return_inverse=True)
    order = np.argsort(ray_of, kind="stable")  # directions of a ray side by side
    start = np.concatenate([[0], np.cumsum(np.bincount(ray_of, minlength=rays.size))]).astype(np.int64)
    threads, across = os.cpu_count() or 1, np.cos(azimuth[order])

    def look(some: np.ndarray) -> None:
        fill_order_one(
            profile.earth_radius_m, u_edge, profile.kink_m, *rule, density, profile.extinction_m2, mixed,
            np.array(which), np.cos(sun_zenith_rad), np.sin(sun_zenith_rad), *to_sun, profile.edge_m, level,
            np.cos(rays[some]), np.sin(rays[some]), start[some[0] : some[-1] + 2], across, out,
        )  # fmt: skip

    with ThreadPoolExecutor(max_workers=threads) as pool:
        list(pool.map(look, np.array_split(np.arange(rays.size), min(threads, rays.size))))
    in_order = np.empty_like(out)
    in_order[order] = np.maximum(out, 0.0)  # at an edge of the shadow a panel's polynomial may end below zero
    scattering = np.array([medium.constituents[k].scattering_m2 for k in which])
    return np.ascontiguousarray(in_order.transpose(1, 2, 0)) * (scattering * medium.toa_irradiance).T[:, :, None]


def with_phases(medium: Medium, parts: np.ndarray, cosine: np.ndarray) -> np.ndarray:
    """Sum over the scatterers of phase function times what each gives without it, parts (n_wl, n_scatterer, ...).

    The cosines of the scattering angles broadcast to the directions. A series that ends a rounding below zero gives 0.
    """
    radiance, flat = np.zeros((parts.shape[0], *parts.shape[2:])), cosine.ravel()
    for k, phase in enumerate(phase_laws(medium)):
        for row in range(parts.shape[0]):
            radiance[row] += parts[row, k] * phase(flat, row).reshape(cosine.shape)
    return np.maximum(radiance, 0.0)


def scattering_cosine(sun_zenith_rad: float, zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
    """Cosine of the angle between directions and the sun, from half angles: next to the sun it is 1 to the last bit."""
    across = np.sin(zenith_rad) * np.sin(sun_zenith_rad) * np.sin(azimuth_from_sun_rad / 2) ** 2
    return np.maximum(1.0 - 2.0 * (np.sin((zenith_rad - sun_zenith_rad) / 2) ** 2 + across), -1.0)


def _rule(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Gauss rule, integrals (n, n) from -1 to each node of each of Lagrange's polynomials, and inverse gaps."""
    node, weight = np.polynomial.legendre.leggauss(n)
    degrees = np.arange(n)
    values = np.polynomial.legendre.legvander(node, n)
    series = values[:, :n].T * weight * (degrees + 0.5)[:, None]  # Legendre coefficients (degree, polynomial)
    below = np.column_stack([np.ones(n), values[:, : n - 1]])  # P_-1 = 1: P_1 is -1 at the lower end
    integrals = (values[:, 1:] - below) / (2.0 * degrees + 1.0)
    integrals[:, 0] = node + 1.0
    inverse_gap = 1.0 / np.prod(node[:, None] - node + np.eye(n), axis=1)
    return node, weight, np.ascontiguousarray(integrals @ series), inverse_gap


def checked_directions(
    sun_zenith_rad: float, zenith_rad: ArrayLike, azimuth_rad: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """Directions looked into as arrays; a UsageError if they or the sun are out of range."""
    zenith = np.atleast_1d(np.asarray(zenith_rad, dtype=np.float64))
    azimuth = np.atleast_1d(np.asarray(azimuth_rad, dtype=np.float64))
    if zenith.ndim != 1 or zenith.shape != azimuth.shape:
        raise UsageError("each direction needs one zenith angle and one azimuth")
    if not np.all((zenith >= 0.0) & (zenith <= np.pi / 2)) or not np.all(np.isfinite(azimuth)):
        raise UsageError("directions of the sky have zenith angles within 0 and pi/2, and finite azimuths")
    if not 0.0 <= sun_zenith_rad <= np.pi:
        raise UsageError(f"the sun's zenith angle must lie within 0 and pi radians, got {sun_zenith_rad}")
    return zenith, azimuth


STEP = 0.1
"""Of the table over y, where mu = scale sinh(y); six-point interpolation is then good to 1e-6 of the depth."""

_POINTS = 6
_N_LEVEL = 14  # Chebyshev nodes of the level columns in a panel: 1e-9


def sun_columns(
    profile: Profile, panel_m: np.ndarray, altitude_m: np.ndarray, sun_zenith_rad: float
) -> tuple[np.ndarray, ...]:
    """Tabulate the columns towards the sun to 1e-6 of the depth; the error falls with the sixth power of `STEP`.

    `panel_m` (n_panel + 1,) has all edges of the profile, `altitude_m` (n_panel, n_node) lies inside the panels. It
    returns table, row_start, n_row, scale, low and inverse_step of `kernels.order_one.fill_order_one`, over all cosines
    that the sun has at points seen from the observer.
    """
    at = altitude_m[:, -1]
    above = profile.edge_m[np.searchsorted(profile.edge_m, 0.5 * (panel_m[1:] + panel_m[:-1]), side="right")]
    rise = (above - at) * (above + at + 2.0 * profile.earth_radius_m)
    # cosines under which the densities change: those of a rise by the distance to the next edge of the profile
    scale = np.minimum(np.sqrt(rise) / (profile.earth_radius_m + at), 1.0)
    least, greatest = _range(profile, panel_m[1:], sun_zenith_rad)
    start, end = np.arcsinh(least / scale), np.arcsinh(greatest / scale)
    n_row = np.maximum(np.ceil((end - start) / STEP).astype(np.int64) + 5, _POINTS + 1)
    steps = np.maximum((end - start) / (n_row - 5), 1e-9)
    low = np.maximum(start - 2.0 * steps, 0.0)  # two points beyond each end, so that interpolation is central
    n_node = altitude_m.shape[1]
    lengths = np.repeat(n_row, n_node)
    row_start = np.concatenate([[0], np.cumsum(lengths)])
    which = np.repeat(np.arange(lengths.size), lengths)
    y = np.repeat(low, n_row * n_node) + np.repeat(steps, n_row * n_node) * (np.arange(which.size) - row_start[which])
    mu = np.repeat(scale, n_row * n_node) * np.sinh(y)  # a little above 1 at a row's end: the formulas go on smoothly
    table = columns(profile, altitude_m.ravel()[which], mu, profile.top_m)
    row_columns = (np.repeat(each, n_node) for each in (scale, low, 1.0 / steps))
    return table, row_start[:-1], lengths, *row_columns


def _range(profile: Profile, altitude_m: np.ndarray, sun_zenith_rad: float) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest abs(mu) of the sun at lit points (n,) that the observer sees."""
    angle = widest_angle(profile, altitude_m)
    highest = np.cos(np.maximum(sun_zenith_rad - angle, 0.0))
    deepest = -np.sin(angle)  # below this the sun is behind the ground
    lowest = np.maximum(np.cos(np.minimum(sun_zenith_rad + angle, np.pi)), deepest)
    highest = np.maximum(highest, lowest)
    crosses = (lowest < 0.0) & (highest > 0.0)
    least = np.where(crosses, 0.0, np.minimum(np.abs(lowest), np.abs(highest)))
    return least, np.maximum(np.abs(lowest), np.abs(highest))


def _level(profile: Profile) -> np.ndarray:
    """Level columns (n_profile_panel, n_constituent, _N_LEVEL) as polynomials, highest power first.

    The variable is 2 sqrt((high - h)/(high - low)) - 1: below a jump they change like the root of the distance to it.
    """
    x = np.asarray(chebyshev.chebpts1(_N_LEVEL))
    share = (0.5 * (1.0 + x)) ** 2
    altitude = profile.edge_m[1:, None] - np.diff(profile.edge_m)[:, None] * share
    values = columns(profile, np.maximum(altitude, 0.0), 0.0, profile.top_m)
    return np.ascontiguousarray(np.einsum("pn,qni->qip", np.linalg.inv(np.vander(x, _N_LEVEL)), values))


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
    """Altitudes where rays from the ground are cut, from 0 to the top, the profile's edges among them. [m]

    In each panel the altitude grows by at most a factor of 4. The vertical depth and the sun's depth change by at most
    `DEPTH_OF_PANEL` at any wavelength, short of darkness.
    """
    extinction = float((profile.density(np.zeros(1)) @ profile.extinction_m2.T).max(initial=0.0))
    first = _LOWEST * profile.top_m
    if extinction > 0.0:  # down to where even a level ray is thin
        first = min(first, (_LEVEL_DEPTH / extinction) ** 2 / (2.0 * profile.earth_radius_m))
    first = max(first, 1e-15 * profile.top_m)
    steps = int(np.ceil(np.log(profile.top_m / first) / np.log(_GROWTH)))
    grown = profile.top_m * _GROWTH ** -np.arange(1.0, steps + 1)
    apart = np.abs(profile.edge_m[:, None] / grown - 1.0).min(axis=0) > 1e-3  # no sliver beside an edge
    edges = np.union1d(profile.edge_m, grown[apart])
    if abs(np.cos(sun_zenith_rad)) < _LOW_SUN:  # a level ray of the sun leaves a layer like a root
        ends = np.append(profile.kink_m, profile.top_m)
        width = ends - profile.edge_m[np.searchsorted(profile.edge_m, ends) - 1]
        below = ends[:, None] - width[:, None] * _GROWTH ** -np.arange(1.0, _N_BELOW_KINK + 1)
        edges = np.union1d(edges, below.ravel())
    return halved(edges, lambda edges: _change(profile, edges, sun_zenith_rad) > DEPTH_OF_PANEL, _MOST_PANELS)


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
        depth = columns_to_top(profile, edges, sun_mu) @ sigma
        seen = np.minimum(depth[1:] + over[1:], depth[:-1] + over[:-1]) < _NO_LIGHT + vertical[0]
        change = np.maximum(change, np.where(seen, np.abs(np.diff(depth, axis=0)), 0.0))
    return change.max(axis=1)


def widest_angle(profile: Profile, altitude_m: np.ndarray) -> np.ndarray:
    """Largest angle at the earth's centre between the observer and a point it sees at an altitude. [rad]"""
    level = np.sqrt(altitude_m * (altitude_m + 2.0 * profile.earth_radius_m))
    return np.arctan2(level, profile.earth_radius_m)
