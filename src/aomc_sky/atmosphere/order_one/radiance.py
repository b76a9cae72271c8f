"""Light scattered once: radiance at the ground by quadrature on the continuous spherical profile.

    L = F0 sum_i p_i(angle to the sun) sigma_i int n_i(s) exp(-depth to the eye - depth to the sun) ds

A direction and the sun's have one angle between them, so phase functions stand before the integrals, which are smooth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.atmosphere.medium.constituents import Constituent, Medium
from aomc_sky.atmosphere.medium.profile import Profile, density_profile
from aomc_sky.atmosphere.order_one.ray_panels import ray_panels
from aomc_sky.atmosphere.order_one.sun_columns import SunColumns, sun_columns
from aomc_sky.errors import UsageError

N_NODES = 6
"""Gauss nodes of a panel: 1e-6 and better; see docs/models/atmosphere.md."""

MOST_NODES = 64
"""Nodes that a wish for many points along a line may bring; 12 are at the rounding error."""


def scatterers(medium: Medium) -> list[int]:
    """Indices of the constituents that scatter at any wavelength, in their order."""
    return [k for k, part in enumerate(medium.constituents) if _scatters(part)]


def _scatters(part: Constituent) -> bool:
    return part.phase_function is not None and bool(np.any(part.scattering_m2 > 0))


def solve_order_one(
    medium: Medium,
    sun_zenith_rad: float,
    sky_zenith_rad: ArrayLike,
    azimuth_from_sun_rad: ArrayLike,
    *,
    n_nodes: int = N_NODES,
) -> np.ndarray:
    """Radiance of light scattered once in the air, seen from the ground.

    Parameters
    ----------
    medium : Medium
        The atmosphere.
    sun_zenith_rad : float
        Zenith angle of the sun, a point. Below the horizon the earth's shadow darkens the lower air. [rad, 0 to pi]
    sky_zenith_rad, azimuth_from_sun_rad : array_like, shape (n,)
        Directions looked into, azimuth 0 into the sun's. [rad, 0 to pi/2; any]
    n_nodes : int
        Gauss nodes of a panel; twice as many show the error. [2 or more]

    Returns
    -------
    ndarray, float64, shape (n_wl, n)
        For the medium's irradiance at the top. [W m-2 sr-1 nm-1, >= 0]

    Raises
    ------
    UsageError
        An angle is outside its range.

    Notes
    -----
    Accuracy: 1e-6 relative where the densities are smooth between their declared kinks, also for a low or set sun and
    along the horizon. Cost: 15 to 40 ms once for the tables; then 10 us a direction with the sun up, 60 us with it on
    or below the horizon, and 2 us a direction and wavelength.
    """
    zenith, azimuth = checked_directions(sun_zenith_rad, sky_zenith_rad, azimuth_from_sun_rad)
    parts = scattered_once(medium, sun_zenith_rad, zenith, azimuth, n_nodes=n_nodes)
    return with_phases(medium, parts, scattering_cosine(sun_zenith_rad, zenith, azimuth))


def scattered_once(
    medium: Medium,
    sun_zenith_rad: float,
    sky_zenith_rad: ArrayLike,
    azimuth_from_sun_rad: ArrayLike,
    *,
    n_nodes: int = N_NODES,
) -> np.ndarray:
    """`solve_order_one` before the phase functions: what each constituent would give with a phase function of 1.

    Shape (n_wl, n_scatterer, n), in the order of `scatterers`. [W m-2 nm-1, >= 0]
    """
    tables = order_one_tables(medium, sun_zenith_rad, n_nodes=n_nodes)
    return scattered_once_by(tables, medium, sun_zenith_rad, sky_zenith_rad, azimuth_from_sun_rad)


@dataclass(frozen=True, kw_only=True, slots=True)
class OrderOneTables:
    """What order 1 under one sun needs in every direction; cost: 15 to 40 ms."""

    profile: Profile
    u_edge: np.ndarray  #: (n_panel + 1,) roots of the altitudes between panels. [m^0.5]
    #: Gauss nodes and weights of a panel, and the integrals up to each node
    rule: tuple[np.ndarray, np.ndarray, np.ndarray]
    density: np.ndarray  #: (n_constituent, n_panel n_node) at the nodes. [m-3]
    sun: SunColumns  #: Columns from the nodes towards the sun


def order_one_tables(medium: Medium, sun_zenith_rad: float, *, n_nodes: int = N_NODES) -> OrderOneTables:
    """Tabulate a medium under a sun; arguments as `solve_order_one` has them."""
    profile = density_profile(medium)
    panel_m = ray_panels(profile, sun_zenith_rad)
    least = -(-medium.least_line_points // (panel_m.size - 1))
    rule = _rule(max(n_nodes, min(least, MOST_NODES)))
    u_edge = np.sqrt(panel_m)
    u = 0.5 * (u_edge[1:] + u_edge[:-1])[:, None] + 0.5 * np.diff(u_edge)[:, None] * rule[0]
    return OrderOneTables(
        profile=profile,
        u_edge=u_edge,
        rule=rule,
        density=np.ascontiguousarray(profile.density((u * u).ravel()).T),
        sun=sun_columns(profile, panel_m, u * u, sun_zenith_rad),
    )


def scattered_once_by(
    tables: OrderOneTables,
    medium: Medium,
    sun_zenith_rad: float,
    sky_zenith_rad: ArrayLike,
    azimuth_from_sun_rad: ArrayLike,
) -> np.ndarray:
    """`scattered_once` with tables that were made before."""
    from aomc_sky.kernels.atmosphere.order_one import fill_order_one

    zenith, azimuth = checked_directions(sun_zenith_rad, sky_zenith_rad, azimuth_from_sun_rad)
    which = scatterers(medium)
    out = np.zeros((zenith.size, medium.wavelength_nm.size, len(which)))
    if not which or not zenith.size:
        return out.transpose(1, 2, 0)
    profile, sun = tables.profile, tables.sun
    rays, order, start = _grouped(zenith)
    fill_order_one(
        profile.earth_radius_m, tables.u_edge, profile.kink_m, *tables.rule, tables.density, profile.extinction_m2,
        np.array(which), np.cos(sun_zenith_rad), np.sin(sun_zenith_rad),
        sun.table, sun.row_start, sun.n_row, sun.scale, sun.low, sun.inverse_step, profile.edge_m, sun.level,
        np.cos(rays), np.sin(rays), start, np.cos(azimuth[order]), out,
    )  # fmt: skip
    found = np.empty_like(out)
    found[order] = np.maximum(out, 0.0)  # at an edge of the shadow a panel's polynomial may end a rounding below zero
    scattering = np.array([medium.constituents[k].scattering_m2 for k in which])
    return np.ascontiguousarray(found.transpose(1, 2, 0)) * (scattering * medium.toa_irradiance).T[:, :, None]


def with_phases(medium: Medium, parts: np.ndarray, cosine: np.ndarray) -> np.ndarray:
    """Sum over the scatterers of phase function times what each gives without it.

    Shape (n_wl, ...) of parts (n_wl, n_scatterer, ...) as of `scattered_once`; the cosines of the scattering angles
    broadcast to their directions. A series that ends a rounding below zero gives 0.
    """
    radiance, flat = np.zeros((parts.shape[0], *parts.shape[2:])), cosine.ravel()
    for k, index in enumerate(scatterers(medium)):
        phase = medium.constituents[index].phase_function
        assert phase is not None  # it scatters
        for row in range(parts.shape[0]):
            radiance[row] += parts[row, k] * phase(flat, row).reshape(cosine.shape)
    return np.maximum(radiance, 0.0)


def scattering_cosine(sun_zenith_rad: float, zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
    """Cosine of the angle between directions and the sun, from half angles: next to the sun it is 1 to the last bit."""
    across = np.sin(zenith_rad) * np.sin(sun_zenith_rad) * np.sin(azimuth_from_sun_rad / 2) ** 2
    return np.maximum(1.0 - 2.0 * (np.sin((zenith_rad - sun_zenith_rad) / 2) ** 2 + across), -1.0)


def _rule(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gauss nodes and weights, and integrals (n, n) from -1 to each node of each of Lagrange's polynomials."""
    if n < 2:
        raise UsageError(f"a panel needs two nodes or more, got {n}")
    node, weight = np.polynomial.legendre.leggauss(n)
    degrees = np.arange(n)
    values = np.polynomial.legendre.legvander(node, n)
    series = values[:, :n].T * weight * (degrees + 0.5)[:, None]  # Legendre coefficients (degree, polynomial)
    below = np.column_stack([np.ones(n), values[:, : n - 1]])  # P_-1 = 1 stands for P_1's -1 at the lower end
    integrals = (values[:, 1:] - below) / (2.0 * degrees + 1.0)
    integrals[:, 0] = node + 1.0
    return node, weight, np.ascontiguousarray(integrals @ series)


def _grouped(zenith: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Distinct zenith angles, the order of directions that groups them, and where each group starts."""
    rays, which = np.unique(zenith, return_inverse=True)
    order = np.argsort(which, kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(which, minlength=rays.size))])
    return rays, order, start.astype(np.int64)


def checked_directions(
    sun_zenith_rad: float, zenith_rad: ArrayLike, azimuth_rad: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """Directions looked into as arrays; a UsageError for what is no direction of the sky, or no place of the sun."""
    zenith = np.atleast_1d(np.asarray(zenith_rad, dtype=np.float64))
    azimuth = np.atleast_1d(np.asarray(azimuth_rad, dtype=np.float64))
    if zenith.ndim != 1 or zenith.shape != azimuth.shape:
        raise UsageError("directions are one zenith angle and one azimuth each")
    if not np.all((zenith >= 0.0) & (zenith <= np.pi / 2)) or not np.all(np.isfinite(azimuth)):
        raise UsageError("directions of the sky have zenith angles within 0 and pi/2, and finite azimuths")
    if not 0.0 <= sun_zenith_rad <= np.pi:
        raise UsageError(f"the sun's zenith angle must lie within 0 and pi radians, got {sun_zenith_rad}")
    return zenith, azimuth
