"""Light scattered once, solved anew in every direction: for suns below the horizon, whose shadow no series holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.atmosphere.medium import Medium
from aomc_sky.atmosphere.order_one import scattered_once


@dataclass(frozen=True, kw_only=True, slots=True)
class ExactOnce:
    """What `SkyField` gives of order 1, without a series.

    Parameters
    ----------
    medium : Medium
        The atmosphere.
    sun_zenith_rad : float
        Zenith angle of the sun. [rad]

    Notes
    -----
    Cost: that of `scattered_once` in each direction, 10 us and 2 us for each wavelength.
    """

    medium: Medium
    sun_zenith_rad: float

    def on_product(self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Values on all pairs of zenith angles (n_z,) and azimuths (n_a,), shape (n_wl, n_scatterer, n_z, n_a)."""
        zenith, azimuth = np.meshgrid(sky_zenith_rad, azimuth_from_sun_rad, indexing="ij")
        found = self.at(zenith.ravel(), azimuth.ravel())
        return found.reshape(*found.shape[:2], *zenith.shape)

    def at(self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Values in single directions (n,), shape (n_wl, n_scatterer, n)."""
        return scattered_once(self.medium, self.sun_zenith_rad, sky_zenith_rad, azimuth_from_sun_rad)

    def in_cells(
        self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray, ring: np.ndarray, column: np.ndarray
    ) -> np.ndarray:
        """Values on the nodes of cells, as `SkyField.in_cells`, shape (n_wl, n_scatterer, n_cell, n, n)."""
        zenith, azimuth = np.broadcast_arrays(
            sky_zenith_rad[ring][:, :, None], azimuth_from_sun_rad[column][:, None, :]
        )
        found = self.at(zenith.ravel(), azimuth.ravel())
        return found.reshape(*found.shape[:2], *zenith.shape)
