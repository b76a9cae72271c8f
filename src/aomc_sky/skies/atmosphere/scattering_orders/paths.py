"""Straight paths of light through a column of shells, as weights on its source function.

A path crosses an element from share a to share b of its vertical optical depth, with x its own optical depth per share:

L(b) = L(a) exp(-x (b - a)) + int_a^b J(s) exp(-x (b - s)) x ds .

J is a polynomial through the element's nodes, and the integrals of its powers are

psi_d(z) = int_0^1 v^d exp(-z (1 - v)) z dv, psi_0 = 1 - exp(-z), psi_d = 1 - (d / z) psi_(d-1),

by the recurrence upward for z >= 1, and downward from a series for z < 1: exact to 1e-12 at any slope.

Through shells x = X / (b - a), with X the optical depth of the straight line in the element. The source function of a
node is that of its altitude alone. For the directions looked into from the ground, its brightness follows the sun's
local zenith angle to first order (`ShellPaths.turn`). Three
changes are neglected: of x inside an element, of a direction's own zenith angle along its path, and of the sun's zenith
angle where light goes on to be scattered again. A plane column would scatter too much light along the
horizon, 2 to 10 % in orders >= 2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.skies.atmosphere.kernels.rays import lowest_altitude, way_from_ground
from aomc_sky.skies.atmosphere.medium import Medium
from aomc_sky.skies.atmosphere.optical_depth import columns, vertical_optical_depth
from aomc_sky.skies.atmosphere.scattering_orders.slab import AltitudeGrid, Slab, altitude_grid, slabs_of_medium


@dataclass(frozen=True, kw_only=True, slots=True)
class Paths:
    """Weights of the source function on radiances; nodes are counted through all elements from the top."""

    #: down, up: (n_mu, n_level, n_level) radiance at a node (second axis) of light that travels down or up, by the
    #: source at a node (last axis)
    down: np.ndarray
    up: np.ndarray
    #: (n_mu, n_level, n_level) radiance at a node of light that went down beyond the lowest point of a path that misses
    #: the ground, then up; or None
    over: np.ndarray | None
    at_ground: np.ndarray  #: (n_mu, n_level) radiance that arrives at the ground
    from_ground: np.ndarray  #: (n_mu, n_level) what is left at a node of radiance that leaves the ground


def node_paths(
    share: np.ndarray,
    crossed: np.ndarray,
    below: np.ndarray,
    tangent: np.ndarray,
    lowest: np.ndarray,
    ground_crossed: np.ndarray,
) -> Paths:
    """Weights of the lines through the nodes of a column, at shares (n_element, n_node) of their elements from the top.

    crossed (n_level, n_mu, n_element): optical path through each element, on one side of the line's lowest point; below
    (n_level, n_mu): the part of it in the node's own element below the node. tangent (n_level, n_mu, n_element): share
    of each element above the line's lowest point; lowest (n_level, n_mu): its altitude, negative where the line meets
    the ground. ground_crossed (n_mu, n_element): optical paths of the lines that end at the ground.
    """
    from aomc_sky.skies.atmosphere.kernels.ray_integrals import fill_down, fill_up

    n_element, n_node = share.shape
    n_level, n_mu = below.shape
    element = np.repeat(np.arange(n_element), n_node)
    points, inverse = share.ravel(), _inverse(share)
    own = np.take_along_axis(crossed, element[:, None, None], axis=2)[:, :, 0] - below
    down, up, over = (np.empty((n_mu, n_level, n_level)) for _ in range(3))
    from_ground = np.empty((n_mu, n_level))
    fill_down(crossed, own, points, element, inverse, down)
    turned = _inverse(1.0 - share)
    fill_up(crossed, below, tangent, lowest, points, element, inverse, turned, up, over, from_ground)
    return Paths(
        down=down,
        up=up,
        over=over if np.any(lowest >= 0.0) else None,
        at_ground=ground_weights(share, ground_crossed),
        from_ground=from_ground,
    )


def ground_weights(share: np.ndarray, crossed: np.ndarray) -> np.ndarray:
    """Weights (n_mu, n_level) of the source function on the radiance at the ground; `crossed` is (n_mu, n_element)."""
    from aomc_sky.skies.atmosphere.kernels.ray_integrals import fill_down

    n_mu, n_element = crossed.shape
    out = np.empty((n_mu, 1, share.size))
    last = np.array([n_element - 1])
    fill_down(crossed[None], np.ascontiguousarray(crossed[None, :, -1]), np.ones(1), last, _inverse(share), out)
    return out[:, 0]


def _inverse(share: np.ndarray) -> np.ndarray:
    """Values at the nodes of elements to coefficients of powers of the share, (n_element, n_node, n_node)."""
    return np.linalg.inv(share[:, :, None] ** np.arange(share.shape[1]))


def lines_through(
    grid: AltitudeGrid, altitude_m: np.ndarray, element: np.ndarray, mu: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lines through points: altitudes and elements (n_level,), under cosines (n_mu,) of 0 to 1.

    Lowest altitude (n_level, n_mu) of each [m]; columns of the constituents in each element on one side of it (n_level,
    n_mu, n_element, n_constituent); the part of them below the point in its own element, (n_level, n_mu,
    n_constituent). [m-2]
    """
    radius = grid.profile.earth_radius_m
    lowest = lowest_altitude(radius, altitude_m[:, None], mu)
    low_edge, high_edge = grid.edge_m[1:], grid.edge_m[:-1]

    def along(low: np.ndarray, high: np.ndarray, tangent: np.ndarray) -> np.ndarray:
        start = np.minimum(np.maximum(low, tangent), high)
        fall = np.maximum(start - tangent, 0.0) * np.maximum(2.0 * radius + start + tangent, 0.0)
        cosine = np.minimum(np.sqrt(fall) / (radius + start), 1.0)
        return columns(grid.profile, start, cosine, high)

    below = along(low_edge[element][:, None], altitude_m[:, None], lowest)
    return lowest, along(low_edge, high_edge, lowest[:, :, None]), below


class ShellPaths:
    """The lines of a grid's nodes and of the directions looked into, for any wavelength."""

    def __init__(self, grid: AltitudeGrid, mu: np.ndarray, view_mu: np.ndarray) -> None:
        n_element, n_node = grid.node_m.shape
        self._grid, element = grid, np.repeat(np.arange(n_element), n_node)
        self._lowest_m, self._crossed, self._below = lines_through(grid, grid.node_m.ravel(), element, mu)
        ground, last = np.zeros(1), np.array([n_element - 1])
        self._from_ground, self._view = (lines_through(grid, ground, last, each)[1][0] for each in (mu, view_mu))
        #: (n_zenith, n_level) angle from the observer's vertical to that of the place where a direction looked into
        #: crosses a node's altitude. The sun is higher there by this angle if one looks towards it. [rad]
        radius, cosine = grid.profile.earth_radius_m, view_mu[:, None]
        distance, _ = way_from_ground(radius, cosine, grid.node_m.ravel())
        self.turn = np.arctan2(distance * np.sqrt(1.0 - cosine**2), radius + distance * cosine)

    def weights(self, slab: Slab, extinction_m2: np.ndarray) -> tuple[Paths, np.ndarray]:
        """Paths of the nodes' directions, and (n_zenith, n_level) for the directions looked into, at one wavelength."""
        crossed, below, ground, view = (
            each @ extinction_m2 for each in (self._crossed, self._below, self._from_ground, self._view)
        )
        altitude = np.concatenate([self._grid.edge_m, self._grid.node_m.ravel()])
        depth = np.concatenate([slab.edge_depth, slab.node_depth.ravel()])
        rising = np.argsort(altitude)
        lowest = np.interp(self._lowest_m, altitude[rising], depth[rising])
        # share of an element that a line crosses above its lowest point
        tangent = np.clip((lowest[:, :, None] - slab.edge_depth[:-1]) / np.diff(slab.edge_depth), 0.0, 1.0)
        paths = node_paths(slab.share, crossed, below, tangent, self._lowest_m, ground)
        return paths, ground_weights(slab.share, view)


SUN_STEP_RAD = 2e-3
"""How far the sun is moved to see how fast the light at a level changes with its zenith angle. [rad]"""


CURVED_RIPPLE, CURVED_MOMENTS = 2e-4, 128
"""What cut phase moments may cost, and the most of them, where curved shells cost 1e-3 in any case."""

FLAT_RIPPLE, FLAT_MOMENTS = 1e-6, 200
"""The same where shells are as good as flat; see `choose_resolution`."""

_MORE_IN_SHELLS = 3  # halves: the slope of a path changes inside an element
_LEAST_ELEMENTS, _MOST_ELEMENTS = 10, 30
_FLATTEST = 1e-4  # height over radius below which shells count as flat


class ShellColumns:
    """The columns of a medium, one for each wavelength, of `n_element` each, by default chosen by the optical depth."""

    def __init__(self, medium: Medium, n_element: int | None, sun_zenith_rad: float) -> None:
        is_curved = medium.top_m > _FLATTEST * medium.earth_radius_m
        self.ripple = CURVED_RIPPLE if is_curved else FLAT_RIPPLE
        self.most_moments = CURVED_MOMENTS if is_curved else FLAT_MOMENTS
        depth = float(vertical_optical_depth(medium).sum(axis=1).max())
        # 10 up to an optical depth of 1, then slowly more: 18 at 5, 23 at 10
        spread = int(np.clip(np.ceil(_LEAST_ELEMENTS * depth**0.36), _LEAST_ELEMENTS, _MOST_ELEMENTS))
        self.n_element = n_element or _MORE_IN_SHELLS * spread // 2
        self.grid = altitude_grid(medium, self.n_element)
        self.slabs = slabs_of_medium(medium, self.grid, sun_zenith_rad)
        self.turned_slabs = slabs_of_medium(medium, self.grid, min(sun_zenith_rad + SUN_STEP_RAD, np.pi))
