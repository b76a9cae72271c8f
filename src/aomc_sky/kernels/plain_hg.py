"""The Henyey-Greenstein phase function's formulas: + - x / sqrt alone, for arrays, and for `phase_hg` to compile.

One source for both gives both the same bits. Everything is written for h = |g| and mirrored, so that the
peak is always at p = 1; 1 - h and the rounding it leaves are carried along. The derivation stands in
docs/models/rayleigh.md.
"""

from __future__ import annotations

import numpy as np

_SPLIT = 134217729.0  # 2^27 + 1: cuts a float64 into two halves whose products are exact
_INV_4PI = 0.07957747154594767


def twice_square(x, rest):
    """2 (x + rest)^2, rounded once: `rest` is what the rounding of x left out."""
    cut = _SPLIT * x
    high = cut - (cut - x)
    low = x - high
    square = x * x
    error = ((high * high - square) + 2.0 * (high * low)) + low * low
    twice = square + (error + 2.0 * (x * rest))
    return twice + twice


def mirrored(g):
    """Size h of g, 1 where g is negative and 0 elsewhere, and the sign."""
    sign = np.copysign(1.0, g + 0.0)  # -0.0 counts as 0.0
    return np.abs(g), 0.5 - 0.5 * sign, sign


def gap(h):
    """1 - h and what its rounding leaves out."""
    d = 1.0 - h
    return d, (1.0 - d) - h


def numerators(xi, h, off, sign, d, rest, near, far):
    """1 - mu and 1 + mu at xi for g = h, as numerators, and their denominator D^2.

    1 - mu = 2 (1-h)^2 q (1 + h p) / D^2 and 1 + mu = 2 (1+h)^2 p ((1-h) + h p) / D^2 with
    D = (1-h) + 2 h p: no difference of numbers of like size, no division by h. `near` and `far` are
    2 (1-h)^2 and 2 (1+h)^2. D^2 takes back what the rounding of D left out.
    """
    p = off + sign * xi
    q = (1.0 - off) - sign * xi
    hp = h * p
    twice = hp + hp
    D = d + twice
    back = D - d
    lost = ((d - (D - back)) + (twice - back)) + rest
    return near * (q + q * hp), far * (p * (d + (hp + rest))), D * D + (D + D) * lost


def ends(v, w, square, off):
    """1 - mu and 1 + mu from the numerators."""
    v = v / square
    w = w / square
    keep = 1.0 - off
    return keep * v + off * w, keep * w + off * v


def short_numerators(p, h):
    """`numerators` without what the roundings leave out: enough for mu itself, and as fast as the textbook."""
    d = 1.0 - h
    far = 1.0 + h
    hp = h * p
    D = d + (hp + hp)
    return (2.0 * (d * d)) * ((1.0 - p) * (1.0 + hp)), (2.0 * (far * far)) * (p * (d + hp)), D * D


def cosine(xi, g):
    """Cosine from the smaller of 1 - mu and 1 + mu: one division."""
    forward = g >= 0.0
    v, w, square = short_numerators(np.where(forward, xi, 1.0 - xi), np.abs(g))
    ahead = v < square
    r = np.where(ahead, v, w) / square
    mu = np.where(ahead, 1.0 - r, r - 1.0)
    return np.where(forward, mu, -mu)


def root(v, h, off, d, rest):
    """Distance a from the peak of the lobe, that from its far end, and R = sqrt((1-h)^2 + 2 h a)."""
    w = 2.0 - v
    a = (1.0 - off) * v + off * w
    b = (1.0 - off) * w + off * v
    return a, b, np.sqrt((d * d + (d + d) * rest) + 2.0 * (h * a))


def density(h, d, R):
    """Density per steradian."""
    return _INV_4PI * (d * (1.0 + h)) / (R * R * R)


def nearer(a, h, d, R):
    """Probability of a direction closer to the peak."""
    return (1.0 + h) * a / (R * (R + d))


def farther(b, h, d, R):
    """Probability of a direction farther from the peak."""
    return d * b / (R * ((1.0 + h) + R))
