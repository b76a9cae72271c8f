"""Phase functions as series of Legendre functions: the azimuth of a scattering problem, one Fourier mode at a time.

With the normalised associated Legendre functions

    V_lm(mu) = sqrt((l - m)! / (l + m)!) P_lm(mu),       P_l(cos T) = sum_m (2 - [m = 0]) V_lm(mu) V_lm(mu') cos(m phi),

a phase function p(cos T) = sum_l (2 l + 1) / (4 pi) x_l P_l(cos T) has the moments x_l = 2 pi int p(c) P_l(c) dc, with
x_0 = 1, and its mode m is p_m(mu, mu') = sum_(l >= m) (2 l + 1) / (4 pi) x_l V_lm(mu) V_lm(mu').
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial.legendre import leggauss

from aomc_sky.errors import SceneError

_N_PANEL, _N_GAUSS = 24, 32  # resolve a forward peak of 1 - c = 1e-6, and P_l up to l = 256 with five nodes a wave
_NORM_TOLERANCE = 1e-3


_NODE, _WEIGHT = np.polynomial.legendre.leggauss(_N_GAUSS)
_ROUGH = 1e-10  # of the integral, that halving a panel may change
_MOST_HALVINGS, _MOST_ROUGH = 40, 64

_LOW_PANEL = 0.05
_LOW_NODES = 6


def _panels(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cosines c and 2 pi dc on panels of v, (n_panel, n): 1 - c = 2 (v (2 - v))^4, crowded at both ends."""
    half = 0.5 * (high - low)[:, None]
    v = 0.5 * (high + low)[:, None] + half * _NODE
    t = v * (2.0 - v)
    return 1.0 - 2.0 * t**4, 32.0 * np.pi * t**3 * (1.0 - v) * _WEIGHT * half


def _moment_weights(cosine: np.ndarray, weight: np.ndarray, n_moments: int) -> np.ndarray:
    """P_l(c) times weights, (n_moments, n)."""
    table = np.empty((n_moments, cosine.size))
    before, here = np.zeros(cosine.size), np.ones(cosine.size)
    for degree in range(n_moments):
        table[degree] = here
        before, here = here, ((2 * degree + 1) * cosine.ravel() * here - degree * before) / (degree + 1)
    return weight.ravel() * table


@lru_cache(maxsize=2)
def _forward_quadrature(n_moments: int) -> tuple[np.ndarray, np.ndarray]:
    """Cosines (n_panel, n) and weights of the moments (n_moments, n_panel, n) of equal panels."""
    edges = np.linspace(0.0, 1.0, _N_PANEL + 1)
    cosine, weight = _panels(edges[:-1], edges[1:])
    return cosine, _moment_weights(cosine, weight, n_moments).reshape(n_moments, *cosine.shape)


def _is_rough(phase: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Whether the two halves of a panel bring another integral than the panel: a jump, a bend, a narrow peak."""
    middle = 0.5 * (low + high)
    whole, first, second = (
        np.sum(weight * phase(cosine.ravel()).reshape(cosine.shape), axis=1)
        for cosine, weight in (_panels(low, high), _panels(low, middle), _panels(middle, high))
    )
    return np.asarray(np.abs(first + second - whole) > _ROUGH)


def _pieces(phase: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, ...]:
    """Panels that replace rough ones: halves, halved again where a jump lies."""
    smooth_low, smooth_high = [], []
    for _ in range(_MOST_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        rough = _is_rough(phase, low, high)
        smooth_low.append(low[~rough])
        smooth_high.append(high[~rough])
        low, high = low[rough], high[rough]
        if not 0 < low.size <= _MOST_ROUGH:
            break
    return np.concatenate([*smooth_low, low]), np.concatenate([*smooth_high, high])


def phase_moments(phase: Callable[[np.ndarray], np.ndarray], n_moments: int) -> np.ndarray:
    """Legendre moments x_l of a phase function, l = 0 to n_moments - 1.

    `phase` has the integral 1 over the sphere; up to 256 moments. x_0 is 1 exactly: the quadrature's own norm is
    divided out, so that a solver conserves energy. A SceneError where the norm is off by more than 1e-3: no phase
    function, or one with a peak narrower than 1e-6 in 1 - c.

    Accuracy: 1e-12 for smooth functions and peaks down to 1 - c = 1e-5, 1e-9 with jumps and bends, which panels are
    halved towards. Cost: 0.2 ms, 2 ms with a jump.
    """
    cosine, quadrature = _forward_quadrature(n_moments)
    edges = np.linspace(0.0, 1.0, _N_PANEL + 1)
    rough = _is_rough(phase, edges[:-1], edges[1:])
    smooth = quadrature[:, ~rough].reshape(n_moments, -1)
    moments = smooth @ phase(cosine[~rough].ravel())
    if np.any(rough):
        finer, weight = _panels(*_pieces(phase, edges[:-1][rough], edges[1:][rough]))
        moments += _moment_weights(finer, weight, n_moments) @ phase(finer.ravel())
    if not abs(moments[0] - 1.0) < _NORM_TOLERANCE:
        raise SceneError(f"a phase function has the integral {moments[0]:.6g} over the sphere; expected 1")
    return moments / moments[0]


def legendre_table(mu: np.ndarray, n_modes: int, n_moments: int) -> np.ndarray:
    """Normalised associated Legendre functions, V_lm(mu) at [m, l - m]; a row ends in zeros from l = n_moments on.

    The place l - m makes the parity V_lm(-mu) = (-1)^(l - m) V_lm(mu) one of even and odd columns.

    Shape (n_modes, n_moments, n), n_modes <= n_moments.

    Accuracy: 1e-13 absolute; the recurrence in l is stable, for all modes at once.
    """
    order = np.arange(n_modes, dtype=float)[:, None]
    steps = np.arange(1, n_modes, dtype=float)[:, None]
    sine = np.sqrt((1.0 - mu) * (1.0 + mu))
    factors = np.sqrt((2.0 * steps - 1.0) / (2.0 * steps)) * sine
    here = np.vstack([np.ones((1, mu.size)), np.cumprod(factors, axis=0)])
    before = np.zeros_like(here)
    table = np.zeros((n_modes, n_moments, mu.size))
    for offset in range(n_moments):
        table[:, offset] = np.where(order + offset < n_moments, here, 0.0)
        degree = order + offset + 1.0  # the next one
        ahead = (2.0 * degree - 1.0) * mu * here - np.sqrt((degree - 1.0) ** 2 - order**2) * before
        before, here = here, ahead / np.sqrt(degree**2 - order**2)
    return table


def moments_by_mode(moments: np.ndarray, n_modes: int) -> np.ndarray:
    """Moments times (2 l + 1) / 2, arranged like `legendre_table`: entry [m, l - m], zeros past the last degree.

    Shape (..., n_modes, n_moments) of moments (..., n_moments).
    """
    n = moments.shape[-1]
    padded = np.concatenate([(np.arange(n) + 0.5) * moments, np.zeros((*moments.shape[:-1], n_modes))], axis=-1)
    return padded[..., np.arange(n_modes)[:, None] + np.arange(n)]


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
