"""Straight paths through spherical shells as weights on the source function of a column.

A path that meets the horizontal plane of a node under a small angle leaves a plane column far away, but a spherical
one after some hundred kilometres: a plane column scatters too much light along the horizon, 2 to 10 % in orders >= 2.
Here the optical depth of every element along every path is that of its straight line through the shells, with the
tangent point of lines that sink and miss the ground, while the source function of a node is that of its altitude
alone: the same at each place along the path, in the direction that the path has at its end. For the directions that
are looked into from the ground, the brightness of the source follows the sun's local zenith angle to first order
(`columns.Seen`).

Law, for a line of slant depth X through an element that it crosses from share a to share b of the element's vertical
depth: int exp(-x (b - s)) J(s) x ds, x = X / (b - a), with J the polynomial of `formal_solution`; the light of all
elements before is weakened by exp(-X). What is neglected: that x changes inside an element, that a direction's own
zenith angle changes along its path, and the sun's where light goes on to be scattered again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.atmosphere.medium.optical_depth import columns, lowest_altitude
from aomc_sky.atmosphere.scattering_orders.formal_solution import Crossings, Paths, ground_weights, node_paths
from aomc_sky.atmosphere.scattering_orders.slab import AltitudeGrid, Slab

SHELL_ERROR = 5e-3
"""Largest share of the sky's radiance that the neglected changes along a path cost, for a sun above 10 degrees."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Lines:
    """Straight lines through a point of given altitude and direction: what each crosses of every constituent."""

    #: (n_level, n_mu) altitude of the point nearest to the earth's centre; negative where the line meets the ground.
    #: [m]
    lowest_m: np.ndarray
    #: (n_level, n_mu, n_element, n_constituent) columns of each element on one side of the lowest point. [m-2]
    crossed: np.ndarray
    #: (n_level, n_mu, n_constituent) the part of its own element between a point and the element's lower edge, or the
    #: lowest point. [m-2]
    below: np.ndarray


def lines_through(grid: AltitudeGrid, altitude_m: np.ndarray, element: np.ndarray, mu: np.ndarray) -> Lines:
    """Columns of lines through points.

    Points at altitudes (n_level,), in the elements (n_level,), under cosines (n_mu,) of 0 to 1.
    """
    radius = grid.profile.earth_radius_m
    lowest = lowest_altitude(radius, altitude_m[:, None], mu)
    low_edge, high_edge = grid.edge_m[1:], grid.edge_m[:-1]

    def along(low: np.ndarray, high: np.ndarray, tangent: np.ndarray) -> np.ndarray:
        start = np.minimum(np.maximum(low, tangent), high)
        fall = np.maximum(start - tangent, 0.0) * np.maximum(2.0 * radius + start + tangent, 0.0)
        cosine = np.minimum(np.sqrt(fall) / (radius + start), 1.0)
        return columns(grid.profile, start, cosine, high)

    return Lines(
        lowest_m=lowest,
        crossed=along(low_edge, high_edge, lowest[:, :, None]),
        below=along(low_edge[element][:, None], altitude_m[:, None], lowest),
    )


class ShellPaths:
    """The lines of a grid's nodes and of the directions looked into, for any wavelength."""

    def __init__(self, grid: AltitudeGrid, mu: np.ndarray, view_mu: np.ndarray) -> None:
        n_element, n_node = grid.node_m.shape
        self._grid = grid
        self._element = np.repeat(np.arange(n_element), n_node)
        self._lines = lines_through(grid, grid.node_m.ravel(), self._element, mu)
        ground, last = np.zeros(1), np.array([n_element - 1])
        self._from_ground = lines_through(grid, ground, last, mu)
        self._view = lines_through(grid, ground, last, view_mu)

    def weights(self, slab: Slab, extinction_m2: np.ndarray) -> tuple[Paths, np.ndarray]:
        """Paths of the nodes' directions, and (n_zenith, n_level) for the directions looked into.

        Cross sections are (n_constituent,). [m2]
        """
        share = slab.share
        lines = Crossings(
            crossed=self._lines.crossed @ extinction_m2,
            below=self._lines.below @ extinction_m2,
            tangent=self._tangent_share(slab),
            lowest=self._lines.lowest_m,
        )
        return (
            node_paths(share, lines, self._from_ground.crossed[0] @ extinction_m2),
            ground_weights(share, self._view.crossed[0] @ extinction_m2),
        )

    def _tangent_share(self, slab: Slab) -> np.ndarray:
        """Share of an element that a line crosses above its lowest point, (n_level, n_mu, n_element)."""
        altitude = np.concatenate([self._grid.edge_m, self._grid.node_m.ravel()])
        depth = np.concatenate([slab.edge_depth, slab.node_depth.ravel()])
        rising = np.argsort(altitude)
        lowest = np.interp(self._lines.lowest_m, altitude[rising], depth[rising])
        return np.clip((lowest[:, :, None] - slab.edge_depth[:-1]) / np.diff(slab.edge_depth), 0.0, 1.0)
