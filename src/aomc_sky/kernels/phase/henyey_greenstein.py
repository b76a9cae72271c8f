"""The Henyey-Greenstein phase function's formulas: + - x / sqrt alone, one text for arrays and for kernels.

Everything is written for h = |g| and mirrored, so that the peak is always at p = 1; 1 - h and the rounding it leaves
are carried along. The derivation is in docs/models/rayleigh.md.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic import error_free
from aomc_sky.kernels.formula import formulas, smaller

_INV_4PI = 0.07957747154594767

product_error = error_free.product_error


def twice_square(x, rest):
    """2 (x + rest)^2, rounded once; `rest` is the rounding error of x."""
    square = x * x
    twice = square + (product_error(x, x, square) + 2.0 * (x * rest))
    return twice + twice


def mirrored(g):
    """Size h of g, 1 where g is negative and 0 elsewhere, and the sign."""
    sign = np.copysign(1.0, g + 0.0)  # -0.0 counts as 0.0
    return np.abs(g), 0.5 - 0.5 * sign, sign


def gap(h):
    """1 - h and its rounding error."""
    d = 1.0 - h
    return d, (1.0 - d) - h


def numerators(xi, h, off, sign, d, rest, near, far):
    """1 - mu and 1 + mu at xi for g = h, as numerators, and their denominator D^2.

    Write D = (1-h) + 2 h p. Then 1 - mu = 2 (1-h)^2 q (1 + h p) / D^2 and 1 + mu = 2 (1+h)^2 p ((1-h) + h p) / D^2.
    These formulas have no difference of similar numbers and no division by h. `near` and `far` are
    2 (1-h)^2 and 2 (1+h)^2. D^2 is corrected for the rounding of D.
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


def pivot(h, d, rest):
    """The z of `parts` at which mu is 0, (1-h)^2 / (2 (1 + h^2)), and its rounding error."""
    square, h2 = d * d, h * h
    c = 1.0 + h2
    c_rest = ((1.0 - c) + h2) + product_error(h, h, h2)
    share = 0.5 / c
    zero = square * share
    c, c_rest = c + c, c_rest + c_rest
    back = zero * c
    left = (square - back) - product_error(zero, c, back)
    left = left + (product_error(d, d, square) + 2.0 * (d * rest) - zero * c_rest)
    moved = zero + left * share
    return moved, (zero - moved) + left * share


def middle(h, off, sign, d, rest, zero, zero_rest):
    """Arguments of `parts` that depend on g alone, all at mu = 0: xi, h p, n, and twice z."""
    q = np.sqrt(1.0 + h * h)
    xi = off + sign * (d / (q * ((1.0 + h) + q)))
    p = off + sign * xi
    hp = h * p
    s = d + hp
    z = p * s
    z_rest = product_error(p, s, z) + p * ((hp - (s - d)) + rest)
    return xi, hp, sign * ((z - zero) + (z_rest - zero_rest)), zero + zero


def parts(xi, p, h, d, xi_0, hp_0, n_0, twice):
    """Numerator n of mu, and what its denominator has more than abs(n), for mu > 0 and for mu < 0: the smaller one.

    Write z = p ((1-h) + h p) and z0 = (1-h)^2 / (2 (1 + h^2)). Then 1 - mu = 2 (1-h)^2 (1 - z) / D^2,
    1 + mu = 2 (1+h)^2 z / D^2 and D^2 = (1-h)^2 + 4 h z. It follows that mu = (z - z0) / (z0 + (1 - 2 z0) z).
    The difference z - z0 is (p - p0) ((1-h) + h p + h p0), which loses nothing near mu = 0.
    """
    s = d + h * p
    z = p * s
    return (xi - xi_0) * (s + hp_0) + n_0, twice * (1.0 - z), (2.0 - twice) * z


def cosine(xi, g):
    """Cosine of the scattering angle: one division and no root where g is one number."""
    h, off, sign = mirrored(g)
    d, rest = gap(h)
    zero, zero_rest = pivot(h, d, rest)
    xi_0, hp_0, n_0, twice = middle(h, off, sign, d, rest, zero, zero_rest)
    n, ahead, behind = parts(xi, off + sign * xi, h, d, xi_0, hp_0, n_0, twice)
    return n / (np.abs(n) + smaller(ahead, behind))


def beside_the_ends(xi, g):
    """1 - mu and the sine of the scattering angle, right to their own last digits."""
    h, off, sign = mirrored(g)
    d, rest = gap(h)
    far = 1.0 + h
    near_square, far_square = twice_square(d, rest), twice_square(far, h - (far - 1.0))
    v, w, square = numerators(xi, h, off, sign, d, rest, near_square, far_square)
    v, w = ends(v, w, square, off)
    return v, np.sqrt(v * w)


def root(v, h, off, d, rest):
    """Distance a from the peak of the lobe, that from its far end, R^2 = (1-h)^2 + 2 h a rounded once, and R."""
    w = 2.0 - v
    a = (1.0 - off) * v + off * w
    b = (1.0 - off) * w + off * v
    gap2, ha = d * d, h * a
    gap2_rest, twice = product_error(d, d, gap2) + 2.0 * (d * rest), ha + ha
    square = gap2 + twice
    back = square - gap2
    lost = (gap2 - (square - back)) + (twice - back)
    square = square + (lost + (gap2_rest + 2.0 * product_error(h, a, ha)))
    return a, b, square, np.sqrt(square)


def density(v, g):
    """Density per steradian at v = 1 - mu."""
    h, off, _ = mirrored(g)
    d, rest = gap(h)
    _, _, square, R = root(v, h, off, d, rest)
    return _INV_4PI * (d * (1.0 + h)) / (square * R)


def tails(v, g):
    """Probabilities of a smaller and of a larger mu at v = 1 - mu.

    Nearer to the peak lies (1+h) a / (R (R + 1-h)), farther from it (1-h) (2-a) / (R (R + 1+h)).
    """
    h, off, _ = mirrored(g)
    d, rest = gap(h)
    a, b, square, R = root(v, h, off, d, rest)
    near, far = smaller((1.0 + h) * a / (square + d * R), 1.0), smaller(d * b / (square + (1.0 + h) * R), 1.0)
    return (1.0 - off) * far + off * near, (1.0 - off) * near + off * far


formulas(
    product_error,
    twice_square,
    mirrored,
    gap,
    numerators,
    ends,
    pivot,
    middle,
    parts,
    cosine,
    beside_the_ends,
    root,
    density,
    tails,
    is_inlined=True,
)
