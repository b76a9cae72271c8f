"""Smooth functions of the sky direction, kept as Chebyshev and cosine series."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

HALF_PI = np.pi / 2


@dataclass(frozen=True, kw_only=True, slots=True)
class SkyField:
    """Functions of zenith angle and azimuth from the sun, as a rule mirrored on the sun's vertical plane.

    A ray's path through shells lit by parallel light is smooth in both angles; only phase functions may be sharp, and
    they stay outside.
    """

    #: (..., n_zenith, n_azimuth) of T_k(2 u - 1) cos(m phi), where u = sqrt(1 - theta / (pi/2)): the square root crowds
    #: the nodes at the horizon, where air masses change over a degree, and is smooth overhead, where cos(theta) would
    #: not be
    coefficient: np.ndarray
    #: False: n_azimuth is odd, and after the cosines of m = 0 ... n // 2 stand the sines of m = 1 ... n // 2.
    is_mirrored: bool = True

    def on_product(self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Values on all pairs of zenith angles (n_z,) and azimuths (n_a,), shape (..., n_z, n_a)."""
        rows = _zenith_basis(sky_zenith_rad, self.coefficient.shape[-2])
        columns = azimuth_basis(azimuth_from_sun_rad, self.coefficient.shape[-1], is_mirrored=self.is_mirrored)
        return rows @ (self.coefficient @ columns.T)

    def at(self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Values in single directions (n,), shape (..., n)."""
        rows = _zenith_basis(sky_zenith_rad, self.coefficient.shape[-2])
        columns = azimuth_basis(azimuth_from_sun_rad, self.coefficient.shape[-1], is_mirrored=self.is_mirrored)
        return np.einsum("nk,...kn->...n", rows, self.coefficient @ columns.T)

    def in_cells(
        self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray, ring: np.ndarray, column: np.ndarray
    ) -> np.ndarray:
        """Values on the nodes of some cells of a product of rings and columns.

        Shape (..., n_cell, n, n) of nodes of each ring (n_ring, n) and column (n_column, n), and of the cells' indices;
        rings do not fall.
        """
        pieces = []
        for one in np.unique(ring):
            here = azimuth_from_sun_rad[column[ring == one]]
            field = self.on_product(sky_zenith_rad[one], here.ravel())
            pieces.append(field.reshape(*field.shape[:-1], *here.shape).swapaxes(-3, -2))
        return np.concatenate(pieces, axis=-3)

    def means(self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray, weight: np.ndarray) -> np.ndarray:
        """Weighted means over patches, each the product of a ring and a column.

        Shape (..., n_ring, n_column) of nodes (n_ring, n) and (n_column, n), and a node's weight (n,) in both
        directions. The series is averaged term by term, so that many nodes cost little.
        """
        rows = _zenith_basis(sky_zenith_rad.ravel(), self.coefficient.shape[-2])
        columns = azimuth_basis(azimuth_from_sun_rad.ravel(), self.coefficient.shape[-1], is_mirrored=self.is_mirrored)
        row_means = np.einsum("znk,n->zk", rows.reshape(*sky_zenith_rad.shape, -1), weight)
        column_means = np.einsum("anm,n->am", columns.reshape(*azimuth_from_sun_rad.shape, -1), weight)
        return row_means @ (self.coefficient @ column_means.T)


def fit_field(
    values: Callable[[np.ndarray, np.ndarray], np.ndarray], *, n_zenith: int, n_azimuth: int, is_mirrored: bool = True
) -> SkyField:
    """Fit a field through the values at its nodes.

    `values` takes zenith angles (n,) and azimuths (n,) and gives (..., n). Exact at its nodes, which are neither
    overhead nor on the horizon. Where it is not mirrored, `n_azimuth` is odd and over the whole turn.
    """
    phi = azimuth_nodes(n_azimuth, is_mirrored=is_mirrored)
    zenith, azimuth = np.meshgrid(zenith_nodes(n_zenith), phi, indexing="ij")
    found = values(zenith.ravel(), azimuth.ravel())
    on_nodes = found.reshape(*found.shape[:-1], n_zenith, n_azimuth)
    series = _to_series(n_zenith) @ on_nodes @ to_azimuth_series(n_azimuth, is_mirrored=is_mirrored).T
    return SkyField(coefficient=series, is_mirrored=is_mirrored)


def zenith_nodes(n: int) -> np.ndarray:
    """Zenith angles of the nodes of a field, from near the zenith to near the horizon, shape (n,). [rad]"""
    u = (_chebyshev_nodes(n) + 1) / 2
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
    """A field from its series in the azimuth at `zenith_nodes`.

    `modes` (..., n_azimuth, n_zenith) are factors of cos(m phi), or as `SkyField` has them where it is not mirrored.
    """
    return SkyField(coefficient=_to_series(modes.shape[-1]) @ modes.swapaxes(-1, -2), is_mirrored=is_mirrored)


def _chebyshev_nodes(n: int) -> np.ndarray:
    return np.cos((np.arange(n) + 0.5) * np.pi / n)


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
