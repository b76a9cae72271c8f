"""A clear sky after its solution: smooth fields of the direction, radiance anywhere, means over patches."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from aomc_sky.grid import PatchGrid
from aomc_sky.skies.atmosphere.lights import GroundBeam, Moon, is_mirrored
from aomc_sky.skies.atmosphere.medium import Medium
from aomc_sky.skies.atmosphere.order_one import scattered_once, scattering_cosine, with_phases
from aomc_sky.skies.quadrature import angles_at, zeniths_at

HALF_PI = np.pi / 2


@dataclass(frozen=True, kw_only=True, slots=True)
class SkyField:
    """Functions of zenith angle and azimuth from the sun, as a rule mirrored on the sun's vertical plane.

    Light along a ray through shells is smooth in both angles; only phase functions may be sharp, and they stay outside.
    """

    #: (..., n_zenith, n_azimuth) of T_k(2 u - 1) cos(m phi), where u = sqrt(1 - theta / (pi/2)). The square root crowds
    #: the nodes at the horizon, where air masses change over a degree. It is smooth overhead, where cos(theta) would
    #: not be
    coefficient: np.ndarray
    #: False: n_azimuth is odd, and the sines of m = 1 ... n // 2 follow the cosines of m = 0 ... n // 2.
    is_mirrored: bool = True

    def at(self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Values in single directions (n,), shape (..., n)."""
        rows = _zenith_basis(sky_zenith_rad, self.coefficient.shape[-2])
        columns = azimuth_basis(azimuth_from_sun_rad, self.coefficient.shape[-1], is_mirrored=self.is_mirrored)
        return np.einsum("nk,...kn->...n", rows, self.coefficient @ columns.T)

    def in_cells(
        self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray, ring: np.ndarray, column: np.ndarray
    ) -> np.ndarray:
        """Values (..., n_cell, n, n) on the nodes of some cells of rings (n_ring, n) and columns (n_column, n).

        `ring` and `column` are the cells' indices; rings do not fall.
        """
        pieces = []
        for one in np.unique(ring):
            here = azimuth_from_sun_rad[column[ring == one]]
            rows = _zenith_basis(sky_zenith_rad[one], self.coefficient.shape[-2])
            columns = azimuth_basis(here.ravel(), self.coefficient.shape[-1], is_mirrored=self.is_mirrored)
            field = rows @ (self.coefficient @ columns.T)
            pieces.append(field.reshape(*field.shape[:-1], *here.shape).swapaxes(-3, -2))
        return np.concatenate(pieces, axis=-3)

    def means(self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray, weight: np.ndarray) -> np.ndarray:
        """Weighted means (..., n_ring, n_column) over patches with nodes (n_ring, n) and (n_column, n).

        The series is averaged term by term, so that many nodes cost little.
        """
        rows = _zenith_basis(sky_zenith_rad.ravel(), self.coefficient.shape[-2])
        columns = azimuth_basis(azimuth_from_sun_rad.ravel(), self.coefficient.shape[-1], is_mirrored=self.is_mirrored)
        row_means = np.einsum("znk,n->zk", rows.reshape(*sky_zenith_rad.shape, -1), weight)
        column_means = np.einsum("anm,n->am", columns.reshape(*azimuth_from_sun_rad.shape, -1), weight)
        return row_means @ (self.coefficient @ column_means.T)


def fit_field(
    values: Callable[[np.ndarray, np.ndarray], np.ndarray], *, n_zenith: int, n_azimuth: int, is_mirrored: bool = True
) -> SkyField:
    """Fit a field through the values at its nodes; an odd `n_azimuth` over the whole turn where it is not mirrored."""
    phi = azimuth_nodes(n_azimuth, is_mirrored=is_mirrored)
    zenith, azimuth = np.meshgrid(zenith_nodes(n_zenith), phi, indexing="ij")
    value = values(zenith.ravel(), azimuth.ravel())
    on_nodes = value.reshape(*value.shape[:-1], n_zenith, n_azimuth)
    series = _to_series(n_zenith) @ on_nodes @ to_azimuth_series(n_azimuth, is_mirrored=is_mirrored).T
    return SkyField(coefficient=series, is_mirrored=is_mirrored)


def zenith_nodes(n: int) -> np.ndarray:
    """Zenith angles of the nodes of a field, from near the zenith to near the horizon, shape (n,). [rad]"""
    u = (np.cos((np.arange(n) + 0.5) * np.pi / n) + 1) / 2  # of Chebyshev
    return HALF_PI * (1 - u * u)


def azimuth_nodes(n: int, *, is_mirrored: bool) -> np.ndarray:
    """Azimuths of the nodes of a field, over half a turn or a whole one, shape (n,). [rad]"""
    return (np.arange(n) + 0.5) * (np.pi if is_mirrored else 2.0 * np.pi) / n


def to_azimuth_series(n: int, *, is_mirrored: bool) -> np.ndarray:
    """Matrix from values at `azimuth_nodes` to the factors of the azimuth's series, shape (n, n)."""
    if is_mirrored:
        return _to_series(n)
    matrix = azimuth_basis(azimuth_nodes(n, is_mirrored=False), n, is_mirrored=False).T * (2.0 / n)
    matrix[0] /= 2
    return matrix


def field_of_modes(modes: np.ndarray, *, is_mirrored: bool = True) -> SkyField:
    """A field from its series in the azimuth (..., n_azimuth, n_zenith) at `zenith_nodes`."""
    return SkyField(coefficient=_to_series(modes.shape[-1]) @ modes.swapaxes(-1, -2), is_mirrored=is_mirrored)


def _to_series(n: int) -> np.ndarray:
    """Matrix from values at the nodes to coefficients of T_0 ... T_{n-1}."""
    angle = (np.arange(n) + 0.5) * np.pi / n
    matrix = np.cos(np.outer(np.arange(n), angle)) * 2.0 / n
    matrix[0] /= 2
    return matrix


def _zenith_basis(sky_zenith_rad: np.ndarray, n: int) -> np.ndarray:
    u = np.sqrt(np.clip(1 - sky_zenith_rad / HALF_PI, 0.0, 1.0))
    return np.cos(np.outer(np.arccos(2 * u - 1), np.arange(n)))


def azimuth_basis(azimuth_from_sun_rad: np.ndarray, n: int, *, is_mirrored: bool) -> np.ndarray:
    """Terms of the azimuth's series, shape (n_azimuth, n)."""
    if is_mirrored:
        return np.cos(np.outer(azimuth_from_sun_rad, np.arange(n)))
    angle = np.outer(azimuth_from_sun_rad, np.arange(n // 2 + 1))
    return np.concatenate([np.cos(angle), np.sin(angle[:, 1:])], axis=1)


@dataclass(frozen=True, kw_only=True, slots=True)
class ExactOrderOne:
    """Light of order 1 as `SkyField` gives it, solved anew in every direction: no series holds the earth's shadow."""

    medium: Medium
    sun_zenith_rad: float

    def at(self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Values in single directions (n,), shape (n_wl, n_scatterer, n)."""
        return scattered_once(self.medium, self.sun_zenith_rad, sky_zenith_rad, azimuth_from_sun_rad)

    def in_cells(
        self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray, ring: np.ndarray, column: np.ndarray
    ) -> np.ndarray:
        """Values on the nodes of cells, as `SkyField.in_cells`, shape (n_wl, n_scatterer, n_cell, n, n)."""
        theta, phi = np.broadcast_arrays(sky_zenith_rad[ring][:, :, None], azimuth_from_sun_rad[column][:, None, :])
        values = self.at(theta.ravel(), phi.ravel())
        return values.reshape(*values.shape[:2], *theta.shape)


@dataclass(frozen=True, kw_only=True, slots=True)
class SolvedSky:
    """Radiance of the sky at the ground, as phase functions times smooth fields."""

    medium: Medium
    sun_zenith_rad: float
    #: (n_wl, n_scatterer, ...) light scattered once by each kind of particle, without its phase function. [W m-2 nm-1]
    order_one: SkyField | ExactOrderOne
    later_orders: SkyField | None  #: (n_wl, n_order - 1, ...) orders 2 and up, if any. [W m-2 sr-1 nm-1]
    direct: GroundBeam
    method: str  #: "order1", "sos" or "mc"
    n_orders: int  #: Most interactions that count
    #: (n_wl,) estimated share of the sky's irradiance in the orders that do not count; NaN for order 1 alone
    truncation: np.ndarray
    resolution_error: float  #: Estimated error of orders 2 and up, as a share of them, as `LaterOrders` has it
    moon: Moon | None = None  #: It hides part of the sun
    visible_share: float = 1.0  #: Share of the sun's disc that the observer sees; `direct` has it already
    glow: SkyField | None = None  #: (n_wl, n_listed, ...) orders 1 and up of a glowing ground. [W m-2 sr-1 nm-1]
    glow_error: float = 0.0  #: Standard error of one direction of it, as a share
    #: Of "mc": (n_wl, n_zenith, n_azimuth) standard error of orders 2 and up at `zenith_nodes` and `azimuth_nodes`
    node_error: np.ndarray | None = None
    reason: str = ""  #: Why "auto" took the method; empty where the method was asked for
    n_paths: int = 0  #: Backward paths of each direction and wavelength; 0 where no paths brought orders 2 and up

    @property
    def n_listed(self) -> int:
        """Orders that are kept one by one; the last one holds all later ones too."""
        n_of_sun = 1 if self.later_orders is None else 1 + int(self.later_orders.coefficient.shape[1])
        return max(n_of_sun, 0 if self.glow is None else int(self.glow.coefficient.shape[1]))

    @property
    def is_mirrored(self) -> bool:
        """Whether the sky right of the sun is that left of it."""
        return is_mirrored(self.moon)

    @property
    def direct_irradiance(self) -> np.ndarray:
        """Irradiance of the direct beam on the horizontal ground, shape (n_wl,). [W m-2 nm-1]"""
        return self.direct.irradiance

    @property
    def direct_normal(self) -> np.ndarray:
        """Irradiance of the direct beam on a plane normal to it, shape (n_wl,). [W m-2 nm-1]"""
        return self.visible_share * self.medium.toa_irradiance * np.exp(-self.direct.optical_depth)

    def at(self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Radiance of all orders together in single directions (n,), shape (n_wl, n). [W m-2 sr-1 nm-1, >= 0]"""
        order_one = self.order_one.at(sky_zenith_rad, azimuth_from_sun_rad)
        radiance = self.with_phases(order_one, sky_zenith_rad, azimuth_from_sun_rad)
        for part in (self.later_orders, self.glow):
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

    def with_phases(
        self, parts: np.ndarray, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray
    ) -> np.ndarray:
        """Radiance (n_wl, ...) from values of `order_one`, (n_wl, n_scatterer, ...); directions broadcast."""
        return with_phases(
            self.medium, parts, scattering_cosine(self.sun_zenith_rad, sky_zenith_rad, azimuth_from_sun_rad)
        )


FIRST_POINTS = 3
"""Gauss points of order 1 in each direction of a patch, before any patch is refined."""

MORE_POINTS = 16
"""Gauss points of the orders above, whose series are averaged term by term."""

_GROWTH = 5 / 3
_MOST_POINTS = 64
_MOST_VALUES = 2_000_000
"""Radiances evaluated at a time, so that no call takes more than some ten megabytes."""


def patch_means(
    sky: SolvedSky, grid: PatchGrid, sun_azimuth_rad: float, *, tolerance: float = 1e-5
) -> tuple[np.ndarray, float]:
    """Flux-weighted mean radiance of every patch by order, (n_wl, n_order, n_patch), and the change of order 1.

    The mean is the integral of L cos over the patch / its projected solid angle [W m-2 sr-1 nm-1]. The change is the
    largest relative one of any patch by its last refinement, and is above its error. Patches are refined until it is at
    most `tolerance`. Gauss points are in mu^2 and azimuth: 3 x 3 of order 1, then 5 x 5, then more where the mean still
    changes.
    """
    columns, mirror = _distinct_columns(grid, sun_azimuth_rad, is_mirrored=sky.is_mirrored)
    unsettled, n_points = np.arange(grid.n_zenith * len(columns)), FIRST_POINTS
    order_one, change = _means(sky, grid, columns, unsettled, n_points), np.zeros(unsettled.size)
    while n_points < _MOST_POINTS and unsettled.size:
        n_points = min(int(np.ceil(n_points * _GROWTH)), _MOST_POINTS)
        finer = _means(sky, grid, columns, unsettled, n_points)
        moved = np.abs(finer - order_one[:, unsettled])
        change[unsettled] = np.divide(moved, finer, out=np.zeros_like(finer), where=finer > 0).max(axis=0)
        order_one[:, unsettled] = finer
        unsettled = np.flatnonzero(change > tolerance)
    mean = np.zeros((order_one.shape[0], sky.n_listed, grid.n_zenith, len(columns)))
    mean[:, 0] = order_one.reshape(order_one.shape[0], grid.n_zenith, -1)
    if sky.later_orders is not None:
        share, weight = _gauss(MORE_POINTS)
        azimuth = angles_at(columns, share)
        mean[:, 1:] = np.maximum(sky.later_orders.means(zeniths_at(grid, share), azimuth, weight), 0.0)
    if sky.glow is not None:
        mean += glow_means(sky.glow, grid)[..., None]
    return mean[..., mirror].reshape(*mean.shape[:2], -1), float(change.max(initial=0.0))


def glow_means(glow: SkyField, grid: PatchGrid) -> np.ndarray:
    """Means of a sky that is the same all around over the rings of a grid, shape (n_wl, n_order, n_zenith)."""
    share, weight = _gauss(MORE_POINTS)
    anywhere = np.zeros((1, MORE_POINTS))
    return np.maximum(glow.means(zeniths_at(grid, share), anywhere, weight)[..., 0], 0.0)


def _distinct_columns(grid: PatchGrid, sun_azimuth_rad: float, *, is_mirrored: bool) -> tuple[np.ndarray, np.ndarray]:
    """Columns that are no mirror image of another on the sun's vertical plane, and which of them each column is.

    Columns are (n, 2) azimuths from the sun [rad], the others indices (n_azimuth,) into them.
    """
    bounds = np.deg2rad(grid.azimuth_bounds_deg) - sun_azimuth_rad
    middle, width = bounds.mean(axis=1), bounds[:, 1] - bounds[:, 0]
    folded = np.mod(middle + np.pi, 2 * np.pi) - np.pi
    if is_mirrored:
        folded = np.abs(folded)
    alike = np.round(np.column_stack([folded, width]), 12)
    _, first, mirror = np.unique(alike, axis=0, return_index=True, return_inverse=True)
    columns = folded[first, None] + width[first, None] * np.array([-0.5, 0.5])
    return columns, mirror.ravel()


def _gauss(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights on 0 to 1."""
    nodes, weights = np.polynomial.legendre.leggauss(n)
    return (nodes + 1) / 2, weights / 2


def _means(sky: SolvedSky, grid: PatchGrid, columns: np.ndarray, patches: np.ndarray, n: int) -> np.ndarray:
    """Means of order 1 over listed patches by n x n points, some at a time, shape (n_wl, n_listed)."""
    share, weight = _gauss(n)
    at_once = max(_MOST_VALUES // (n * n * sky.medium.wavelength_nm.size), 1)
    zenith = zeniths_at(grid, share)
    azimuth = angles_at(columns, share)
    means = []
    for start in range(0, patches.size, at_once):
        ring, column = np.divmod(patches[start : start + at_once], len(columns))
        parts = sky.order_one.in_cells(zenith, azimuth, ring, column)
        cells = sky.with_phases(parts, zenith[ring][:, :, None], azimuth[column][:, None, :])
        means.append(np.einsum("wpij,i,j->wp", cells, weight, weight, optimize=True))
    return np.concatenate(means, axis=1)
