"""A plane-parallel column as the solver of scattering orders sees it: elements in optical depth, nodes inside them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from aomc_sky.errors import SceneError

NODES_PER_ELEMENT = 4
UNIT_NODES = 0.5 * (1.0 + np.polynomial.legendre.leggauss(NODES_PER_ELEMENT)[0])
"""Gauss nodes of an element, as shares of its optical depth."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Slab:
    """Elements of a column from its top to the ground; what is scattered varies smoothly inside each.

    Nodes are inside the elements, never on an edge: jumps of the medium lie between elements.
    """

    edge_depth: np.ndarray  #: (n_element + 1,) optical depth of the edges, 0 at the top, strictly rising
    node_depth: np.ndarray  #: (n_element, n_node) optical depth of the nodes, strictly rising
    #: (n_kind, n_element, n_node) single-scattering albedo of each kind of particle: its share of the extinction. [0 to
    #: 1; sum <= 1]
    scattering: np.ndarray
    #: n_kind of them: cosines of scattering angles (n,) to the phase function (n,). [sr-1]
    phases: tuple[Callable[[np.ndarray], np.ndarray], ...]
    beam: np.ndarray  #: (n_element, n_node) what is left of the direct beam at the nodes. [0 to 1]
    beam_at_ground: float  #: The same at the ground. [0 to 1]

    @property
    def share(self) -> np.ndarray:
        """Where the nodes are in the optical depth of their elements, (n_element, n_node). [0 to 1]"""
        return (self.node_depth - self.edge_depth[:-1, None]) / np.diff(self.edge_depth)[:, None]


@dataclass(frozen=True, kw_only=True, slots=True)
class Layers:
    """A stack of homogeneous plane layers."""

    optical_depth: np.ndarray  #: (n_layer,) extinction of each layer from the top. [>= 0]
    #: (n_kind, n_layer) single-scattering albedo that each kind of particle adds. [0 to 1; sum over the kinds <= 1]
    scattering: np.ndarray
    #: n_kind of them: cosines of scattering angles (n,) to the phase function (n,), of integral 1 over the sphere.
    #: [sr-1]
    phases: tuple[Callable[[np.ndarray], np.ndarray], ...]

    def __post_init__(self) -> None:
        depth, share = np.asarray(self.optical_depth), np.asarray(self.scattering)
        if depth.ndim != 1 or depth.size == 0 or len(self.phases) == 0 or share.shape != (len(self.phases), depth.size):
            raise SceneError(
                "layers have one optical depth each, and an albedo for each kind of particle (one or more) and layer"
            )
        if not (np.all(np.isfinite(depth)) and np.all(depth >= 0.0) and depth.sum() > 0.0):
            raise SceneError("optical depths of layers are finite and not negative, and one of them is above zero")
        if not (np.all(share >= 0.0) and np.all(share.sum(axis=0) <= 1.0 + 1e-12)):
            raise SceneError("single-scattering albedos of a layer lie between 0 and 1, and so does their sum")


def clustered_depths(total: float, n_element: int) -> np.ndarray:
    """Edges from 0 to `total` that crowd at both ends, where radiances along shallow paths change fastest."""
    return 0.5 * total * (1.0 - np.cos(np.pi * np.arange(n_element + 1) / n_element))


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


def joined_edges(fixed: np.ndarray, wished: np.ndarray, least: float) -> np.ndarray:
    """Rising edges: all the fixed ones, and the wished ones that are not next to a fixed one.

    Both rise; fixed ones closer than `least` to the one before fall away.
    """
    kept = [fixed[0]]
    for edge in fixed[1:]:
        if edge - kept[-1] > least:
            kept.append(edge)
    kept[-1] = fixed[-1]
    rising = np.asarray(kept)
    spacing = np.gradient(wished) if wished.size > 1 else np.ones(1)
    gap = np.min(np.abs(wished[:, None] - rising), axis=1)
    return np.sort(np.concatenate([rising, wished[gap > 0.3 * spacing]]))
