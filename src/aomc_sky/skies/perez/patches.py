"""Masses of the patches of a Perez sky: what its luminance needs of the rule in `skies.quadrature`.

The luminance is a cone at the sun, where patches are cut. In the layer at the horizon, where exp(b / cos xi) changes,
rings are cut until Gauss points see the first factor. If the second factor changes its sign, it does so on a circle
about the sun, where patches end.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.elementary import HALF_PI, exp_level, half_sine2, sin_cos
from aomc_sky.skies.perez.kernels.law import first_factor, second_factor
from aomc_sky.skies.quadrature import POINTS, Rule, Terms, cut, points_of, weighted_sum

_SHARE = 1e-11
_RING_SHARE = 1e-10
_ROUNDING = 1e-15
_THINNEST = 1e-7
_MOST_DECAY = 2.5
_STEPS = 720
_HALVINGS = 80


def patch_integrals(zenith: np.ndarray, azimuth: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Integral of max(f, 0) cos xi over each patch, shape (n_ring, n_column). [sr]

    Accuracy: 1e-10 of the patch, 1e-8 if it is wider than 10 degrees, and 1e-15 of all of them.

    Edges of rings and columns (n, 2) in quarter turns; of `numbers` the first eight as in `Component.shared`, b <= 0.
    """
    rule = _rule_of(numbers, _ring_cuts(zenith, *numbers[:2].tolist()))
    mass = rule.integrate(zenith, azimuth).masses(len(zenith) * len(azimuth))
    return mass.reshape(len(zenith), len(azimuth)) * (HALF_PI * HALF_PI)


def patch_moments(zenith: np.ndarray, azimuth: np.ndarray, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means of mu and of 1/mu over the flux of max(f, 0) from each patch, (n_ring, n_column) each, 0 where it is dark.

    Arguments as for `patch_integrals`. A patch has 4 x 4 Gauss points in zenith angle and azimuth, where the flux over
    mu is smooth up to the horizon. Means over a whole sky are good to 1e-6 on patches of 2 degrees, 1e-4 on 10.
    """
    x, y = zenith - numbers[5], azimuth - numbers[6]
    nodes, weights, _ = POINTS[4]
    rule = _rule_of(numbers, np.zeros(0))
    points = points_of(4, (x[:, :1], x[:, 1:], y[None, :, 0], y[None, :, 1]))
    values = rule.values_of(rule.integrand)(*points, np.zeros(0, dtype=np.int64))
    lines = weighted_sum(np.swapaxes(values, 0, 1), weights)
    mu = sin_cos(zenith[:, :1] + (zenith[:, 1:] - zenith[:, :1]) * nodes)[1].T[:, :, None]
    flux, with_mu, without_mu = (weighted_sum(part, weights) for part in (lines, lines * mu, lines / mu))
    lit = flux > 0
    return (
        np.divide(with_mu, flux, out=np.zeros_like(flux), where=lit),
        np.divide(without_mu, flux, out=np.zeros_like(flux), where=lit),
    )


def _rule_of(numbers: np.ndarray, cuts: np.ndarray) -> Rule:
    a, b, c, d, e, sun_x, sun_y, sun_sine = numbers[:8].tolist()

    def x_terms(x: np.ndarray) -> Terms:
        sine, mu = sin_cos(x + sun_x)
        return half_sine2(x), sine * sun_sine, sine * mu * first_factor(mu, a, b)

    def integrand(terms_x: Terms, terms_y: Terms, _: np.ndarray) -> np.ndarray:
        near, growth, factor = terms_x
        value: np.ndarray = np.maximum(factor * second_factor(near + growth * terms_y[0], c, d, e), 0.0)
        return value

    return Rule(
        integrand=integrand,
        x_terms=x_terms,
        y_terms=lambda y: (half_sine2(y),),
        centre=(sun_x, sun_y),
        width=_MOST_DECAY / max(-d, 1e-3),
        cusp=abs(c * d) * (1.0 + abs(a)) / (HALF_PI * HALF_PI) if sun_sine > 0.0 else 0.0,
        circles=second_factor_zeros(c, d, e).tolist(),
        marks=cuts,
        share=_SHARE,
    )


def _ring_cuts(zenith: np.ndarray, a: float, b: float) -> np.ndarray:
    """Zenith angles that cut rings: at a zero of the first factor, then until orders 3 and 4 agree on it."""
    zero = first_factor_zero(a, b)
    cuts = [np.array([zero])]
    x0, x1 = cut(zenith, cuts[0])[0].T
    while x0.size:
        sums = []
        for order in (3, 4):
            nodes, weights, _ = POINTS[order]
            sine, mu = sin_cos(x0 + (x1 - x0) * nodes[:, None])
            sums.append(weighted_sum(sine * mu * first_factor(mu, a, b), weights))
        is_cut = np.abs(sums[1] - sums[0]) > _RING_SHARE * np.abs(sums[1]) + _ROUNDING * (1.0 + abs(a))
        is_cut &= x1 - x0 > _THINNEST
        x0, x1 = x0[is_cut], x1[is_cut]
        cuts.append(0.5 * (x0 + x1))
        x0, x1 = np.concatenate([x0, cuts[-1]]), np.concatenate([cuts[-1], x1])
    return np.concatenate(cuts)


def first_factor_zero(a: float, b: float) -> float:
    """Zenith angle where 1 + a exp(b/mu), b <= 0, is 0 and below which it is negative, or -1. [quarter turns]"""
    if b == 0 or a > -1.0 or 1.0 + a * float(exp_level(b)) >= 0:
        return -1.0
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if first_factor(sin_cos(middle)[1], a, b) < 0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def second_factor_zeros(c: float, d: float, e: float) -> np.ndarray:
    """sin^2(gamma/2), ascending, where 1 + c exp(d gamma) + e cos^2 gamma changes its sign.

    Seen in steps of a quarter degree, in numbers that are the same on every machine.
    """
    if c >= 0 and e > -1:
        return np.empty(0)
    h = half_sine2(np.arange(_STEPS + 1) * (2.0 / _STEPS))
    h[-1] = 1.0
    negative = second_factor(h, c, d, e) < 0
    changes = np.flatnonzero(negative[1:] != negative[:-1])
    low, high = h[changes], h[changes + 1]
    for _ in range(_HALVINGS if changes.size else 0):
        middle = 0.5 * (low + high)
        is_low = (second_factor(middle, c, d, e) < 0) == negative[changes]
        low, high = np.where(is_low, middle, low), np.where(is_low, high, middle)
    return 0.5 * (low + high)
