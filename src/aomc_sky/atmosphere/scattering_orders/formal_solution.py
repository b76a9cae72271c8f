"""The radiance along straight paths through a column as weights on its source function.

Law, for a path that crosses an element from share a to share b of its vertical optical depth, x its own optical depth
per share:

    L(b) = L(a) exp(-x (b - a)) + int_a^b J(s) exp(-x (b - s)) x ds .

J is a polynomial through the element's nodes. The integrals of its powers follow from

    psi_d(z) = int_0^1 v^d exp(-z (1 - v)) z dv,    psi_0 = 1 - exp(-z),    psi_d = 1 - (d / z) psi_(d-1),

by the recurrence upward for z >= 1, and for z < 1 downward from a series, each stable on its side. The weights are
exact for such a J, at any slope, to 1e-12. In flat layers x = D / mu with D the element's vertical depth; through
shells `shell_paths` finds x.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_LEAST_MU = 1e-12  # a path along the horizon sees the source function at its end


@dataclass(frozen=True, kw_only=True, slots=True)
class Paths:
    """Weights of the source function on radiances; nodes are counted through all elements from the top."""

    #: down, up: (n_mu, n_level, n_level) radiance at a node (second axis) of light that travels down or up, by the
    #: source at a node (last axis)
    down: np.ndarray
    up: np.ndarray
    #: (n_mu, n_level, n_level) radiance at a node of light that went down beyond the lowest point of a path that misses
    #: the ground, then up; None in flat layers
    over: np.ndarray | None
    at_ground: np.ndarray  #: (n_mu, n_level) radiance that arrives at the ground
    from_ground: np.ndarray  #: (n_mu, n_level) what is left at a node of radiance that leaves the ground


@dataclass(frozen=True, kw_only=True, slots=True)
class Crossings:
    """What the lines through the nodes of a column meet at one wavelength."""

    #: (n_level, n_mu, n_element) optical path through each element, on one side of the line's lowest point
    crossed: np.ndarray
    below: np.ndarray  #: (n_level, n_mu) the part of it in the node's own element below the node
    #: (n_level, n_mu, n_element) share of each element that lies above the line's lowest point. [0 to 1]
    tangent: np.ndarray
    lowest: np.ndarray  #: (n_level, n_mu) altitude of the lowest point; negative where the line meets the ground


def node_paths(share: np.ndarray, lines: Crossings, ground_crossed: np.ndarray) -> Paths:
    """Weights of the lines through the nodes of a column.

    `share` (n_element, n_node) is where the nodes are in their elements, from the top; `ground_crossed` (n_mu,
    n_element) are the optical paths of the lines that end at the ground.
    """
    from aomc_sky.kernels.atmosphere.element_weights import fill_down, fill_up

    n_element, n_node = share.shape
    n_level, n_mu = lines.below.shape
    element = np.repeat(np.arange(n_element), n_node)
    points, inverse = share.ravel(), _inverse(share)
    own = np.take_along_axis(lines.crossed, element[:, None, None], axis=2)[:, :, 0] - lines.below
    down, up, over = (np.empty((n_mu, n_level, n_level)) for _ in range(3))
    from_ground = np.empty((n_mu, n_level))
    fill_down(lines.crossed, own, points, element, inverse, down)
    fill_up(
        lines.crossed,
        lines.below,
        lines.tangent,
        lines.lowest,
        points,
        element,
        inverse,
        _inverse(1.0 - share),
        up,
        over,
        from_ground,
    )
    return Paths(
        down=down,
        up=up,
        over=over if np.any(lines.lowest >= 0.0) else None,
        at_ground=ground_weights(share, ground_crossed),
        from_ground=from_ground,
    )


def ground_weights(share: np.ndarray, crossed: np.ndarray) -> np.ndarray:
    """Weights of the source function on the radiance that arrives at the ground.

    Shape (n_mu, n_level) of shares (n_element, n_node) and optical paths through each element (n_mu, n_element).
    """
    from aomc_sky.kernels.atmosphere.element_weights import fill_down

    n_mu, n_element = crossed.shape
    out = np.empty((n_mu, 1, share.size))
    last = np.array([n_element - 1])
    fill_down(crossed[None], np.ascontiguousarray(crossed[None, :, -1]), np.ones(1), last, _inverse(share), out)
    return out[:, 0]


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


def _inverse(share: np.ndarray) -> np.ndarray:
    """Values at the nodes of elements to coefficients of powers of the share, (n_element, n_node, n_node)."""
    return np.linalg.inv(share[:, :, None] ** np.arange(share.shape[1]))
