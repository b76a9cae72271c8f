"""The columns of a task with the paths of light through them: flat layers, or the shells of a medium."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from aomc_sky.atmosphere.medium.constituents import Medium
from aomc_sky.atmosphere.medium.optical_depth import vertical_optical_depth
from aomc_sky.atmosphere.scattering_orders.angular_resolution import elements_for
from aomc_sky.atmosphere.scattering_orders.formal_solution import Paths, ground_weights, node_paths, plane_crossings
from aomc_sky.atmosphere.scattering_orders.shell_paths import ShellPaths
from aomc_sky.atmosphere.scattering_orders.slab import Layers, altitude_grid, slab_of_layers, slabs_of_medium

SUN_STEP_RAD = 2e-3
"""How far the sun is moved to see how fast the light at a level changes with its zenith angle. [rad]"""


@dataclass(frozen=True, kw_only=True, slots=True)
class Seen:
    """What the directions looked into from the ground meet."""

    weights: np.ndarray  #: (n_zenith, n_level) radiance by the source at a node
    #: (n_zenith, n_level) by how much the vertical of the place where a direction crosses a node's altitude is turned
    #: from the observer's; the sun stands that much higher there if one looks towards it. None over flat layers. [rad]
    turn: np.ndarray | None


DirectedPaths = Callable[[int], tuple[Paths, Seen]]
"""A wavelength's row to the paths of the nodes' directions, and of the directions looked into."""


CURVED_RIPPLE, CURVED_MOMENTS = 2e-4, 128
"""What cut phase moments may cost, and the most of them, where curved shells cost 1e-3 in any case."""

_MORE_IN_SHELLS = 3  # halves: the slope of a path changes inside an element
_FLATTEST = 1e-4  # height over radius below which shells are as good as flat


class PlaneColumns:
    """A stack of flat layers.

    `n_element` are spread over them; None chooses by the optical depth.
    """

    ripple = 1e-6
    """What cut phase moments may cost; see `choose_resolution`."""
    most_moments = 200

    def __init__(self, layers: Layers, n_element: int | None, sun_zenith_rad: float) -> None:
        self.n_element = n_element or elements_for(float(np.sum(layers.optical_depth)))
        self.slabs = (slab_of_layers(layers, float(np.cos(sun_zenith_rad)), self.n_element),)
        self.turned_slabs = self.slabs

    def directed(self, mu: np.ndarray, view_mu: np.ndarray) -> DirectedPaths:
        """Straight paths through flat layers, for directions of the nodes and directions looked into."""

        def paths(row: int) -> tuple[Paths, Seen]:
            slab = self.slabs[row]
            lines, at_ground = plane_crossings(slab.edge_depth, slab.node_depth, mu)
            _, looked_into = plane_crossings(slab.edge_depth, slab.node_depth, view_mu)
            seen = Seen(weights=ground_weights(slab.share, looked_into), turn=None)
            return node_paths(slab.share, lines, at_ground), seen

        return paths


class ShellColumns:
    """The columns of a medium, one for each wavelength.

    `n_element` are spread over them; None chooses by the optical depth.
    """

    def __init__(self, medium: Medium, n_element: int | None, sun_zenith_rad: float) -> None:
        is_curved = medium.top_m > _FLATTEST * medium.earth_radius_m
        self.ripple = CURVED_RIPPLE if is_curved else PlaneColumns.ripple
        self.most_moments = CURVED_MOMENTS if is_curved else PlaneColumns.most_moments
        depth = float(vertical_optical_depth(medium).sum(axis=1).max())
        self.n_element = n_element or _MORE_IN_SHELLS * elements_for(depth) // 2
        self._grid = altitude_grid(medium, self.n_element)
        self.slabs = slabs_of_medium(medium, self._grid, sun_zenith_rad)
        self.turned_slabs = slabs_of_medium(medium, self._grid, min(sun_zenith_rad + SUN_STEP_RAD, np.pi))

    @property
    def altitude_m(self) -> np.ndarray:
        """Altitudes of the nodes of all elements, from the top down, shape (n_level,). [m]"""
        return self._grid.node_m.ravel()

    def extinction_per_m(self) -> np.ndarray:
        """Extinction coefficients at the nodes, shape (n_wl, n_level). [m-1]"""
        density = self._grid.node_density.reshape(self.altitude_m.size, -1)
        return np.asarray(self._grid.profile.extinction_m2 @ density.T)

    def directed(self, mu: np.ndarray, view_mu: np.ndarray) -> DirectedPaths:
        """Straight paths through spherical shells, for directions of the nodes and directions looked into."""
        shells = ShellPaths(self._grid, mu, view_mu)
        extinction = self._grid.profile.extinction_m2
        turn = _turn(self._grid.profile.earth_radius_m, self._grid.node_m.ravel(), view_mu)

        def paths(row: int) -> tuple[Paths, Seen]:
            of_nodes, weights = shells.weights(self.slabs[row], extinction[row])
            return of_nodes, Seen(weights=weights, turn=turn)

        return paths


def _turn(radius_m: float, altitude_m: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """Angle at the earth's centre between the observer and where rays from there reach altitudes, (n_mu, n_level)."""
    cosine = mu[:, None]
    gain = altitude_m * (2.0 * radius_m + altitude_m)
    distance = gain / (radius_m * cosine + np.sqrt((radius_m * cosine) ** 2 + gain))
    return np.arctan2(distance * np.sqrt(1.0 - cosine**2), radius_m + distance * cosine)
