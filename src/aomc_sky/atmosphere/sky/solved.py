"""A clear sky after its solution: radiance anywhere on it, order by order, and the direct beam."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from aomc_sky.atmosphere.lights.direct_beam import DirectBeam
from aomc_sky.atmosphere.lights.moon import Moon
from aomc_sky.atmosphere.medium.constituents import Medium
from aomc_sky.atmosphere.numerics.sky_field import SkyField, azimuth_nodes, zenith_nodes
from aomc_sky.atmosphere.order_one.exact import ExactOnce
from aomc_sky.atmosphere.order_one.radiance import scattering_cosine, with_phases


@dataclass(frozen=True, kw_only=True, slots=True)
class SolvedSky:
    """Radiance of the sky at the ground, as phase functions times smooth fields.

    Parameters
    ----------
    medium : Medium
        The atmosphere.
    sun_zenith_rad : float
        Zenith angle of the sun. [rad]
    once : SkyField or ExactOnce, shape (n_wl, n_scatterer, ...)
        Light scattered once by each kind of particle that scatters, without its phase function. [W m-2 nm-1]
    more : SkyField, shape (n_wl, n_order - 1, ...), or None
        Radiance of orders 2 and up; None where order 1 is all. [W m-2 sr-1 nm-1]
    direct : DirectBeam
        The light of the sun that reaches the ground unscattered.
    method : str
        "order1", "sos" or "mc".
    n_orders : int
        Most interactions that count.
    truncation : ndarray, float64, shape (n_wl,)
        Estimated share of the sky's irradiance in the orders that do not count; NaN for order 1 alone.
    resolution_error : float
        Estimated error of cutting angles and depths in the later orders, as a share of the radiance.
    series_error : float
        Largest relative difference of the field of order 1 from its solver that was found between the nodes.
    seconds : dict of str to float
        Time of each part of the solution. [s]
    moon : Moon or None
        What hides part of the sun.
    visible_share : float
        Of the sun's disc, seen by the observer beside the Moon; `direct` has it already. [0 to 1]
    glow : SkyField, shape (n_wl, n_listed, ...), or None
        Radiance of orders 1 and up that a glowing ground brings. [W m-2 sr-1 nm-1]
    glow_error : float
        Standard error of one direction of it, as a share.
    node_error : ndarray, float64, shape (n_wl, n_zenith, n_azimuth), or None
        Of "mc": standard error of orders 2 and up at `zenith_nodes` and `azimuth_nodes`. [W m-2 sr-1 nm-1]
    reason : str
        Why "auto" took the method; empty where the method was asked for.
    n_paths : int
        Backward paths of each direction and wavelength that brought orders 2 and up; 0 where no paths did.
    """

    medium: Medium
    sun_zenith_rad: float
    once: SkyField | ExactOnce
    more: SkyField | None
    direct: DirectBeam
    method: str
    n_orders: int
    truncation: np.ndarray
    resolution_error: float
    series_error: float
    seconds: dict[str, float]
    moon: Moon | None = None
    visible_share: float = 1.0
    glow: SkyField | None = None
    glow_error: float = 0.0
    node_error: np.ndarray | None = None
    reason: str = ""
    n_paths: int = 0

    @property
    def n_listed(self) -> int:
        """Orders that are kept one by one; the last one holds all later ones too."""
        of_sun = 1 if self.more is None else 1 + int(self.more.coefficient.shape[1])
        return max(of_sun, 0 if self.glow is None else int(self.glow.coefficient.shape[1]))

    @property
    def is_mirrored(self) -> bool:
        """Whether the sky right of the sun is that left of it."""
        return self.moon is None or not self.moon.breaks_symmetry

    @property
    def direct_irradiance(self) -> np.ndarray:
        """Irradiance of the direct beam on the horizontal ground, shape (n_wl,). [W m-2 nm-1]"""
        return self.direct.irradiance

    @property
    def direct_normal(self) -> np.ndarray:
        """Irradiance of the direct beam on a plane normal to it, shape (n_wl,). [W m-2 nm-1]"""
        return self.visible_share * self.medium.toa_irradiance * np.exp(-self.direct.optical_depth)

    def once_on_product(self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Radiance of order 1 on all pairs of zenith angles (n_z,) and azimuths from the sun (n_a,).

        Shape (n_wl, n_z, n_a). [W m-2 sr-1 nm-1, >= 0]
        """
        parts = self.once.on_product(sky_zenith_rad, azimuth_from_sun_rad)
        return with_phases(self.medium, parts, self._cosine(sky_zenith_rad[:, None], azimuth_from_sun_rad[None, :]))

    def once_at(self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Radiance of order 1 in single directions (n,), shape (n_wl, n). [W m-2 sr-1 nm-1, >= 0]"""
        parts = self.once.at(sky_zenith_rad, azimuth_from_sun_rad)
        return with_phases(self.medium, parts, self._cosine(sky_zenith_rad, azimuth_from_sun_rad))

    def once_in_cells(
        self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray, ring: np.ndarray, column: np.ndarray
    ) -> np.ndarray:
        """Radiance of order 1 on the nodes of some cells of a product of rings and columns.

        Shape (n_wl, n_cell, n, n) of nodes of each ring (n_ring, n) and column (n_column, n), and of the cells'
        indices; rings do not fall. [W m-2 sr-1 nm-1, >= 0]
        """
        theta, phi = sky_zenith_rad[ring][:, :, None], azimuth_from_sun_rad[column][:, None, :]
        parts = self.once.in_cells(sky_zenith_rad, azimuth_from_sun_rad, ring, column)
        return with_phases(self.medium, parts, self._cosine(theta, phi))

    def at(self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Radiance of all orders together in single directions (n,), shape (n_wl, n). [W m-2 sr-1 nm-1, >= 0]"""
        radiance = self.once_at(sky_zenith_rad, azimuth_from_sun_rad)
        for part in (self.more, self.glow):
            if part is not None:
                whole = dataclasses.replace(part, coefficient=part.coefficient.sum(axis=1))
                radiance = radiance + np.maximum(whole.at(sky_zenith_rad, azimuth_from_sun_rad), 0.0)
        return radiance

    def path_error(self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Standard error of orders 2 and up by paths in single directions (n,): that of the nearest node, (n_wl, n)."""
        assert self.node_error is not None  # method "mc"
        n_zenith, n_azimuth = self.node_error.shape[1:]
        turned = np.mod(azimuth_from_sun_rad, 2.0 * np.pi)
        turned = np.minimum(turned, 2.0 * np.pi - turned) if self.is_mirrored else turned
        node = azimuth_nodes(n_azimuth, is_mirrored=self.is_mirrored)
        rings = np.argmin(np.abs(sky_zenith_rad[:, None] - zenith_nodes(n_zenith)), axis=1)
        return np.asarray(self.node_error[:, rings, np.argmin(np.abs(turned[:, None] - node), axis=1)])

    def _cosine(self, zenith: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
        return scattering_cosine(self.sun_zenith_rad, zenith, azimuth)
