"""How many angles, depths and Legendre moments the orders of scattering need."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from aomc_sky.atmosphere.scattering_orders.slab import Slab

SERIES_LENGTH = 256
"""Legendre moments that are looked at when a resolution is chosen."""

MOST_MU_NODES = 64
"""Nodes that a wish for many directions may bring."""

_LEAST_MU_NODES = 20
_MOST_RIPPLE = 1e-2
_LEAST_ELEMENTS = 10
_MOST_ELEMENTS = 30


@dataclass(frozen=True, kw_only=True, slots=True)
class Resolution:
    """How finely angles and depths are cut."""

    n_mu: int  #: Gauss nodes of one hemisphere. [>= 4]
    n_element: int  #: Elements spread over the column. [>= 2]
    #: Degrees l < n_moments of the phase functions, as many modes of the azimuth. [<= 2 (n_mu - 6): energy is kept]
    n_moments: int
    peak_error: float = 0.0  #: Estimated share of the mean of order 2 that the cut moments would bring

    @property
    def ripple(self) -> float:
        """What is left of `peak_error` after the window, away from the sun."""
        return min(self.peak_error, _MOST_RIPPLE)

    def window(self) -> np.ndarray:
        """Factors of the moments x_l, (n_moments,): 1, or a Gaussian that blurs a peak too sharp for the series.

        Cut moments of a peak sharper than that leave ripples as strong as the sky; blurred, order 2 and up are wrong
        within some degrees of the sun alone, where order 1 is far brighter.
        """
        last = min(1.0, np.sqrt(_MOST_RIPPLE / max(self.peak_error, _MOST_RIPPLE)))
        return np.asarray(last ** (np.arange(self.n_moments) / self.n_moments) ** 2)

    def halved(self) -> Resolution:
        """Half the elements, half the nodes or what the moments need: a resolution's own error is judged against it."""
        n_mu = max(self.n_mu // 2, 3 + (self.n_moments + 1) // 2, 4)
        return replace(self, n_mu=n_mu, n_element=max(self.n_element // 2, 2))


def least_nodes(n_directions: int) -> int:
    """Gauss nodes of a hemisphere that stand for so many directions on the sphere: half the root, at most 64."""
    return min(math.ceil(0.5 * math.sqrt(n_directions)), MOST_MU_NODES)


def elements_for(optical_depth: float) -> int:
    """Elements to spread over a column: shallow paths see the last tenths of its depth.

    10 up to an optical depth of 1, then slowly more: 18 at 5, 23 at 10.
    """
    return int(np.clip(np.ceil(_LEAST_ELEMENTS * optical_depth**0.36), _LEAST_ELEMENTS, _MOST_ELEMENTS))


def choose_resolution(
    slabs: Sequence[Slab], kinds: Sequence[np.ndarray], n_element: int, tolerance: float, most_moments: int
) -> Resolution:
    """Resolution that the most peaked phase function of a set of columns asks for.

    What a series cut at degree L lacks of order 2 is a narrow peak at the sun, where order 1 is far brighter, and
    ripples all over the sky, which as a share of the mean of order 2 are about (L + 1/2) x_L^2 (s / t)^2, with s the
    scattering optical depth of the peaked particles and t that of all.

    `kinds` are the phase moments (n_kind, SERIES_LENGTH) of each column, `tolerance` the largest ripple allowed as a
    share of the mean of order 2.
    """
    degree = np.arange(SERIES_LENGTH)
    missing = np.zeros(SERIES_LENGTH + 1)
    for slab, moments in zip(slabs, kinds, strict=True):
        depth = slab.scattering.mean(axis=2) @ np.diff(slab.edge_depth)
        weight = (depth / max(depth.sum(), np.finfo(float).tiny)) ** 2
        share = weight @ ((degree + 0.5) * moments**2)
        missing[:-1] = np.maximum(missing[:-1], np.maximum.accumulate(share[::-1])[::-1])
    enough = int(np.argmax(missing <= tolerance))
    n_moments = int(np.clip(enough, 3, most_moments))
    return Resolution(
        n_mu=max(_LEAST_MU_NODES, 6 + (n_moments + 1) // 2),
        n_element=n_element,
        n_moments=n_moments,
        peak_error=float(missing[n_moments]),
    )
