"""Phase functions and the scattering step for use inside an @njit function of a transport code.

Each takes and returns scalars; the result has the precision of the first argument, and float32 is worked
out in float64 but for the last division of Henyey-Greenstein's mu. The bits are those of `aomc_sky.rayleigh`,
`aomc_sky.henyey_greenstein` and `aomc_sky.scattering`. Nothing is checked: gamma, xi and the azimuth's share lie in
[0, 1], g in (-1, 1), 1 - mu in [0, 2].

Over arrays each law has loops of its own, and one for a single parameter, whose part of the work then stands outside
the loop: so they become vectors.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic import error_free
from aomc_sky.kernels.jit import inlined, inner, kernel, shared, shared_inlined
from aomc_sky.kernels.phase import henyey_greenstein, rayleigh, scatter

_r_cubic_share = inner(rayleigh.cubic_share)
_r_invert = inner(rayleigh.invert)
_r_ends = inner(rayleigh.ends)
_r_density = inner(rayleigh.density)
_r_cumulated = inner(rayleigh.cumulated)

_product_error = inlined(error_free.product_error)
_twice_square = inner(henyey_greenstein.twice_square)
_mirrored = inner(henyey_greenstein.mirrored)
_gap = inner(henyey_greenstein.gap)
_numerators = inner(henyey_greenstein.numerators)
_ends = inner(henyey_greenstein.ends)
_pivot = inlined(henyey_greenstein.pivot)
_middle = inlined(henyey_greenstein.middle)
_parts = inlined(henyey_greenstein.parts)
_short_parts = inner(henyey_greenstein.short_parts)
_root = inner(henyey_greenstein.root)
_density = inner(henyey_greenstein.density)
_nearer = inner(henyey_greenstein.nearer)
_farther = inner(henyey_greenstein.farther)

_cos_sin = inner(scatter.cos_sin)
_turned = inner(scatter.turned)


@shared
def rayleigh_sample_mu(xi, gamma):
    """Cosine mu of the scattering angle; xi is the probability of a smaller one."""
    return type(xi)(_r_invert(np.float64(xi), _r_cubic_share(np.float64(gamma))))


@shared
def rayleigh_sample_mu_sin(xi, gamma):
    """mu, 1 - mu and the sine of the scattering angle."""
    x = np.float64(xi)
    k = _r_cubic_share(np.float64(gamma))
    mu = _r_invert(x, k)
    v, w = _r_ends(x, mu, k)
    return type(xi)(mu), type(xi)(v), type(xi)(np.sqrt(v * w))


@shared
def rayleigh_pdf_mu(mu, gamma):
    """Density over mu, normalised to 1 on [-1, 1]."""
    return type(mu)(_r_density(np.float64(mu), np.float64(gamma)))


@shared
def rayleigh_cdf_mu(mu, gamma):
    """Probability of a smaller mu."""
    return type(mu)(_r_cumulated(np.float64(mu), np.float64(gamma)))


@inlined
def _cosine(xi, g):
    # `henyey_greenstein.cosine`, with a branch on the sign that leaves the loops of a single g
    h, off, sign = _mirrored(g)
    d, rest = _gap(h)
    zero, zero_rest = _pivot(h, d, rest, _product_error)
    xi_0, hp_0, n_0, twice = _middle(h, off, sign, d, rest, zero, zero_rest, _product_error)
    n, ahead, behind = _parts(xi, xi if g >= 0.0 else 1.0 - xi, h, d, xi_0, hp_0, n_0, twice)
    return n / (abs(n) + min(ahead, behind))


@inlined
def _cosine32(xi, g):
    # `henyey_greenstein.cosine32`
    forward = g >= 0.0
    n, whole = _short_parts(xi if forward else 1.0 - xi, abs(g))
    mu = np.float32(n) / np.float32(whole)
    return mu if forward else -mu


@shared_inlined
def hg_sample_mu(xi, g):
    """Cosine mu of the scattering angle; xi is the probability of a smaller one."""
    x, mean = np.float64(xi), np.float64(g)
    if type(xi)(1.0 + 2.0**-40) == 1.0:  # known to the compiler: xi is float32
        return type(xi)(_cosine32(x, mean))
    return type(xi)(_cosine(x, mean))


@shared
def hg_sample_mu_sin(xi, g):
    """mu, 1 - mu and the sine of the scattering angle, the last two right to their own last digits."""
    x, mean = np.float64(xi), np.float64(g)
    h, off, sign = _mirrored(mean)
    d, rest = _gap(h)
    far = 1.0 + h
    near_square = _twice_square(d, rest, _product_error)
    far_square = _twice_square(far, h - (far - 1.0), _product_error)
    v, w, square = _numerators(x, h, off, sign, d, rest, near_square, far_square)
    v, w = _ends(v, w, square, off)
    return hg_sample_mu(xi, g), type(xi)(v), type(xi)(np.sqrt(v * w))


@shared
def hg_pdf_sr(one_minus_mu, g):
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
def hg_cdf(one_minus_mu, g):
    """Probability of a smaller mu."""
    return type(one_minus_mu)(_tails(np.float64(one_minus_mu), np.float64(g))[0])


@shared
def hg_survival(one_minus_mu, g):
    """Probability of a larger mu."""
    return type(one_minus_mu)(_tails(np.float64(one_minus_mu), np.float64(g))[1])


@shared
def new_direction(ux, uy, uz, one_minus_mu, sin_theta, azimuth_share):
    """Direction after scattering by theta; `azimuth_share` is uniform in [0, 1). The precision is that of ux."""
    c, s = _cos_sin(np.float64(azimuth_share))
    v, sine = np.float64(one_minus_mu), np.float64(sin_theta)
    x, y, z = _turned(np.float64(ux), np.float64(uy), np.float64(uz), v, sine, c, s)
    return type(ux)(x), type(ux)(y), type(ux)(z)


@kernel
def fill_mu(is_hg, xi, parameter, mu):
    """`sample_mu` over an array, for one parameter or as many as numbers."""
    n = xi.size
    one = parameter[0]
    if parameter.size == 1 and is_hg:
        for k in range(n):
            mu[k] = hg_sample_mu(xi[k], one)
    elif parameter.size == 1:
        for k in range(n):
            mu[k] = rayleigh_sample_mu(xi[k], one)
    elif is_hg:
        for k in range(n):
            mu[k] = hg_sample_mu(xi[k], parameter[k])
    else:
        for k in range(n):
            mu[k] = rayleigh_sample_mu(xi[k], parameter[k])


@kernel
def fill_mu_sin(is_hg, xi, parameter, mu, one_minus_mu, sin_theta):
    """`sample_mu_sin` over an array, for one parameter or as many as numbers."""
    n = xi.size
    one = parameter[0]
    if parameter.size == 1 and is_hg:
        for k in range(n):
            mu[k], one_minus_mu[k], sin_theta[k] = hg_sample_mu_sin(xi[k], one)
    elif parameter.size == 1:
        for k in range(n):
            mu[k], one_minus_mu[k], sin_theta[k] = rayleigh_sample_mu_sin(xi[k], one)
    elif is_hg:
        for k in range(n):
            mu[k], one_minus_mu[k], sin_theta[k] = hg_sample_mu_sin(xi[k], parameter[k])
    else:
        for k in range(n):
            mu[k], one_minus_mu[k], sin_theta[k] = rayleigh_sample_mu_sin(xi[k], parameter[k])
