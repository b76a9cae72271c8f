"""Directions of the orders of scattering: Gauss nodes of a hemisphere and the Legendre functions there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial.legendre import leggauss

from aomc_sky.atmosphere.numerics.legendre import legendre_table

_LOW_PANEL = 0.05
_LOW_NODES = 6


@dataclass(frozen=True, kw_only=True, slots=True)
class Angles:
    """Gauss nodes of one hemisphere and the Legendre functions there, split by their parity in mu."""

    #: mu, weight: (n_mu,) nodes and weights of int_0^1 dmu
    mu: np.ndarray
    weight: np.ndarray
    #: even, odd: (n_modes, n_half, n_mu) V_lm for l - m even and odd
    even: np.ndarray
    odd: np.ndarray
    n_moments: int  #: Degrees l < n_moments, 2 n_mu at most


def split_table(mu: np.ndarray, n_modes: int, n_moments: int) -> tuple[np.ndarray, np.ndarray]:
    """Legendre functions with l - m even and odd, each (n_modes, n_half, n).

    An odd number of degrees gets a last row of zeros.
    """
    table = legendre_table(mu, n_modes, n_moments)
    if n_moments % 2:
        table = np.concatenate([table, np.zeros((n_modes, 1, mu.size))], axis=1)
    return np.ascontiguousarray(table[:, 0::2]), np.ascontiguousarray(table[:, 1::2])


@lru_cache(maxsize=8)
def gauss_angles(n_mu: int, n_moments: int) -> Angles:
    """Gauss nodes on (0, 1) in two panels, with their Legendre functions, as many modes as degrees.

    Radiance over a thin column bends within a few degrees of the horizon; the panel below mu = 0.05 is for that.

    Energy is kept to rounding up to about 2 (n_mu - 6) degrees.
    """
    n_low = min(_LOW_NODES, n_mu // 2)
    panels = ((0.0, _LOW_PANEL, n_low), (_LOW_PANEL, 1.0, n_mu - n_low))
    nodes = [(a + (b - a) * 0.5 * (1.0 + x), (b - a) * 0.5 * w) for a, b, n in panels for x, w in (leggauss(n),)]
    mu, weight = np.concatenate([x for x, _ in nodes]), np.concatenate([w for _, w in nodes])
    even, odd = split_table(mu, n_moments, n_moments)
    for each in (mu, weight, even, odd):  # the cache hands them out again
        each.flags.writeable = False
    return Angles(mu=mu, weight=weight, even=even, odd=odd, n_moments=n_moments)
