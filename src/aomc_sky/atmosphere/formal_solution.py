"""The radiance along a straight path of a plane column as weights on its source function.

Law, for a path of cosine mu through an element of optical thickness D, with y the share of D already crossed and
x = D / mu:

    L(y) = L(0) exp(-x y) + int_0^y J(s) exp(-x (y - s)) x ds .

J is a polynomial through the element's nodes. The integrals of its powers follow from

    psi_d(z) = int_0^1 v^d exp(-z (1 - v)) z dv,    psi_0 = 1 - exp(-z),    psi_d = 1 - (d / z) psi_(d-1),

by the recurrence upward for z >= 1, and for z < 1 downward from a series, each stable on its side. The weights are
exact for such a J, at any slope, to 1e-13.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_SERIES_TERMS = 14
_LEAST_MU = 1e-12  # a path along the horizon sees the source function at its end


@dataclass(frozen=True, kw_only=True, slots=True)
class Paths:
    """Weights of the source function on radiances; nodes are counted through all elements from the top.

    Parameters
    ----------
    down, up : ndarray, float64, shape (n_mu, n_level, n_level)
        Radiance at a node (second axis) of light that travels down or up, by the source at a node (last axis).
    over : ndarray, float64, shape (n_mu, n_level, n_level), or None
        Radiance at a node of light that went down beyond the lowest point of a path that misses the ground, then up.
    at_ground : ndarray, float64, shape (n_mu, n_level)
        Radiance that arrives at the ground.
    from_ground : ndarray, float64, shape (n_mu, n_level)
        What is left at a node of radiance that leaves the ground.
    """

    down: np.ndarray
    up: np.ndarray
    over: np.ndarray | None
    at_ground: np.ndarray
    from_ground: np.ndarray


def powers_integral(z: np.ndarray, n_power: int) -> np.ndarray:
    """psi_d(z) for d = 0 to n_power - 1.

    Parameters
    ----------
    z : ndarray, float64
        Optical path. [>= 0]
    n_power : int
        Powers. [>= 1]

    Returns
    -------
    ndarray, float64, shape (..., n_power)
        Relative error below 1e-13 for n_power <= 6.
    """
    out = np.empty((*z.shape, n_power))
    top = n_power - 1
    thick = np.maximum(z, 1.0)
    thin = np.minimum(z, 1.0)
    upward = -np.expm1(-thick)
    series = np.zeros_like(thin)
    for j in range(_SERIES_TERMS, -1, -1):
        series = thin / (top + j + 1) * (1.0 - series)
    out[..., top] = series
    for d in range(top, 0, -1):
        out[..., d - 1] = (1.0 - out[..., d]) * thin / d
    is_thick = z >= 1.0
    for d in range(n_power):
        upward = upward if d == 0 else 1.0 - d / thick * upward
        out[..., d] = np.where(is_thick, upward, out[..., d])
    return out


def partial_weights(rate: np.ndarray, end: np.ndarray, inverse: np.ndarray) -> np.ndarray:
    """Weights of the nodes of elements on int_0^b exp(-x (b - s)) J(s) x ds.

    Parameters
    ----------
    rate : ndarray, float64, shape (..., n)
        x, optical path per share of the element. [>= 0]
    end : ndarray, float64, shape (..., n)
        b. [0 to 1]
    inverse : ndarray, float64, shape (n or broadcast, n_node, n_node)
        Values at the nodes to coefficients of powers.

    Returns
    -------
    ndarray, float64, shape (..., n, n_node)
    """
    n_node = inverse.shape[-1]
    integrals = powers_integral(rate * end, n_node) * end[..., None] ** np.arange(n_node)
    return np.einsum("...d,...dj->...j", integrals, inverse)


def _element_weights(thickness: np.ndarray, nodes: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """Weights (n_mu, n_element, n_node + 1, n_node) at each node and at the far edge; `nodes` are shares of 0 to 1."""
    n_node = nodes.shape[1]
    ends = np.concatenate([nodes, np.ones((nodes.shape[0], 1))], axis=1)
    path = thickness[:, None] * ends / mu[:, None, None]
    powers = np.arange(n_node)
    integrals = powers_integral(path, n_node) * ends[:, :, None] ** powers
    inverse = np.linalg.inv(nodes[:, :, None] ** powers)  # values at nodes -> coefficients of powers
    return integrals @ inverse


def _down_weights(edges: np.ndarray, nodes: np.ndarray, mu: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    thickness = np.diff(edges)
    inside = _element_weights(thickness, (nodes - edges[:-1, None]) / thickness[:, None], mu)
    full = inside[:, :, -1]
    n_element, n_node = nodes.shape
    gap = nodes[:, :, None] - edges[1:]
    left = np.where(gap >= 0.0, np.exp(-np.maximum(gap, 0.0) / mu[:, None, None, None]), 0.0)
    weights = left[..., None] * full[:, None, None]
    own = np.arange(n_element)
    weights[:, own, :, own] = inside[:, own, :-1].swapaxes(0, 1)
    at_end = np.exp(-(edges[-1] - edges[1:]) / mu[:, None])[:, :, None] * full
    n_level = n_element * n_node
    return weights.reshape(mu.size, n_level, n_level), at_end.reshape(mu.size, n_level)


def plane_paths(edges: np.ndarray, nodes: np.ndarray, mu: np.ndarray) -> Paths:
    """Weights of straight paths through a plane column.

    Parameters
    ----------
    edges : ndarray, float64, shape (n_element + 1,)
        Optical depths of the elements' edges, strictly rising.
    nodes : ndarray, float64, shape (n_element, n_node)
        Optical depths of the nodes.
    mu : ndarray, float64, shape (n_mu,)
        Cosines of the paths' zenith angles. [0 to 1]

    Returns
    -------
    Paths
    """
    mu = np.maximum(mu, _LEAST_MU)
    down, at_ground = _down_weights(edges, nodes, mu)
    turned, _ = _down_weights(edges[-1] - edges[::-1], edges[-1] - nodes[::-1, ::-1], mu)
    return Paths(
        down=down,
        up=np.ascontiguousarray(turned[:, ::-1, ::-1]),
        over=None,
        at_ground=at_ground,
        from_ground=np.exp(-(edges[-1] - nodes.ravel()) / mu[:, None]),
    )


def ground_weights(edges: np.ndarray, nodes: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """`Paths.at_ground` alone, for directions that are only looked into.

    Parameters
    ----------
    edges, nodes, mu : ndarray, float64
        As for `plane_paths`.

    Returns
    -------
    ndarray, float64, shape (n_mu, n_level)
    """
    mu = np.maximum(mu, _LEAST_MU)
    thickness = np.diff(edges)
    inside = _element_weights(thickness, (nodes - edges[:-1, None]) / thickness[:, None], mu)
    left = np.exp(-(edges[-1] - edges[1:]) / mu[:, None])
    return (left[:, :, None] * inside[:, :, -1]).reshape(mu.size, -1)
