"""Orders 2 and up of a clear sky at the ground by successive orders of scattering, and source functions.

`orders` has the law. A direction looked into is exact, not interpolated: its radiance is the path integral of the
source function that the moments of the order before give there. Azimuths stay Fourier modes.

Per volume, order n of the light is scattered into a direction as

S^n = beta J^n, J^n(tau, +-mu, phi) = sum_m (2 - [m = 0]) J_m^n(tau, +-mu) cos(m phi),

with beta the extinction coefficient.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from aomc_sky.progress import counted
from aomc_sky.skies.atmosphere.medium import Medium
from aomc_sky.skies.atmosphere.scattering_orders.orders import (
    OrderMoments,
    gauss_angles,
    light_from_ground,
    phase_moments,
    scattering_moments,
    split_table,
    sum_orders,
)
from aomc_sky.skies.atmosphere.scattering_orders.paths import SUN_STEP_RAD, Paths, ShellColumns, ShellPaths
from aomc_sky.skies.atmosphere.scattering_orders.slab import Slab

ALL_ORDERS = 1000
"""From this many orders on all are meant, and the rest is added as a geometric series."""


@dataclass(frozen=True, kw_only=True, slots=True)
class LaterOrders:
    """Orders 2 and up in some zenith angles, by paths or by successive orders."""

    #: (n_wl, n_row, n_modes, n_zenith) series of orders 2, 3, ... in the azimuth. They are factors of cos(m phi), or as
    #: `SkyField` has them where it is not mirrored. [W m-2 sr-1 nm-1]
    modes: np.ndarray
    truncation: np.ndarray  #: (n_wl,) estimated share of the sky's irradiance in the orders that do not count
    #: Estimated error of cutting angles and depths, as a share of these orders; of paths the median standard error of
    #: one direction
    resolution_error: float
    n_paths: int = 0  #: Paths of each direction and wavelength
    #: (n_wl, n_zenith, n_azimuth) standard error of their sum in each direction that paths followed. [W m-2 sr-1 nm-1]
    node_error: np.ndarray | None = None


def solve_orders(
    medium: Medium, sun_zenith_rad: float, sky_zenith_rad: np.ndarray, n_orders: int, *, n_listed: int
) -> LaterOrders:
    """Orders 2 to `n_orders` by successive orders, and what the orders above them would bring; something scatters.

    The medium's own number of orders does not count. Orders from `n_listed` on, order 1 among those listed, share the
    last row where more count. With order 1 from its own solver the sky's radiance is within 0.5 % for a sun above 10
    degrees, 1.5 % at 5.
    """
    if n_orders <= n_listed:
        modes, irradiance, error = summed_orders(medium, sun_zenith_rad, sky_zenith_rad, ALL_ORDERS, n_listed=n_orders)
        modes, left, total = modes[:, :-1], irradiance[:, -1], irradiance.sum(axis=1)
    else:
        modes, irradiance, error = summed_orders(
            medium, sun_zenith_rad, sky_zenith_rad, n_orders, n_listed=n_listed - 1
        )
        left = np.zeros(irradiance.shape[0])
        if n_orders < ALL_ORDERS:  # by the ratio of the last two orders that are listed
            before, last = irradiance[:, -3], irradiance[:, -2]
            ratio = np.divide(last, before, out=np.zeros_like(last), where=before > 0)
            left = last * ratio ** (n_orders - n_listed + 2) / np.maximum(1.0 - ratio, 1e-6)
        total = irradiance.sum(axis=1) + left
    truncation = np.divide(left, total, out=np.zeros_like(left), where=total > 0)
    return LaterOrders(modes=modes, truncation=truncation, resolution_error=error)


def summed_orders(
    medium: Medium, sun_zenith_rad: float, sky_zenith_rad: np.ndarray, n_orders: int, *, n_listed: int
) -> tuple[np.ndarray, np.ndarray, float]:
    """Orders 2 to `n_orders`, ALL_ORDERS or more for all: sources by altitude, beam and paths through spherical shells.

    Modes, as `LaterOrders` has them, of orders 2 to `n_listed` and of the sum of those after; the diffuse irradiance of
    orders 1 to `n_listed` and of those after, (n_wl, n_listed + 1) [W m-2 nm-1]; and the resolution error.
    """
    columns, kinds, chosen = _resolved(medium, sun_zenith_rad)
    half = chosen.halved()
    fine, coarse = (
        _View(medium, sun_zenith_rad, np.cos(sky_zenith_rad), each, at, n_orders, n_listed)
        for each, at in ((chosen, columns), (half, ShellColumns(medium, half.n_element, sun_zenith_rad)))
    )
    rows = [fine.solved(row, kinds[row]) for row in counted(range(len(kinds)), "wavelength", len(kinds))]
    thickest = int(np.argmax([slab.edge_depth[-1] for slab in columns.slabs]))
    modes, light = np.stack([row for row, _ in rows]), medium.toa_irradiance
    listed = np.array([orders.irradiance[1:] for _, orders in rows])
    later = np.array([orders.irradiance_total for _, orders in rows]) - listed.sum(axis=1)
    return (
        light[:, None, None, None] * modes,
        light[:, None] * np.column_stack([listed, later]),
        _difference(modes[thickest], coarse.solved(thickest, kinds[thickest])[0], chosen.ripple),
    )


def _resolved(medium: Medium, sun_zenith_rad: float) -> tuple[ShellColumns, list[np.ndarray], Resolution]:
    """Columns of a medium, phase moments (n_kind, SERIES_LENGTH) of each, and the resolution that they ask for."""
    columns = ShellColumns(medium, None, sun_zenith_rad)
    kinds = [np.stack([phase_moments(law, SERIES_LENGTH) for law in slab.phases]) for slab in columns.slabs]
    chosen = choose_resolution(columns.slabs, kinds, columns.n_element, columns.ripple, columns.most_moments)
    return columns, kinds, replace(chosen, n_mu=max(chosen.n_mu, least_nodes(medium.least_angles)))


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
    """Source functions of successive orders of scattering, in the resolution of `solve_orders`; something scatters.

    Zenith angles beyond pi/2 look at light that travels up; `n_orders` is the last order that is listed, 2 or more. The
    sun's zenith angle is that of the observer at all altitudes.
    """
    columns, kinds, chosen = _resolved(medium, sun_zenith_rad)
    n, mu = chosen.n_moments, np.cos(zenith_rad)
    angles = gauss_angles(chosen.n_mu, n)
    shells = ShellPaths(columns.grid, angles.mu, np.ones(1))
    tables = split_table(np.abs(mu), n, n)
    signed = (tables[0], tables[1] * np.sign(mu))
    cosines = np.where(np.arange(n) == 0, 1.0, 2.0)[:, None] * np.cos(np.outer(np.arange(n), azimuth_from_sun_rad))
    grid, light = columns.grid, medium.toa_irradiance
    by_order, from_ground = [], []
    for row, slab in enumerate(columns.slabs):
        extinction = grid.profile.extinction_m2[row]
        paths, _ = shells.weights(slab, extinction)
        scattering = scattering_moments(slab, kinds[row][:, :n] * chosen.window(), n)
        mu0, albedo = float(np.cos(sun_zenith_rad)), float(medium.ground_albedo[row])
        orders = sum_orders(
            slab, paths, scattering, angles, mu0, albedo, last_order=n_orders, n_listed=n_orders
        )  # fmt: skip
        scale = light[row] * (grid.node_density @ extinction).reshape(-1, 1, 1)
        modes = [_modes(signed, scattering, each) for each in orders.listed]
        by_order.append([scale * np.einsum("mvk,ma->kva", each, cosines[: each.shape[0]]) for each in modes])
        ground = _modes(signed, scattering, light_from_ground(slab, paths, scattering, angles, mu0, albedo)[:, :1])
        from_ground.append(scale[:, 0] * ground[0].T)
    return SourceFunctions(
        altitude_m=grid.node_m.ravel(), by_order=np.array(by_order), from_ground=np.array(from_ground)
    )


def _modes(tables: tuple[np.ndarray, np.ndarray], scattering: np.ndarray, moments: np.ndarray) -> np.ndarray:
    """Modes J_m (n_modes, n_zenith, n_level) of the source function that these moments (2, n_modes, ...) bring."""
    n = moments.shape[1]
    return np.asarray(sum(np.matmul(tables[p][:n].swapaxes(1, 2), scattering[p, :n] * moments[p]) for p in (0, 1)))


SERIES_LENGTH = 256
"""Legendre moments that are looked at when a resolution is chosen."""

MOST_MU_NODES = 64
"""Nodes that a wish for many directions may bring."""

_LEAST_MU_NODES = 20
_MOST_RIPPLE = 1e-2


@dataclass(frozen=True, kw_only=True, slots=True)
class Resolution:
    """How finely angles and depths are cut."""

    n_mu: int  #: Gauss nodes of one hemisphere. [>= 4]
    n_element: int  #: Elements spread over the column. [>= 2]
    #: Degrees l < n_moments of the phase functions, as many modes of the azimuth. [<= 2 (n_mu - 6): energy is kept]
    n_moments: int
    peak_error: float = 0.0  #: Estimated share of the mean of order 2 that the cut moments would bring

    @property
    def ripple(self) -> float:
        """`peak_error` after the window, away from the sun."""
        return min(self.peak_error, _MOST_RIPPLE)

    def window(self) -> np.ndarray:
        """Factors of the moments x_l, (n_moments,): 1, or a Gaussian that blurs a peak too sharp for the series.

        Cut moments of a sharper peak leave ripples as strong as the sky; blurred, only some degrees around the sun are
        wrong.
        """
        last = min(1.0, np.sqrt(_MOST_RIPPLE / max(self.peak_error, _MOST_RIPPLE)))
        return np.asarray(last ** (np.arange(self.n_moments) / self.n_moments) ** 2)

    def halved(self) -> Resolution:
        """Half the elements, half the nodes or what the moments need: it serves to estimate the error."""
        n_mu = max(self.n_mu // 2, 3 + (self.n_moments + 1) // 2, 4)
        return replace(self, n_mu=n_mu, n_element=max(self.n_element // 2, 2))


def least_nodes(n_directions: int) -> int:
    """Gauss nodes of a hemisphere for so many directions on the sphere: half the root, at most 64."""
    return min(math.ceil(0.5 * math.sqrt(n_directions)), MOST_MU_NODES)


def choose_resolution(
    slabs: Sequence[Slab], kinds: Sequence[np.ndarray], n_element: int, tolerance: float, most_moments: int
) -> Resolution:
    """Resolution that the most peaked phase function of a set of columns asks for.

    A series cut at degree N lacks a narrow peak at the sun, where order 1 is far brighter. It leaves ripples all over
    the sky. They are about (N + 1/2) x_N^2 (depth of the peaked / of all scatterers)^2 of the mean of order 2: at most
    `tolerance`. Each column has its phase moments (n_kind, SERIES_LENGTH) in `kinds`.
    """
    degree = np.arange(SERIES_LENGTH)
    missing = np.zeros(SERIES_LENGTH + 1)
    for slab, moments in zip(slabs, kinds, strict=True):
        depth = slab.scattering.mean(axis=2) @ np.diff(slab.edge_depth)
        weight = (depth / max(depth.sum(), np.finfo(float).tiny)) ** 2
        share = weight @ ((degree + 0.5) * moments**2)
        missing[:-1] = np.maximum(missing[:-1], np.maximum.accumulate(share[::-1])[::-1])
    enough = int(np.argmax(missing <= tolerance))
    n_moments = int(np.clip(enough, 3, most_moments))
    return Resolution(
        n_mu=max(_LEAST_MU_NODES, 6 + (n_moments + 1) // 2),
        n_element=n_element,
        n_moments=n_moments,
        peak_error=float(missing[n_moments]),
    )


_STEEPEST = 0.9  # change of a source towards the sun: it stays positive where the sun sets along a path
_GAIN_OF_DOUBLING = 4.0  # the least that twice the nodes and elements were seen to gain


class _View:
    """The directions looked into at one resolution, ready for any column; light is for a sun of irradiance 1."""

    def __init__(
        self,
        medium: Medium,
        sun_zenith_rad: float,
        mu: np.ndarray,
        resolution: Resolution,
        columns: ShellColumns,
        n_orders: int,
        n_listed: int,
    ) -> None:
        n = resolution.n_moments
        self._medium, self._sun_zenith_rad, self._n_moments = medium, sun_zenith_rad, n
        self._last_order, self._n_listed = None if n_orders >= ALL_ORDERS else n_orders, n_listed
        self._angles = gauss_angles(resolution.n_mu, n)
        self._columns, self._paths = columns, ShellPaths(columns.grid, self._angles.mu, mu)
        self._tables = split_table(mu, n, n)
        self._window = resolution.window()
        self._factor = np.where(np.arange(n) == 0, 1.0, 2.0)[:, None]  # of cos(m phi)

    def solved(self, row: int, kinds: np.ndarray) -> tuple[np.ndarray, OrderMoments]:
        """Modes (n_row, n_modes, n_zenith) of one wavelength, and its orders; `kinds` are its particles' moments."""
        slab = self._columns.slabs[row]
        paths, weights = self._paths.weights(slab, self._columns.grid.profile.extinction_m2[row])
        scattering = scattering_moments(slab, kinds[:, : self._n_moments] * self._window, self._n_moments)
        orders = self._summed(row, slab, paths, scattering, self._n_listed)
        moved = self._summed(row, self._columns.turned_slabs[row], paths, scattering[:, :1], 1, SUN_STEP_RAD)
        after, here = moved.total[0, 0, 0], orders.total[0, 0, 0]
        lit = here > 0.0
        # logarithmic derivative of the mean radiance at the levels by the sun's zenith angle
        steepness = np.where(lit, after / np.where(lit, here, 1.0) - 1.0, 0.0) / SUN_STEP_RAD
        drift = np.clip(-self._paths.turn * steepness, -_STEEPEST, _STEEPEST)
        rest = orders.total.copy()
        for each in orders.listed:
            rest[:, : each.shape[1]] -= each
        sources = (*orders.listed, rest)
        modes = np.zeros((len(sources), rest.shape[1] + 1, weights.shape[0]))
        for place, each in zip(modes, sources, strict=True):
            source = _modes(self._tables, scattering, each)  # of the order after that of these moments
            n = source.shape[0]
            place[:n] = self._factor[:n] * np.einsum("vk,mvk->mv", weights, source)
            place[: n + 1] += times_cosine(self._factor[:n] * np.einsum("vk,mvk->mv", weights * drift, source))
        return modes, orders

    def _summed(
        self, row: int, slab: Slab, paths: Paths, scattering: np.ndarray, n_listed: int, turn: float = 0.0
    ) -> OrderMoments:
        return sum_orders(
            slab,
            paths,
            scattering,
            self._angles,
            float(np.cos(self._sun_zenith_rad + turn)),
            float(self._medium.ground_albedo[row]),
            last_order=self._last_order,
            n_listed=n_listed,
        )


def times_cosine(modes: np.ndarray) -> np.ndarray:
    """Factors of cos(m phi) of a cosine series times cos(phi), (n_modes + 1, n): one mode more."""
    product = np.zeros((modes.shape[0] + 1, modes.shape[1]))
    product[1:] += 0.5 * modes
    product[1] += 0.5 * modes[0]
    product[: modes.shape[0] - 1] += 0.5 * modes[1:]
    return product


def _difference(fine: np.ndarray, coarse: np.ndarray, ripple: float) -> float:
    """Estimated error of modes (n_row, n_modes, n_zenith) at three azimuths: a coarser solution's, and cut moments'."""
    azimuth = np.array([0.0, 0.5, 1.0]) * np.pi
    cosines = np.cos(np.arange(fine.shape[1])[:, None] * azimuth)
    later = fine.sum(axis=0).T @ cosines
    change = (fine.sum(axis=0) - coarse.sum(axis=0)).T @ cosines
    wrong = np.abs(change) / _GAIN_OF_DOUBLING + ripple * later.mean()
    lit = later > 0.0
    return float(np.max(wrong[lit] / later[lit], initial=0.0))
