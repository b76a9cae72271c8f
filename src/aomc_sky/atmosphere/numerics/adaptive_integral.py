"""Integrals of several functions at once, by panels that are halved where they need it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(15)
_MAX_HALVINGS = 40
_MAX_NODES = 2**20


@dataclass(frozen=True, kw_only=True, slots=True)
class Integral:
    """Integrals with what they may be off by."""

    value: np.ndarray  #: (n_function,) the integrals
    #: (n_function,) sum of the changes that the last halving of each panel made: far above the true error where the
    #: functions are smooth
    error: np.ndarray


def integrate(function: Callable[[np.ndarray], np.ndarray], edges: np.ndarray, *, tolerance: float) -> Integral:
    """Integrate functions of one sign over the range of some edges.

    Every panel has 15 Gauss-Legendre nodes. It is halved until that changes its share by at most `tolerance` of the
    whole, or until a million nodes are spent; the error says which.

    `function` takes places (n,) and gives (n_function, n). Jumps and bends belong among the rising `edges`.
    """
    low, high = edges[:-1], edges[1:]
    whole = _panels(function, low, high)
    done, error = np.zeros(whole.shape[0]), np.zeros(whole.shape[0])
    n_nodes = low.size * _NODES.size
    for _ in range(_MAX_HALVINGS):
        middle = low + 0.5 * (high - low)
        left, right = _panels(function, low, middle), _panels(function, middle, high)
        n_nodes += 2 * low.size * _NODES.size
        change = np.abs(left + right - whole)
        total = np.abs(done + (left + right).sum(axis=1))
        settled = (change <= tolerance * total[:, None]).all(axis=0)
        if n_nodes > _MAX_NODES:
            settled[:] = True
        done += (left + right)[:, settled].sum(axis=1)
        error += change[:, settled].sum(axis=1)
        if settled.all():
            break
        left, right = left[:, ~settled], right[:, ~settled]
        low, middle, high = low[~settled], middle[~settled], high[~settled]
        low, high, whole = np.r_[low, middle], np.r_[middle, high], np.hstack([left, right])
    else:
        done, error = done + whole.sum(axis=1), error + np.abs(whole).sum(axis=1)
    return Integral(value=done, error=error)


def _panels(function: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray) -> np.ndarray:
    half = 0.5 * (high - low)
    places = low[:, None] + half[:, None] * (1.0 + _NODES)
    values = function(places.ravel())
    return (values.reshape(values.shape[0], *places.shape) @ _WEIGHTS) * half
