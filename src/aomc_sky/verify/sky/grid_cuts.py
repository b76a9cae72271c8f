"""Rings and columns of patches, cut where zones begin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.directions import sin_cos_deg
from aomc_sky.verify.sky.fixed_directions import WHOLE_TURN

_SLIVER = 1e-9
"""Smallest part of a ring or column that is kept: less comes from rounding of edges."""


@dataclass(frozen=True, kw_only=True, slots=True)
class GridCuts:
    """Parts of rings or columns."""

    #: parent, zone: The ring or column that each is part of, and the zone ring or column that it lies in. [shape (n,)]
    parent: np.ndarray
    zone: np.ndarray
    #: Its ends. [deg, shape (n, 2)]
    bounds_deg: np.ndarray

    def shares(self, measure: np.ndarray) -> np.ndarray:
        """Part of the parent that each piece is, from the measure of pieces; without extent, all of it."""
        total = np.bincount(self.parent, measure)[self.parent]
        return np.divide(measure, total, out=np.ones_like(total), where=total > 0)

    @property
    def is_cut(self) -> bool:
        """Whether any parent has several pieces."""
        return self.parent.size > np.unique(self.parent).size


def cut(bounds_deg: np.ndarray, zone_bounds_deg: np.ndarray, *, is_azimuth: bool) -> GridCuts:
    """Cut intervals, rings or columns, at the edges of zones; points are allowed.

    Zones leave no gaps between them, those of azimuth make one turn.
    """
    edges = np.append(zone_bounds_deg[:, 0], zone_bounds_deg[-1, 1])
    low, high = bounds_deg.T
    n_zones = len(zone_bounds_deg)
    if is_azimuth:
        low = edges[0] + np.mod(low - edges[0], WHOLE_TURN)
        high = low + (bounds_deg[:, 1] - bounds_deg[:, 0])
        edges = np.append(edges, edges[1:] + WHOLE_TURN)
    first = np.clip(np.searchsorted(edges, low, side="right") - 1, 0, edges.size - 2)
    last = np.clip(np.searchsorted(edges, high, side="left") - 1, first, edges.size - 2)
    number = last - first + 1
    parent = np.repeat(np.arange(low.size), number)
    zone = first[parent] + np.arange(parent.size) - np.repeat(np.cumsum(number) - number, number)
    start, end = np.maximum(low[parent], edges[zone]), np.minimum(high[parent], edges[zone + 1])
    kept = (end - start > _SLIVER * (high - low)[parent]) | (number[parent] == 1)
    bounds = np.column_stack([start, np.maximum(end, start)])[kept]
    return GridCuts(parent=parent[kept], zone=zone[kept] % n_zones, bounds_deg=bounds)


def growth_of_sin2(bounds_deg: np.ndarray) -> np.ndarray:
    """Growth of sin^2 of the zenith angle over rings: the flux of a constant radiance."""
    near, far = bounds_deg.T
    return sin_cos_deg(far - near)[0] * sin_cos_deg(far + near)[0]


def drop_of_mu(bounds_deg: np.ndarray) -> np.ndarray:
    """Drop of the cosine of the zenith angle over rings: their solid angle."""
    near, far = bounds_deg.T
    return 2.0 * sin_cos_deg((far + near) / 2)[0] * sin_cos_deg((far - near) / 2)[0]
