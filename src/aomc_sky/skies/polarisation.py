"""Polarisation of skylight: the pattern of light that was scattered once, as Stokes vectors of patches.

Stokes vectors are Q/I and U/I in the meridian plane of the travel direction, as docs/conventions.md defines them.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component, Law
from aomc_sky.errors import SceneError, floats, number
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.quadrature import POINTS, angles_at, weighted_sum

Radiance = Callable[[ArrayLike, ArrayLike, ArrayLike], np.ndarray]
"""The method `radiance` of a sky."""


@dataclass(frozen=True, kw_only=True, slots=True)
class RayleighPattern:
    """Linear polarisation of light that air molecules scattered once, times a largest degree.

    At the angle T from the sun the degree is `max_degree` (1 - cos^2 T) / (1 + cos^2 T). The electric vector is
    perpendicular to the plane of the sun and the ray. Real skies have neutral points (Arago, Babinet and Brewster)
    within about 25 degrees of the sun and of the point opposite it. They come from light that was scattered several
    times, and this pattern does not have them: its only points without polarisation are the sun and the point opposite.
    Fields of a vector code have them; see `TabulatedSky.from_xarray`. Coulson, Polarization and Intensity of Light in
    the Atmosphere (1988).

    Parameters
    ----------
    max_degree : float
        Degree at 90 degrees from the sun. 0.75 is that of a clean sky; haze, a bright ground and clouds lower it. [0 to
        1]

    Notes
    -----
    Accuracy: q and u of a direction within 3e-15 where both azimuths lie within a turn of 0, also at the zenith, the
    horizon, the sun and the point opposite it.
    A scene keeps the mean of each patch, weighted by flux.

    Examples
    --------
    >>> pattern = sky.RayleighPattern(max_degree=0.75)
    >>> model = sky.PerezSky(
    ...     sun_zenith_deg=40.0, epsilon=6.0, delta=0.1, polarisation=pattern
    ... )
    >>> source = sky.Scene(wavebands=[550.0], n_photons=1000, components=model).source()
    >>> source.photons().q.dtype
    dtype('float32')
    """

    max_degree: float = 0.75

    def __post_init__(self) -> None:
        if not 0.0 <= number("max_degree", self.max_degree) <= 1.0:
            raise SceneError(f"max_degree must be 0 to 1, got {self.max_degree!r}")

    def stokes(
        self,
        sky_zenith_rad: ArrayLike,
        sky_azimuth_rad: ArrayLike,
        *,
        sun_zenith_rad: float,
        sun_azimuth_rad: float = 0.0,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Q/I and U/I of light from sky directions, in the meridian plane of its travel direction.

        Parameters
        ----------
        sky_zenith_rad, sky_azimuth_rad : array_like
            Sky direction: 0 overhead, azimuth from +x (east) towards +y (north). [rad, 0 to pi/2 and any turn]
        sun_zenith_rad, sun_azimuth_rad : float
            Where the sun is, in the same angles. [rad]

        Returns
        -------
        tuple of ndarray, float64
            q and u, broadcast of the angles. [-1 to 1]
        """
        zenith = floats("sky_zenith_rad", sky_zenith_rad)
        sun_zenith_rad = number("sun_zenith_rad", sun_zenith_rad)
        turn = floats("sky_azimuth_rad", sky_azimuth_rad) - number("sun_azimuth_rad", sun_azimuth_rad)
        if np.any(np.isinf(zenith)) or np.any(np.isinf(turn)) or math.isinf(sun_zenith_rad):
            raise SceneError("the angles of the sky direction and of the sun must be finite")
        sine, cosine = math.sin(sun_zenith_rad), math.cos(sun_zenith_rad)
        # the normal of the scattering plane, as long as sin T: along the meridian plane and across it
        along = -sine * np.sin(turn)
        across = sine * np.cos(zenith) * np.cos(turn) - cosine * np.sin(zenith)
        cosine_of_angle = sine * np.sin(zenith) * np.cos(turn) + cosine * np.cos(zenith)  # cos T
        scale = self.max_degree / (1.0 + cosine_of_angle * cosine_of_angle)
        return scale * (along - across) * (along + across), scale * 2.0 * along * across

    def polarised(
        self,
        components: Iterable[Component],
        radiance: Radiance,
        wavelength_nm: ArrayLike,
        sun_rad: tuple[float, float],
    ) -> tuple[Component, ...]:
        """The components of a sky with the Stokes vectors of their patches; those without patches stay as they are.

        The weight inside a patch is the flux of its photons: even for `Law.CELL_MU2`, else that of the sky's radiance.
        """
        nm = np.atleast_1d(floats("wavelength_nm", wavelength_nm)).ravel().tolist()
        made = []
        for one in components:
            if one.grid is not None:
                rows = [math.nan] if one.law is Law.CELL_MU2 else nm[: len(one.mass)]
                stokes = np.stack([self._patch_means(one.grid, radiance, row, sun_rad) for row in rows])
                one = dataclasses.replace(one, stokes=stokes)
            made.append(one)
        return tuple(made)

    def _patch_means(self, grid: PatchGrid, radiance: Radiance, nm: float, sun_rad: tuple[float, float]) -> np.ndarray:
        """Means of q and u (n_patch, 2), by 4 x 4 Gauss points in the angles; without a wavelength light is even."""
        nodes, weights, _ = POINTS[4]
        bounds = grid.zenith_bounds_deg, grid.azimuth_bounds_deg
        zenith, azimuth = (angles_at(np.deg2rad(one), nodes).T for one in bounds)
        zenith, azimuth = zenith[:, None, :, None], azimuth[None, :, None, :]
        light = weights[:, None, None, None] * weights[:, None, None] * np.sin(2.0 * zenith)
        light = light * (np.ones(azimuth.shape) if math.isnan(nm) else radiance(zenith, azimuth, nm))
        q, u = self.stokes(zenith, azimuth, sun_zenith_rad=sun_rad[0], sun_azimuth_rad=sun_rad[1])
        flux, *both = (weighted_sum(x.reshape(16, -1), np.ones(16)) for x in (light, light * q, light * u))
        return np.stack([np.divide(x, flux, out=np.zeros_like(flux), where=flux > 0) for x in both], axis=1)
