"""The Henyey-Greenstein phase function for use inside an @njit function of a transport code.

Each takes and returns scalars; the result has the precision of the first argument, and float32 is worked
out in float64. The bits are those of `aomc_sky.henyey_greenstein`. Nothing is checked: xi lies in [0, 1],
g in (-1, 1), 1 - mu in [0, 2].
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels import plain_hg as plain
from aomc_sky.kernels.jit import inner, kernel

_twice_square = inner(plain.twice_square)
_mirrored = inner(plain.mirrored)
_gap = inner(plain.gap)
_numerators = inner(plain.numerators)
_ends = inner(plain.ends)
_short_numerators = inner(plain.short_numerators)
_root = inner(plain.root)
_density = inner(plain.density)
_nearer = inner(plain.nearer)
_farther = inner(plain.farther)


@inner
def _cosine(xi, g):
    # `plain.cosine`; numpy's `where` would not vectorise here
    forward = g >= 0.0
    v, w, square = _short_numerators(xi if forward else 1.0 - xi, abs(g))
    ahead = v < square
    r = (v if ahead else w) / square
    mu = 1.0 - r if ahead else r - 1.0
    return mu if forward else -mu


@inner
def sample_mu(xi, g):
    """Cosine mu of the scattering angle; xi is the probability of a smaller one."""
    return type(xi)(_cosine(np.float64(xi), np.float64(g)))


@inner
def sample_mu_sin(xi, g):
    """mu, 1 - mu and the sine of the scattering angle, the last two right to their own last digits."""
    x, mean = np.float64(xi), np.float64(g)
    h, off, sign = _mirrored(mean)
    d, rest = _gap(h)
    far = 1.0 + h
    near_square, far_square = _twice_square(d, rest), _twice_square(far, h - (far - 1.0))
    v, w, square = _numerators(x, h, off, sign, d, rest, near_square, far_square)
    v, w = _ends(v, w, square, off)
    return type(xi)(_cosine(x, mean)), type(xi)(v), type(xi)(np.sqrt(v * w))


@inner
def pdf_sr(one_minus_mu, g):
    """Density per steradian at 1 - mu."""
    h, off, _ = _mirrored(np.float64(g))
    d, rest = _gap(h)
    _, _, R = _root(np.float64(one_minus_mu), h, off, d, rest)
    return type(one_minus_mu)(_density(h, d, R))


@inner
def _tails(v, g):
    h, off, _ = _mirrored(g)
    d, rest = _gap(h)
    a, b, R = _root(v, h, off, d, rest)
    near, far = _nearer(a, h, d, R), _farther(b, h, d, R)
    return (1.0 - off) * far + off * near, (1.0 - off) * near + off * far


@inner
def cdf(one_minus_mu, g):
    """Probability of a smaller mu."""
    return type(one_minus_mu)(_tails(np.float64(one_minus_mu), np.float64(g))[0])


@inner
def survival(one_minus_mu, g):
    """Probability of a larger mu."""
    return type(one_minus_mu)(_tails(np.float64(one_minus_mu), np.float64(g))[1])


@kernel
def fill_mu(xi, g, mu):
    """`sample_mu` over an array, for one g or as many as numbers."""
    if g.size == 1:
        one = g[0]
        for k in range(xi.size):
            mu[k] = sample_mu(xi[k], one)
    else:
        for k in range(xi.size):
            mu[k] = sample_mu(xi[k], g[k])


@kernel
def fill_mu_sin(xi, g, mu, one_minus_mu, sin_theta):
    """`sample_mu_sin` over an array, for one g or as many as numbers."""
    if g.size == 1:
        one = g[0]
        for k in range(xi.size):
            mu[k], one_minus_mu[k], sin_theta[k] = sample_mu_sin(xi[k], one)
    else:
        for k in range(xi.size):
            mu[k], one_minus_mu[k], sin_theta[k] = sample_mu_sin(xi[k], g[k])
