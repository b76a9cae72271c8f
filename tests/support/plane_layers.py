"""Stacks of plane layers for the solver of scattering orders: published tables are of such."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from aomc_sky.skies.atmosphere.scattering_orders.diffuse import ALL_ORDERS, DiffuseSky, OrderTask, Resolution, solved
from aomc_sky.skies.atmosphere.scattering_orders.paths import (
    FLAT_MOMENTS,
    FLAT_RIPPLE,
    Crossings,
    DirectedPaths,
    Paths,
    Seen,
    elements_for,
    ground_weights,
    node_paths,
)
from aomc_sky.skies.atmosphere.scattering_orders.slab import UNIT_NODES, Slab, clustered_depths, joined_edges

_LEAST_MU = 1e-12  # a path along the horizon sees the source function at its end


@dataclass(frozen=True, kw_only=True, slots=True)
class Layers:
    """A stack of homogeneous plane layers."""

    optical_depth: np.ndarray  #: (n_layer,) extinction of each layer from the top. [>= 0]
    #: (n_kind, n_layer) single-scattering albedo that each kind of particle adds. [0 to 1; sum over the kinds <= 1]
    scattering: np.ndarray
    #: n_kind of them: cosines of scattering angles (n,) to the phase function (n,), of integral 1 over the sphere.
    #: [sr-1]
    phases: tuple[Callable[[np.ndarray], np.ndarray], ...]


def slab_of_layers(layers: Layers, mu0: float, n_element: int) -> Slab:
    """Elements of a stack of layers, lit by a plane-parallel beam exp(-depth / mu0).

    Every interface adds one edge to the `n_element` that are spread.
    """
    depth = np.asarray(layers.optical_depth, dtype=float)
    interfaces = np.concatenate([[0.0], np.cumsum(depth)])
    total = interfaces[-1]
    edges = joined_edges(interfaces, clustered_depths(total, n_element), 1e-9 * total)
    nodes = edges[:-1, None] + np.diff(edges)[:, None] * UNIT_NODES
    layer = np.clip(np.searchsorted(interfaces, nodes, side="right") - 1, 0, depth.size - 1)
    return Slab(
        edge_depth=edges,
        node_depth=nodes,
        scattering=np.asarray(layers.scattering, dtype=float)[:, layer],
        phases=layers.phases,
        beam=np.exp(-nodes / mu0),
        beam_at_ground=float(np.exp(-total / mu0)),
    )


def plane_crossings(edges: np.ndarray, nodes: np.ndarray, mu: np.ndarray) -> tuple[Crossings, np.ndarray]:
    """Lines through the nodes of a flat column, and those that end at the ground.

    Optical depths of edges (n_element + 1,) and nodes (n_element, n_node) rise; the second result is (n_mu, n_element).
    """
    mu = np.maximum(mu, _LEAST_MU)
    at_ground = np.diff(edges) / mu[:, None]
    shape = (nodes.size, mu.size)
    return (
        Crossings(
            crossed=np.ascontiguousarray(np.broadcast_to(at_ground, (nodes.size, *at_ground.shape))),
            below=((edges[1:, None] - nodes).ravel()[:, None] / mu),
            tangent=np.ones((*shape, edges.size - 1)),
            lowest=np.full(shape, -1.0),
        ),
        at_ground,
    )


class PlaneColumns:
    """A stack of flat layers.

    `n_element` are spread over them; None chooses by the optical depth.
    """

    ripple, most_moments = FLAT_RIPPLE, FLAT_MOMENTS

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
            seen = Seen(
                weights=ground_weights(slab.share, looked_into), turn=np.zeros((view_mu.size, slab.node_depth.size))
            )
            return node_paths(slab.share, lines, at_ground), seen

        return paths


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

    Arguments as of `solve_orders`; the sun stands above the horizon, and n_wl is 1.
    """
    task = OrderTask(
        columns_at=lambda n_element: PlaneColumns(layers, n_element, sun_zenith_rad),  # type: ignore[arg-type,return-value]
        albedo=np.array([albedo]),
        irradiance=np.ones(1),
        n_orders=n_orders,
        sun_zenith_rad=sun_zenith_rad,
        sky_zenith_rad=np.minimum(sky_zenith_rad, 0.5 * np.pi),
        n_listed=min(n_listed, n_orders),
    )
    return solved(task, resolution)


def later_orders(sky: DiffuseSky, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
    """Radiance of all orders from 2 on, shape (n_wl, n_zenith, n_azimuth)."""
    return by_order(sky, azimuth_from_sun_rad)[:, 1:].sum(axis=1)


def by_order(sky: DiffuseSky, azimuth_from_sun_rad: np.ndarray) -> np.ndarray:
    """Radiance of orders 1 (plane-parallel), 2, ..., and of all later ones together, (n_wl, n_row + 1, ...)."""
    cosines = np.cos(np.arange(sky.later_modes.shape[2])[:, None] * np.asarray(azimuth_from_sun_rad))
    later = sky.later_modes.swapaxes(2, 3) @ cosines
    return np.concatenate([sky.plane_order_one(azimuth_from_sun_rad)[:, None], later], axis=1)
