"""Light scattered once under a sun below the horizon, solved anew in every zenith angle: no series holds the shadow.

Along a circle of one zenith angle the light is smooth but for some pieces. Many azimuths are read from a polynomial
through 17 of them. A piece whose first nine do not foretell the other eight is halved.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from aomc_sky.skies.atmosphere.medium import Medium
from aomc_sky.skies.atmosphere.order_one import OrderOneTables, order_one_tables, scattered_once

N_NODES = 17
"""Azimuths of a piece: the extrema of a Chebyshev polynomial, every second of which are those of one of half its
degree."""

TOLERANCE = 3e-5
"""Largest relative difference of what nine nodes foretell; the polynomial of all is at least some times as good."""

_FLOOR = 1e-3  # of the largest value of a piece: below it differences count as of it


@dataclass(frozen=True, kw_only=True)
class ExactOnce:
    """Light of order 1 as `SkyField` gives it, without a series in the zenith angle.

    `at` is exact; the others differ from it by 3e-6 of a value or 3e-9 of the largest one of its circle.
    """

    medium: Medium
    sun_zenith_rad: float

    @cached_property
    def tables(self) -> OrderOneTables:
        """Tables for all directions, made at the first call."""
        return order_one_tables(self.medium, self.sun_zenith_rad)

    def on_product(self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Values on all pairs of zenith angles (n_z,) and azimuths (n_a,), shape (n_wl, n_scatterer, n_z, n_a)."""
        radiance = self._on_circles(sky_zenith_rad, [azimuth_from_sun_rad] * sky_zenith_rad.size)
        return np.stack(radiance, axis=2)

    def at(self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
        """Values in single directions (n,), shape (n_wl, n_scatterer, n)."""
        return scattered_once(self.medium, self.sun_zenith_rad, sky_zenith_rad, azimuth_from_sun_rad, self.tables)

    def in_cells(
        self, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray, ring: np.ndarray, column: np.ndarray
    ) -> np.ndarray:
        """Values on the nodes of cells, as `SkyField.in_cells`, shape (n_wl, n_scatterer, n_cell, n, n)."""
        rings = np.unique(ring)
        azimuths = [azimuth_from_sun_rad[column[ring == one]] for one in rings]
        n = sky_zenith_rad.shape[1]
        rows = [some.ravel() for some in azimuths for _ in range(n)]
        radiance = self._on_circles(sky_zenith_rad[rings].ravel(), rows)
        cells = []
        for k, some in enumerate(azimuths):
            here = np.stack(radiance[k * n : (k + 1) * n], axis=-2)
            cells.append(here.reshape(*here.shape[:-1], *some.shape).swapaxes(-3, -2))
        return np.concatenate(cells, axis=2)

    def _on_circles(self, zenith: np.ndarray, azimuths: list[np.ndarray]) -> list[np.ndarray]:
        """Values (n_wl, n_scatterer, n) on circles of one zenith angle each, in azimuths of its own."""
        folded = [np.abs(np.mod(some + np.pi, 2.0 * np.pi) - np.pi) for some in azimuths]
        shape = self.at(zenith[:1], np.zeros(1)).shape[:2]
        radiance = [np.zeros((*shape, some.size)) for some in azimuths]
        pieces = [_Piece(circle=k, low=0.0, high=np.pi, asked=np.arange(some.size)) for k, some in enumerate(folded)]
        while pieces:
            pieces = self._settle(pieces, zenith, folded, radiance)
        return radiance

    def _settle(
        self, pieces: list[_Piece], zenith: np.ndarray, folded: list[np.ndarray], radiance: list[np.ndarray]
    ) -> list[_Piece]:
        """Fill what pieces hold; return the halves of those that no polynomial fits."""
        nodes = [piece.nodes(folded) for piece in pieces]
        theta = np.concatenate(
            [np.full(some.size, zenith[piece.circle]) for piece, some in zip(pieces, nodes, strict=True)]
        )
        ends = np.cumsum([some.size for some in nodes])
        values = np.split(self.at(theta, np.concatenate(nodes)), ends[:-1], axis=-1)
        left = []
        for piece, value in zip(pieces, values, strict=True):
            if piece.is_short:
                radiance[piece.circle][..., piece.asked] = value
            elif _is_foretold(value):
                radiance[piece.circle][..., piece.asked] = np.maximum(piece.read(value, folded), 0.0)
            else:
                left.extend(piece.halves(folded))
        return left


@dataclass(frozen=True, kw_only=True, slots=True)
class _Piece:
    """A range of azimuths on a circle, and which of the azimuths asked for lie in it."""

    circle: int
    low: float
    high: float
    asked: np.ndarray

    @property
    def is_short(self) -> bool:
        """Whether no more azimuths are asked for than a polynomial has nodes."""
        return self.asked.size <= N_NODES

    def nodes(self, folded: list[np.ndarray]) -> np.ndarray:
        """Azimuths to solve: the nodes of a polynomial, or those asked for. [rad]"""
        if self.is_short:
            return folded[self.circle][self.asked]
        x = np.cos(np.pi * np.arange(N_NODES) / (N_NODES - 1))
        return self.low + 0.5 * (self.high - self.low) * (1.0 + x)

    def read(self, value: np.ndarray, folded: list[np.ndarray]) -> np.ndarray:
        """Values where they are asked for, of those at the nodes."""
        x = (2.0 * folded[self.circle][self.asked] - self.low - self.high) / (self.high - self.low)
        return value @ _between(np.clip(x, -1.0, 1.0), N_NODES).T

    def halves(self, folded: list[np.ndarray]) -> list[_Piece]:
        """Its two halves, but for one in which nothing is asked for."""
        middle = 0.5 * (self.low + self.high)
        is_low = folded[self.circle][self.asked] < middle
        both = ((self.low, middle, self.asked[is_low]), (middle, self.high, self.asked[~is_low]))
        return [_Piece(circle=self.circle, low=a, high=b, asked=some) for a, b, some in both if some.size]


def _is_foretold(value: np.ndarray) -> bool:
    """Whether every second node gives the others, to `TOLERANCE`."""
    x = np.cos(np.pi * np.arange(1, N_NODES, 2) / (N_NODES - 1))
    given = value[..., 1::2]
    gap = np.abs(value[..., ::2] @ _between(x, (N_NODES + 1) // 2).T - given)
    scale = np.abs(given) + _FLOOR * np.abs(value).max(axis=-1, keepdims=True)
    return bool(np.all(gap <= TOLERANCE * scale))


def _between(x: np.ndarray, n: int) -> np.ndarray:
    """Matrix (n_x, n) from values at the extrema of T_(n-1) to those of their polynomial at x, within -1 and 1."""
    order, angle = np.arange(n), np.pi * np.arange(n) / (n - 1)
    ends = np.ones(n)
    ends[[0, -1]] = 0.5
    series = np.cos(np.outer(order, angle)) * ends * ends[:, None] * (2.0 / (n - 1))
    return np.cos(np.outer(np.arccos(x), order)) @ series
