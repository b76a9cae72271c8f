"""What the air scatters at its altitudes: the source functions between the orders of scattering.

Per volume, order n of the light is scattered into a direction as

    S^n = beta J^n,        J^n(t, +-mu, phi) = sum_m (2 - [m = 0]) J_m^n(t, +-mu) cos(m phi),

with beta the extinction coefficient and J of `scattering_orders`, which knows it from the moments of order n - 1. The
order 2 whose light the ground has sent up is a part of S^2 of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.atmosphere.medium.constituents import Medium
from aomc_sky.atmosphere.numerics.legendre import gauss_angles, phase_moments, split_table
from aomc_sky.atmosphere.scattering_orders.angular_resolution import SERIES_LENGTH, choose_resolution, least_nodes
from aomc_sky.atmosphere.scattering_orders.columns import ShellColumns
from aomc_sky.atmosphere.scattering_orders.orders import light_from_ground, scattering_moments, sum_orders


@dataclass(frozen=True, kw_only=True, slots=True)
class SourceFunctions:
    """Scattered light per volume and solid angle, at the altitudes of the solver's nodes."""

    altitude_m: np.ndarray  #: (n_level,) from the top down. [m]
    #: (n_wl, n_order - 1, n_level, n_zenith, n_azimuth) light that is scattered into order 2, 3, ... [W m-3 sr-1 nm-1]
    by_order: np.ndarray
    #: (n_wl, n_level, n_zenith) the part of order 2 that comes by way of the ground; the same for all azimuths. [W m-3
    #: sr-1 nm-1]
    from_ground: np.ndarray


def source_functions(
    medium: Medium,
    sun_zenith_rad: float,
    zenith_rad: np.ndarray,
    azimuth_from_sun_rad: np.ndarray,
    *,
    n_orders: int,
) -> SourceFunctions:
    """Source functions of successive orders of scattering, in the resolution of `solve_orders`.

    Something in the medium scatters. Zenith angles beyond pi/2 look at light that travels up; `n_orders` is the last
    order that is listed, 2 or more.

    Accuracy: that of the later orders of `solve_orders`; phase functions are cut to their first moments, so beside the
    sun a sharp peak is blurred. The sun's zenith angle is that of the observer at all altitudes.
    """
    columns = ShellColumns(medium, None, sun_zenith_rad)
    kinds = [np.stack([phase_moments(law, SERIES_LENGTH) for law in slab.phases]) for slab in columns.slabs]
    chosen = choose_resolution(columns.slabs, kinds, columns.n_element, columns.ripple, columns.most_moments)
    n, mu = chosen.n_moments, np.cos(zenith_rad)
    angles = gauss_angles(max(chosen.n_mu, least_nodes(medium.least_angles)), n)
    paths_of = columns.directed(angles.mu, np.ones(1))
    tables = split_table(np.abs(mu), n, n)
    signed = (tables[0], tables[1] * np.sign(mu))
    cosines = np.where(np.arange(n) == 0, 1.0, 2.0)[:, None] * np.cos(np.outer(np.arange(n), azimuth_from_sun_rad))
    extinction = columns.extinction_per_m()
    light = medium.toa_irradiance
    by_order, from_ground = [], []
    for row, slab in enumerate(columns.slabs):
        paths, _ = paths_of(row)
        scattering = scattering_moments(slab, kinds[row][:, :n] * chosen.window(), n)
        mu0, albedo = float(np.cos(sun_zenith_rad)), float(medium.ground_albedo[row])
        found = sum_orders(
            slab, paths, scattering, angles, mu0, albedo, last_order=n_orders, n_listed=n_orders
        )  # fmt: skip
        scale = light[row] * extinction[row][:, None, None]
        modes = [_modes(signed, scattering, each) for each in found.listed]
        by_order.append([scale * np.einsum("mvk,ma->kva", each, cosines[: each.shape[0]]) for each in modes])
        ground = _modes(signed, scattering, light_from_ground(slab, paths, scattering, angles, mu0, albedo)[:, :1])
        from_ground.append(scale[:, 0] * ground[0].T)
    return SourceFunctions(
        altitude_m=columns.altitude_m, by_order=np.array(by_order), from_ground=np.array(from_ground)
    )


def _modes(tables: tuple[np.ndarray, np.ndarray], scattering: np.ndarray, moments: np.ndarray) -> np.ndarray:
    """Modes J_m (n_modes, n_zenith, n_level) of the source function that these moments (2, n_modes, ...) bring."""
    n = moments.shape[1]
    return np.asarray(sum(np.matmul(tables[p][:n].swapaxes(1, 2), scattering[p, :n] * moments[p]) for p in (0, 1)))
