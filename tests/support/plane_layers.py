"""Stacks of plane layers for the solver of scattering orders: published tables are of such."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from aomc_sky.skies.atmosphere.eclipse import solve_order_one
from aomc_sky.skies.atmosphere.lights import ground_beam
from aomc_sky.skies.atmosphere.medium import Constituent, Medium
from aomc_sky.skies.atmosphere.scattering_orders.diffuse import ALL_ORDERS, summed_orders
from tests.support.atmospheres import medium_of

_THICKNESS_M = 100.0


@dataclass(frozen=True, kw_only=True, slots=True)
class Layers:
    optical_depth: np.ndarray  #: (n_layer,) extinction of each layer from the top. [>= 0]
    #: (n_kind, n_layer) single-scattering albedo that each kind of particle adds. [0 to 1; sum over the kinds <= 1]
    scattering: np.ndarray
    #: n_kind of them: cosines of scattering angles (n,) to the phase function (n,), of integral 1 over the sphere.
    #: [sr-1]
    phases: tuple[Callable[[np.ndarray], np.ndarray], ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class FlatSky:
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


def flat_medium(layers, albedo, n_orders):
    """The layers over a ground of radius 1e14 m: flat to 1e-8 for cosines above 0.02."""
    n = len(layers.optical_depth)
    edges = _THICKNESS_M * np.arange(1.0, n)

    def density(depth):
        per_m = np.asarray(depth)[::-1] / _THICKNESS_M
        return lambda h: per_m[np.clip(np.searchsorted(edges, h, side="right"), 0, n - 1)]

    shares = [*layers.scattering, 1.0 - np.sum(layers.scattering, axis=0)]
    laws = [*((lambda mu, row, law=law: law(mu)) for law in layers.phases), None]
    parts = [
        Constituent(
            name=f"kind {k}",
            number_density=density(layers.optical_depth * share),
            kink_altitude_m=edges,
            scattering_m2=np.array([0.0 if law is None else 1.0]),
            absorption_m2=np.array([1.0 if law is None else 0.0]),
            phase_function=law,
        )
        for k, (share, law) in enumerate(zip(shares, laws, strict=True))
        if np.any(share > 1e-12)
    ]
    return medium_of(parts, 550.0, albedo=albedo, earth_radius_m=1e14, top_m=n * _THICKNESS_M, n_orders=n_orders)


def solve_flat(medium, sun_zenith_rad, sky_zenith_rad, *, n_listed=1):
    """The orders of a medium, as many as it has, with the medium beside them."""
    sun, zenith = float(sun_zenith_rad), np.minimum(sky_zenith_rad, 0.5 * np.pi)
    modes, irradiance, error = summed_orders(medium, sun, zenith, medium.n_orders, n_listed=n_listed)
    return FlatSky(
        medium=medium,
        sun_zenith_rad=sun,
        sky_zenith_rad=zenith,
        modes=modes,
        irradiance_by_order=irradiance,
        resolution_error=error,
    )


def solve_layers(layers, albedo, sun_zenith_rad, sky_zenith_rad, *, n_orders=ALL_ORDERS, n_listed=1):
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
