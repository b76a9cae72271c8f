"""Stacks of plane layers for the solver of scattering orders: published tables are of such."""

from typing import NamedTuple

import numpy as np

from aomc_sky.skies.atmosphere.eclipse import solve_order_one
from aomc_sky.skies.atmosphere.lights import ground_beam
from aomc_sky.skies.atmosphere.medium import Medium
from aomc_sky.skies.atmosphere.scattering_orders.diffuse import ALL_ORDERS, summed_orders
from tests.support.atmospheres import Layers, flat_medium


class FlatSky(NamedTuple):
    """A medium and its orders of scattering in some zenith angles."""

    medium: Medium
    sun_zenith_rad: float
    sky_zenith_rad: np.ndarray
    #: modes, irradiance_by_order, resolution_error: as `summed_orders` gives them
    modes: np.ndarray
    irradiance_by_order: np.ndarray
    resolution_error: float

    @property
    def direct_irradiance(self):
        """Of the beam on the ground, shape (n_wl,)."""
        return ground_beam(self.medium, self.sun_zenith_rad).irradiance


def solve_flat(medium, sun_zenith_rad, sky_zenith_rad, *, n_listed=1):
    """The orders of a medium, as many as it has, with the medium beside them."""
    sun, zenith = float(sun_zenith_rad), np.minimum(sky_zenith_rad, 0.5 * np.pi)
    return FlatSky(medium, sun, zenith, *summed_orders(medium, sun, zenith, medium.n_orders, n_listed=n_listed))


def solve_layers(layers: Layers, albedo, sun_zenith_rad, sky_zenith_rad, *, n_orders=ALL_ORDERS, n_listed=1):
    """Orders of scattering of homogeneous plane layers under a plane beam of irradiance 1 normal to itself."""
    return solve_flat(flat_medium(layers, albedo, n_orders), sun_zenith_rad, sky_zenith_rad, n_listed=n_listed)


def later_orders(modes, azimuth_from_sun_rad):
    """Radiance of all orders from 2 on, shape (n_wl, n_zenith, n_azimuth)."""
    return _sum_of_modes(modes, azimuth_from_sun_rad).sum(axis=1)


def by_order(sky, azimuth_from_sun_rad):
    """Radiance of orders 1, 2, ..., and of all later ones together, (n_wl, n_row + 1, ...)."""
    theta, phi = np.meshgrid(sky.sky_zenith_rad, azimuth_from_sun_rad, indexing="ij")
    once = solve_order_one(sky.medium, sky.sun_zenith_rad, theta.ravel(), phi.ravel())
    later = _sum_of_modes(sky.modes, azimuth_from_sun_rad)
    return np.concatenate([once.reshape(-1, 1, *theta.shape), later], axis=1)


def _sum_of_modes(modes, azimuth_from_sun_rad):
    cosines = np.cos(np.arange(modes.shape[2])[:, None] * np.asarray(azimuth_from_sun_rad))
    return modes.swapaxes(2, 3) @ cosines
