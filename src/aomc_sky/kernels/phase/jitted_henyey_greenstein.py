"""The Henyey-Greenstein phase function for use inside an @njit function of a transport code.

Each takes and returns scalars; the result has the precision of the first argument, and float32 is worked
out in float64 but for the last division of mu. The bits are those of `aomc_sky.henyey_greenstein`. Nothing is
checked: xi lies in [0, 1], g in (-1, 1), 1 - mu in [0, 2].
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.jit import inlined, inner, shared
from aomc_sky.kernels.phase import henyey_greenstein as plain

_product_error = inlined(plain.product_error)
_twice_square = inner(plain.twice_square)
_mirrored = inner(plain.mirrored)
_gap = inner(plain.gap)
_numerators = inner(plain.numerators)
_ends = inner(plain.ends)
_pivot = inlined(plain.pivot)
_middle = inlined(plain.middle)
_parts = inlined(plain.parts)
_short_parts = inner(plain.short_parts)
_root = inner(plain.root)
_density = inner(plain.density)
_nearer = inner(plain.nearer)
_farther = inner(plain.farther)


@inlined
def _cosine(xi, g):
    # `plain.cosine`, with a branch on the sign that leaves the loops of a single g
    h, off, sign = _mirrored(g)
    d, rest = _gap(h)
    zero, zero_rest = _pivot(h, d, rest, _product_error)
    xi_0, hp_0, n_0, twice = _middle(h, off, sign, d, rest, zero, zero_rest, _product_error)
    n, ahead, behind = _parts(xi, xi if g >= 0.0 else 1.0 - xi, h, d, xi_0, hp_0, n_0, twice)
    return n / (abs(n) + min(ahead, behind))


@inlined
def _cosine32(xi, g):
    # `plain.cosine32`
    forward = g >= 0.0
    n, whole = _short_parts(xi if forward else 1.0 - xi, abs(g))
    mu = np.float32(n) / np.float32(whole)
    return mu if forward else -mu


@inlined
def sample_mu(xi, g):
    """Cosine mu of the scattering angle; xi is the probability of a smaller one."""
    x, mean = np.float64(xi), np.float64(g)
    if type(xi)(1.0 + 2.0**-40) == 1.0:  # known to the compiler: xi is float32
        return type(xi)(_cosine32(x, mean))
    return type(xi)(_cosine(x, mean))


@shared
def sample_mu_sin(xi, g):
    """mu, 1 - mu and the sine of the scattering angle, the last two right to their own last digits."""
    x, mean = np.float64(xi), np.float64(g)
    h, off, sign = _mirrored(mean)
    d, rest = _gap(h)
    far = 1.0 + h
    near_square = _twice_square(d, rest, _product_error)
    far_square = _twice_square(far, h - (far - 1.0), _product_error)
    v, w, square = _numerators(x, h, off, sign, d, rest, near_square, far_square)
    v, w = _ends(v, w, square, off)
    return sample_mu(xi, g), type(xi)(v), type(xi)(np.sqrt(v * w))


@shared
def pdf_sr(one_minus_mu, g):
    """Density per steradian at 1 - mu."""
    h, off, _ = _mirrored(np.float64(g))
    d, rest = _gap(h)
    _, _, square, R = _root(np.float64(one_minus_mu), h, off, d, rest, _product_error)
    return type(one_minus_mu)(_density(h, d, square, R))


@inner
def _tails(v, g):
    h, off, _ = _mirrored(g)
    d, rest = _gap(h)
    a, b, square, R = _root(v, h, off, d, rest, _product_error)
    near, far = _nearer(a, h, d, square, R), _farther(b, h, d, square, R)
    return (1.0 - off) * far + off * near, (1.0 - off) * near + off * far


@shared
def cdf(one_minus_mu, g):
    """Probability of a smaller mu."""
    return type(one_minus_mu)(_tails(np.float64(one_minus_mu), np.float64(g))[0])


@shared
def survival(one_minus_mu, g):
    """Probability of a larger mu."""
    return type(one_minus_mu)(_tails(np.float64(one_minus_mu), np.float64(g))[1])
