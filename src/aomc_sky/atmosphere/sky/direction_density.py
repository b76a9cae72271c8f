"""A density that directions of the sky are drawn from: light scattered once in patches, and a floor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.atmosphere.medium.constituents import Medium
from aomc_sky.atmosphere.sky.lights import Lights
from aomc_sky.atmosphere.sky.means import patch_means
from aomc_sky.atmosphere.sky.solve_sky import solve_sky
from aomc_sky.grid import PatchGrid
from aomc_sky.kernels.emission.plain import philox

FLOOR, FLOOR_OTHER_LIGHT = 0.125, 0.5
"""Share of the directions that are drawn from a sky of uniform radiance; the second where the Moon hides part of the
sun, or the ground glows, and order 1 says little of the others."""

BINS = (36, 72)
BINS_TWILIGHT = (18, 24)
"""Patches of zenith and azimuth; the second where every direction of order 1 is solved by itself."""

_TOLERANCE = 1e-2
_DRAW_STEP = 2**32 - 1  # of the counter: paths, of at most 2^31 steps, never come there
_U64 = np.uint64


@dataclass(frozen=True, kw_only=True, slots=True)
class DirectionDensity:
    """Chances of patches, in each of which directions lie as under constant radiance.

    Parameters
    ----------
    grid : PatchGrid
        The patches; azimuth 0 is the sun's.
    chance : ndarray, float64, shape (n_wl, n_patch)
        Of each patch; sums to 1, and nowhere less than the floor's share of that of a uniform sky.
    upto : ndarray, float64, shape (n_wl, n_patch)
        Their running sums; the last is 1.
    once : ndarray, float64, shape (n_wl,)
        Irradiance of the sun's order 1, good to a percent. [W m-2 nm-1]
    """

    grid: PatchGrid
    chance: np.ndarray
    upto: np.ndarray
    once: np.ndarray

    def draw(
        self, row: int, first: int, n: int, address: tuple[np.uint64, np.uint64, np.uint64]
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Directions number `first` to `first + n - 1` of a wavelength.

        Parameters
        ----------
        row, first, n : int
            Wavelength, and which directions. [numbers below 2^32]
        address : tuple of 3 uint64
            Stream and wavelength, words of the counter, and the key.

        Returns
        -------
        zenith, azimuth : ndarray, float64, shape (n,)
            Azimuth from the sun's. [rad]
        density : ndarray, float64, shape (n,)
            By projected solid angle: cos(zenith) times solid angle. [sr-1]
        """
        stream, wavelength, key = address
        rank = np.arange(first, first + n, dtype=_U64) | _U64(_DRAW_STEP << 32)
        which, where = philox(key, rank, int(stream), int(wavelength))
        cell = np.searchsorted(self.upto[row], (which >> _U64(11)).astype(np.float64) * 2.0**-53, side="right")
        cell = np.minimum(cell, self.grid.n_patches - 1)
        ring, column = np.divmod(cell, self.grid.n_azimuth)
        up, around = _middle(where >> _U64(32)), _middle(where & _U64(0xFFFFFFFF))
        near, growth, far = (edge[ring] for edge in self.grid.ring_sin2())
        zenith = np.arctan2(np.sqrt(near + growth * up), np.sqrt(far + growth * (1.0 - up)))
        start, end = np.deg2rad(self.grid.azimuth_bounds_deg[column]).T
        density = self.chance[row, cell] / self.grid.projected_solid_angle_sr[cell]
        return np.minimum(zenith, np.pi / 2), start + (end - start) * around, density


def _middle(word: np.ndarray) -> np.ndarray:
    """Middle of one of 2^32 parts of (0, 1)."""
    return (word.astype(np.float64) + 0.5) * 2.0**-32


def density_of_once(medium: Medium, sun_zenith_rad: float, lights: Lights) -> DirectionDensity:
    """The density of a sky: its order 1 in patches, and a uniform sky.

    Parameters
    ----------
    medium : Medium
        The atmosphere.
    sun_zenith_rad : float
        Zenith angle of the sun. [rad, 0 to pi]
    lights : Lights
        From `chosen_lights`.

    Returns
    -------
    DirectionDensity
        A uniform sky where order 1 gives no light at all.
    """
    grid = PatchGrid.regular(*(BINS if sun_zenith_rad <= np.pi / 2 else BINS_TWILIGHT))
    light = np.zeros((medium.wavelength_nm.size, grid.n_patches))
    if lights.has_sun:
        once = solve_sky(medium, sun_zenith_rad=sun_zenith_rad, method="order1", moon=lights.moon)
        mean, _ = patch_means(once, grid, 0.0, tolerance=_TOLERANCE)
        light = mean[:, 0] * grid.projected_solid_angle_sr
    even = grid.projected_solid_angle_sr / grid.projected_solid_angle_sr.sum()
    whole = light.sum(axis=1, keepdims=True)
    share = np.divide(light, whole, out=np.broadcast_to(even, light.shape).copy(), where=whole > 0)
    floor = FLOOR if lights.moon is None and lights.ground_radiance is None else FLOOR_OTHER_LIGHT
    chance = (1.0 - floor) * share + floor * even
    upto = np.cumsum(chance, axis=1)
    chance /= upto[:, -1:]
    return DirectionDensity(grid=grid, chance=chance, upto=upto / upto[:, -1:], once=whole[:, 0])
