"""The light that successive orders of scattering bring to the ground: what their solver returns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True, slots=True)
class DiffuseSky:
    """Radiance at the ground by orders, for a sun of irradiance F0, as cosine series of the azimuth."""

    sky_zenith_rad: np.ndarray  #: (n_zenith,) zenith angles looked into. [rad]
    #: (n_wl, n_row, n_modes, n_zenith) factors of cos(m phi). Row k is order k + 2; the last row is the sum of all
    #: orders after the listed ones.
    later_modes: np.ndarray
    #: (n_wl, n_kind, n_zenith) plane-parallel order 1 of each kind of particle, without its phase function. [W m-2
    #: nm-1]
    order_one: np.ndarray
    #: (n_wl, n_kind) the phase functions that belong to it
    phases: tuple[tuple[Callable[[np.ndarray], np.ndarray], ...], ...]
    sun_zenith_rad: float
    #: (n_wl, n_row + 1) diffuse irradiance of orders 1, 2, ...; the last entry is the sum of the later ones. [W m-2
    #: nm-1]
    irradiance_by_order: np.ndarray
    #: sun_irradiance, direct_irradiance: (n_wl,) of the beam above the atmosphere on a plane normal to it; at the
    #: ground on the horizontal. [W m-2 nm-1]
    sun_irradiance: np.ndarray
    direct_irradiance: np.ndarray
    n_orders: np.ndarray  #: (n_wl,) orders that were worked out one by one
    #: rest, rest_error: (n_wl,) share of the diffuse irradiance that stands in the geometric rest; the rest's estimated
    #: error, as a share
    rest: np.ndarray
    rest_error: np.ndarray
    #: Estimated error of cutting angles, depths and moments, as a share of the radiance; see `solve_orders`
    resolution_error: float

    @property
    def diffuse_irradiance(self) -> np.ndarray:
        """All orders together, shape (n_wl,). [W m-2 nm-1]"""
        return self.irradiance_by_order.sum(axis=1)

    def later_orders(self, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Radiance of all orders from 2 on, shape (n_wl, n_zenith, n_azimuth). [W m-2 sr-1 nm-1]"""
        return self.later_modes.sum(axis=1).swapaxes(1, 2) @ self._cosines(azimuth_from_sun_rad)

    def by_order(self, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Radiance of orders 1 (plane-parallel), 2, ..., and of all later ones together.

        Shape (n_wl, n_row + 1, n_zenith, n_azimuth). [W m-2 sr-1 nm-1]
        """
        later = self.later_modes.swapaxes(2, 3) @ self._cosines(azimuth_from_sun_rad)
        return np.concatenate([self.plane_order_one(azimuth_from_sun_rad)[:, None], later], axis=1)

    def plane_order_one(self, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Radiance of order 1 of the plane-parallel column, shape (n_wl, n_zenith, n_azimuth). [W m-2 sr-1 nm-1]"""
        half = np.sin(0.5 * np.asarray(azimuth_from_sun_rad)) ** 2
        across = (np.sin(self.sky_zenith_rad) * np.sin(self.sun_zenith_rad))[:, None] * half
        gap = np.sin(0.5 * (self.sky_zenith_rad - self.sun_zenith_rad)) ** 2
        cosine = np.clip(1.0 - 2.0 * (gap[:, None] + across), -1.0, 1.0)
        out = np.zeros((len(self.phases), *cosine.shape))
        for row, laws in enumerate(self.phases):
            for kind, law in enumerate(laws):
                out[row] += self.order_one[row, kind][:, None] * law(cosine.ravel()).reshape(cosine.shape)
        return out

    def _cosines(self, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        return np.cos(np.arange(self.later_modes.shape[2])[:, None] * np.asarray(azimuth_from_sun_rad))
