"""The diffuse light of a clear sky at the ground by successive orders of scattering.

The law and the method stand in `scattering_orders`; this module chooses the resolution, looks into the requested
directions and returns what the orders bring. A direction looked into is exact, not interpolated: its radiance is the
path integral of the source function that the moments of the order before give there. Azimuths stay Fourier modes,
so any azimuth is exact too.

Order 1 comes from the phase functions themselves. The later orders use their first moments x_l; see `Resolution`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from aomc_sky.atmosphere.angular_nodes import gauss_angles, split_table
from aomc_sky.atmosphere.angular_resolution import SERIES_LENGTH, Resolution, choose_resolution
from aomc_sky.atmosphere.columns import SUN_STEP_RAD, PlaneColumns, ShellColumns
from aomc_sky.atmosphere.formal_solution import Paths
from aomc_sky.atmosphere.legendre import phase_moments
from aomc_sky.atmosphere.medium import Medium
from aomc_sky.atmosphere.optical_depth import beam_optical_depth, vertical_optical_depth
from aomc_sky.atmosphere.order_one import scatterers
from aomc_sky.atmosphere.scattering_orders import (
    OrderMoments,
    scattering_moments,
    sum_orders,
)
from aomc_sky.atmosphere.slab import Layers, Slab
from aomc_sky.errors import UsageError

ALL_ORDERS = 1000
"""From this many orders on all are meant, and the rest is added as a geometric series."""

_GAIN_OF_DOUBLING = 4.0  # the least that twice the nodes and elements were seen to gain


@dataclass(frozen=True, kw_only=True, slots=True)
class DiffuseSky:
    """Radiance at the ground by orders, for a sun of irradiance F0, as cosine series of the azimuth.

    Parameters
    ----------
    sky_zenith_rad : ndarray, float64, shape (n_zenith,)
        Zenith angles looked into. [rad]
    later_modes : ndarray, float64, shape (n_wl, n_row, n_modes, n_zenith)
        Factors of cos(m phi). Row k is order k + 2; the last row is the sum of all orders after the listed ones.
    order_one : ndarray, float64, shape (n_wl, n_kind, n_zenith)
        Plane-parallel order 1 of each kind of particle, without its phase function. [W m-2 nm-1]
    phases : tuple of tuple of callable, (n_wl, n_kind)
        The phase functions that belong to it.
    sun_zenith_rad : float
        Zenith angle of the sun. [rad]
    irradiance_by_order : ndarray, float64, shape (n_wl, n_row + 1)
        Diffuse irradiance of orders 1, 2, ...; the last entry is the sum of the later ones. [W m-2 nm-1]
    sun_irradiance, direct_irradiance : ndarray, float64, shape (n_wl,)
        Of the beam above the atmosphere on a plane normal to it; at the ground on the horizontal. [W m-2 nm-1]
    n_orders : ndarray, int64, shape (n_wl,)
        Orders that were worked out one by one.
    rest, rest_error : ndarray, float64, shape (n_wl,)
        Share of the diffuse irradiance that stands in the geometric rest; the rest's estimated error, as a share.
    resolution_error : float
        Estimated error of cutting angles, depths and moments, as a share of the radiance; see `solve_orders`.
    """

    sky_zenith_rad: np.ndarray
    later_modes: np.ndarray
    order_one: np.ndarray
    phases: tuple[tuple[Callable[[np.ndarray], np.ndarray], ...], ...]
    sun_zenith_rad: float
    irradiance_by_order: np.ndarray
    sun_irradiance: np.ndarray
    direct_irradiance: np.ndarray
    n_orders: np.ndarray
    rest: np.ndarray
    rest_error: np.ndarray
    resolution_error: float

    @property
    def diffuse_irradiance(self) -> np.ndarray:
        """All orders together, shape (n_wl,). [W m-2 nm-1]"""
        return self.irradiance_by_order.sum(axis=1)

    @property
    def ground_irradiance(self) -> np.ndarray:
        """Direct and diffuse, shape (n_wl,). [W m-2 nm-1]"""
        return self.direct_irradiance + self.diffuse_irradiance

    def later_orders(self, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Radiance of all orders from 2 on.

        Parameters
        ----------
        azimuth_from_sun_rad : ndarray, float64, shape (n_azimuth,)
            0 looks into the sun's azimuth. [rad]

        Returns
        -------
        ndarray, float64, shape (n_wl, n_zenith, n_azimuth)
            [W m-2 sr-1 nm-1]
        """
        return self.later_modes.sum(axis=1).swapaxes(1, 2) @ self._cosines(azimuth_from_sun_rad)

    def by_order(self, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Radiance of orders 1 (plane-parallel), 2, ..., and of all later ones together.

        Returns
        -------
        ndarray, float64, shape (n_wl, n_row + 1, n_zenith, n_azimuth)
            [W m-2 sr-1 nm-1]
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


def solve_orders(
    medium: Medium,
    sun_zenith_rad: float,
    sky_zenith_rad: np.ndarray,
    *,
    n_listed: int = 1,
    resolution: Resolution | None = None,
) -> DiffuseSky:
    """Orders of scattering of a medium: a plane-parallel column lit by a beam through spherical shells.

    Parameters
    ----------
    medium : Medium
        The atmosphere. Its `n_orders` count exactly; ALL_ORDERS or more mean all.
    sun_zenith_rad : float
        Zenith angle of the sun. [rad, 0 to pi]
    sky_zenith_rad : ndarray, float64, shape (n_zenith,)
        Zenith angles to look into. [rad, 0 to pi/2]
    n_listed : int
        Last order that is listed on its own. [>= 1]
    resolution : Resolution or None
        How fine; None chooses by the phase functions.

    Returns
    -------
    DiffuseSky
        Of `medium.toa_irradiance`.

    Raises
    ------
    UsageError
        An angle or a number of orders is outside its range.
    """
    zenith = _checked(sun_zenith_rad, sky_zenith_rad, n_listed, np.pi)
    if not np.any(vertical_optical_depth(medium)[:, scatterers(medium)] > 0.0):
        return _dark_sky(medium, sun_zenith_rad, zenith, min(n_listed, medium.n_orders))
    task = _Task(
        columns_at=lambda n_element: ShellColumns(medium, n_element, sun_zenith_rad),
        albedo=medium.ground_albedo,
        irradiance=medium.toa_irradiance,
        n_orders=medium.n_orders,
        sun_zenith_rad=sun_zenith_rad,
        sky_zenith_rad=zenith,
        n_listed=min(n_listed, medium.n_orders),
    )
    return _solved(task, resolution)


def solve_layers(
    layers: Layers,
    albedo: float,
    sun_zenith_rad: float,
    sky_zenith_rad: np.ndarray,
    *,
    n_orders: int = ALL_ORDERS,
    n_listed: int = 1,
    resolution: Resolution | None = None,
) -> DiffuseSky:
    """Orders of scattering of homogeneous plane layers under a plane beam of irradiance 1 normal to itself.

    Parameters
    ----------
    layers : Layers
        The stack.
    albedo : float
        Of the Lambertian ground. [0 to 1]
    sun_zenith_rad : float
        Zenith angle of the sun. [rad, 0 to below pi/2]
    sky_zenith_rad, n_listed, resolution
        As for `solve_orders`.
    n_orders : int
        Orders that count; ALL_ORDERS or more mean all. [>= 1]

    Returns
    -------
    DiffuseSky
        With n_wl = 1.

    Raises
    ------
    UsageError
        An angle, an albedo or a number of orders is outside its range.
    """
    zenith = _checked(sun_zenith_rad, sky_zenith_rad, n_listed, np.nextafter(0.5 * np.pi, 0.0))
    if not 0.0 <= albedo <= 1.0 or n_orders < 1:
        raise UsageError("an albedo lies between 0 and 1, and there is one order or more")
    task = _Task(
        columns_at=lambda n_element: PlaneColumns(layers, n_element, sun_zenith_rad),
        albedo=np.array([albedo]),
        irradiance=np.ones(1),
        n_orders=n_orders,
        sun_zenith_rad=sun_zenith_rad,
        sky_zenith_rad=zenith,
        n_listed=min(n_listed, n_orders),
    )
    return _solved(task, resolution)


def _dark_sky(medium: Medium, sun_zenith_rad: float, zenith: np.ndarray, n_listed: int) -> DiffuseSky:
    """Nothing scatters: the direct beam alone."""
    n_wl = medium.wavelength_nm.size
    left = np.exp(-beam_optical_depth(medium, np.zeros(1), sun_zenith_rad)[:, 0])
    return DiffuseSky(
        sky_zenith_rad=zenith,
        later_modes=np.zeros((n_wl, n_listed, 1, zenith.size)),
        order_one=np.zeros((n_wl, 0, zenith.size)),
        phases=((),) * n_wl,
        sun_zenith_rad=sun_zenith_rad,
        irradiance_by_order=np.zeros((n_wl, n_listed + 1)),
        sun_irradiance=medium.toa_irradiance,
        direct_irradiance=medium.toa_irradiance * max(np.cos(sun_zenith_rad), 0.0) * left,
        n_orders=np.ones(n_wl, dtype=np.int64),
        rest=np.zeros(n_wl),
        rest_error=np.zeros(n_wl),
        resolution_error=0.0,
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class _Task:
    columns_at: Callable[[int | None], PlaneColumns | ShellColumns]
    albedo: np.ndarray
    irradiance: np.ndarray
    n_orders: int
    sun_zenith_rad: float
    sky_zenith_rad: np.ndarray
    n_listed: int


@dataclass(frozen=True, kw_only=True, slots=True)
class _Row:
    """One wavelength, for a sun of irradiance 1."""

    modes: np.ndarray
    order_one: np.ndarray
    moments: OrderMoments


def _checked(sun: float, sky: np.ndarray, n_listed: int, sun_limit: float) -> np.ndarray:
    zenith = np.atleast_1d(np.asarray(sky, dtype=np.float64))
    if not 0.0 <= sun <= sun_limit:
        raise UsageError(f"the sun's zenith angle must lie within 0 and {sun_limit:.6g} radians, not {sun!r}")
    if zenith.ndim != 1 or zenith.size == 0 or not np.all((zenith >= 0.0) & (zenith <= 0.5 * np.pi + 1e-12)):
        raise UsageError("zenith angles to look into form one row, each within 0 and pi/2 radians")
    if n_listed < 1:
        raise UsageError("at least order 1 is listed")
    return np.minimum(zenith, 0.5 * np.pi)


def _solved(task: _Task, resolution: Resolution | None) -> DiffuseSky:
    columns = task.columns_at(None if resolution is None else resolution.n_element)
    slabs = columns.slabs
    kinds = [np.stack([phase_moments(law, SERIES_LENGTH) for law in slab.phases]) for slab in slabs]
    chosen = resolution or choose_resolution(slabs, kinds, columns.n_element, columns.ripple, columns.most_moments)
    view = _View(task, chosen, columns)
    rows = [view.solved(row, kinds[row]) for row in range(len(slabs))]
    thickest = int(np.argmax([slab.edge_depth[-1] for slab in slabs]))
    half = chosen.halved()
    coarse = _View(task, half, task.columns_at(half.n_element)).solved(thickest, kinds[thickest])
    sky = _gathered(task, slabs, rows)
    moved = _difference(sky, thickest, chosen.peak_error, rows[thickest], coarse)
    return replace(sky, resolution_error=moved)


class _View:
    """The requested directions of one resolution, ready for any column."""

    def __init__(self, task: _Task, resolution: Resolution, columns: PlaneColumns | ShellColumns) -> None:
        n = resolution.n_moments
        self._task, self._n_moments = task, n
        self._angles = gauss_angles(resolution.n_mu, n)
        mu = np.cos(task.sky_zenith_rad)
        self._columns, self._paths = columns, columns.directed(self._angles.mu, mu)
        self._tables = split_table(mu, n, n)
        self._factor = np.where(np.arange(n) == 0, 1.0, 2.0)[:, None]  # of cos(m phi)

    def solved(self, row: int, kinds: np.ndarray) -> _Row:
        """Solve the column of one wavelength; `kinds` are the moments of its particles."""
        slab = self._columns.slabs[row]
        paths, seen = self._paths(row)
        scattering = scattering_moments(slab, kinds[:, : self._n_moments], self._n_moments)
        found = self._summed(row, slab, paths, scattering, self._task.n_listed + 1)
        drift = None
        if seen.turn is not None:
            drift = -seen.turn * self._steepness(row, paths, scattering, found.total)
        sources = found.listed[1:-1]
        modes = [self._looked_into(seen.weights, drift, scattering, each) for each in sources]
        modes.append(self._looked_into(seen.weights, drift, scattering, found.total - sources.sum(axis=0)))
        lit = slab.scattering.reshape(slab.scattering.shape[0], -1) * slab.beam.ravel()
        return _Row(modes=np.stack(modes), order_one=lit @ seen.weights.T, moments=found)

    def _summed(
        self, row: int, slab: Slab, paths: Paths, scattering: np.ndarray, n_listed: int, turn: float = 0.0
    ) -> OrderMoments:
        task = self._task
        return sum_orders(
            slab,
            paths,
            scattering,
            self._angles,
            float(np.cos(task.sun_zenith_rad + turn)),
            float(task.albedo[row]),
            last_order=None if task.n_orders >= ALL_ORDERS else task.n_orders,
            n_listed=n_listed,
        )

    def _steepness(self, row: int, paths: Paths, scattering: np.ndarray, total: np.ndarray) -> np.ndarray:
        """Logarithmic derivative of the mean radiance at the levels (n_level,) by the sun's zenith angle. [rad-1]"""
        slab = self._columns.turned_slabs[row]
        moved = self._summed(row, slab, paths, scattering[:, :1], 1, SUN_STEP_RAD).total[0, 0, 0]
        here = total[0, 0, 0]
        lit = here > 0.0
        return np.where(lit, moved / np.where(lit, here, 1.0) - 1.0, 0.0) / SUN_STEP_RAD

    def _looked_into(
        self, weights: np.ndarray, drift: np.ndarray | None, scattering: np.ndarray, moments: np.ndarray
    ) -> np.ndarray:
        """Factors of cos(m phi) (n_modes, n_zenith) of the order after the one with these moments."""
        source = sum(np.matmul(self._tables[p].swapaxes(1, 2), scattering[p] * moments[p]) for p in (0, 1))
        modes = self._factor * np.einsum("vk,mvk->mv", weights, source)
        if drift is None:
            return modes
        tilted = self._factor * np.einsum("vk,mvk->mv", weights * drift, source)
        return np.concatenate([modes, np.zeros_like(modes[:1])]) + times_cosine(tilted)


def times_cosine(modes: np.ndarray) -> np.ndarray:
    """Factors of cos(m phi) of a cosine series times cos(phi): one mode more.

    Parameters
    ----------
    modes : ndarray, float64, shape (n_modes, n)
        Factors a_m.

    Returns
    -------
    ndarray, float64, shape (n_modes + 1, n)
    """
    product = np.zeros((modes.shape[0] + 1, modes.shape[1]))
    product[1:] += 0.5 * modes
    product[1] += 0.5 * modes[0]
    product[: modes.shape[0] - 1] += 0.5 * modes[1:]
    return product


def _gathered(task: _Task, slabs: tuple[Slab, ...], rows: list[_Row]) -> DiffuseSky:
    """All wavelengths, for the sun's irradiance."""
    light = task.irradiance
    found = [row.moments for row in rows]
    listed = np.array([each.irradiance for each in found])
    later = np.array([each.irradiance_total for each in found]) - listed[:, 1:].sum(axis=1)
    return DiffuseSky(
        sky_zenith_rad=task.sky_zenith_rad,
        later_modes=light[:, None, None, None] * np.stack([row.modes for row in rows]),
        order_one=light[:, None, None] * np.stack([row.order_one for row in rows]),
        phases=tuple(slab.phases for slab in slabs),
        sun_zenith_rad=task.sun_zenith_rad,
        irradiance_by_order=light[:, None] * np.column_stack([listed[:, 1:], later]),
        sun_irradiance=light,
        direct_irradiance=light * listed[:, 0],
        n_orders=np.array([each.n_orders for each in found]),
        rest=np.array([each.rest for each in found]),
        rest_error=np.array([each.rest_error for each in found]),
        resolution_error=0.0,
    )


def _difference(sky: DiffuseSky, row: int, ripple: float, fine: _Row, coarse: _Row) -> float:
    """Estimated error at three azimuths, as a share of the radiance: a coarser solution's, and cut moments'."""
    azimuth = np.array([0.0, 0.5, 1.0]) * np.pi
    change = fine.modes.sum(axis=0) - coarse.modes.sum(axis=0)
    cosines = np.cos(np.arange(change.shape[0])[:, None] * azimuth)
    later = fine.modes.sum(axis=0).T @ cosines
    wrong = np.abs(change.T @ cosines) / _GAIN_OF_DOUBLING + ripple * later.mean()
    whole = later + sky.plane_order_one(azimuth)[row] / max(float(sky.sun_irradiance[row]), np.finfo(float).tiny)
    lit = whole > 0.0
    return float(np.max(wrong[lit] / whole[lit], initial=0.0))
