"""The phase functions and the scattering step for use inside an @njit function of your own; importing this loads numba.

The names are `rayleigh_` and `hg_` before those of the two modules, and `new_direction`::

    from numba import njit
    from aomc_sky.kernels.phase import jitted


    @njit
    def scatter(ux, uy, uz, xi, share, g):
        mu, one_minus_mu, sin_theta = jitted.hg_sample_mu_sin(xi, g)
        return jitted.new_direction(ux, uy, uz, one_minus_mu, sin_theta, share)

Arguments and results are scalars in the precision of the first argument. float32 is computed in float64. The bits are
those of `aomc_sky.rayleigh`, `aomc_sky.henyey_greenstein` and `aomc_sky.scattering`. Arguments are not checked: outside
their ranges the results have no meaning. Gamma, xi and the azimuth's share lie in [0, 1], g in (-1, 1), 1 - mu in [0,
2].
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.elementary import sin_cos
from aomc_sky.kernels.jit import inner, shared, shared_inlined
from aomc_sky.kernels.phase import henyey_greenstein as hg
from aomc_sky.kernels.phase import rayleigh, scatter

_turned = inner(scatter.turned)


@shared
def rayleigh_sample_mu(xi, gamma):
    """Cosine mu of the scattering angle; xi is the probability of a smaller one."""
    return type(xi)(rayleigh.cosine(np.float64(xi), np.float64(gamma)))


@shared
def rayleigh_sample_mu_sin(xi, gamma):
    """mu, 1 - mu and the sine of the scattering angle."""
    mu, one_minus_mu, sine = rayleigh.cosine_and_ends(np.float64(xi), np.float64(gamma))
    return type(xi)(mu), type(xi)(one_minus_mu), type(xi)(sine)


@shared
def rayleigh_pdf_mu(mu, gamma):
    """Density over mu, normalised to 1 on [-1, 1]."""
    return type(mu)(rayleigh.density(np.float64(mu), np.float64(gamma)))


@shared
def rayleigh_cdf_mu(mu, gamma):
    """Probability of a smaller mu."""
    return type(mu)(rayleigh.cumulated(np.float64(mu), np.float64(gamma)))


@shared_inlined
def hg_sample_mu(xi, g):
    """Cosine mu of the scattering angle; xi is the probability of a smaller one."""
    return type(xi)(hg.cosine(np.float64(xi), np.float64(g)))


@shared
def hg_sample_mu_sin(xi, g):
    """mu, 1 - mu and the sine of the scattering angle, the last two right to their own last digits."""
    one_minus_mu, sine = hg.beside_the_ends(np.float64(xi), np.float64(g))
    return hg_sample_mu(xi, g), type(xi)(one_minus_mu), type(xi)(sine)


@shared
def hg_pdf_sr(one_minus_mu, g):
    """Density per steradian at 1 - mu."""
    return type(one_minus_mu)(hg.density(np.float64(one_minus_mu), np.float64(g)))


@shared
def hg_cdf(one_minus_mu, g):
    """Probability of a smaller mu."""
    return type(one_minus_mu)(hg.tails(np.float64(one_minus_mu), np.float64(g))[0])


@shared
def hg_survival(one_minus_mu, g):
    """Probability of a larger mu."""
    return type(one_minus_mu)(hg.tails(np.float64(one_minus_mu), np.float64(g))[1])


@shared
def new_direction(ux, uy, uz, one_minus_mu, sin_theta, azimuth_share):
    """Direction after scattering by theta; `azimuth_share` is uniform in [0, 1). The precision is that of ux."""
    s, c = sin_cos(4.0 * np.float64(azimuth_share))
    v, sine = np.float64(one_minus_mu), np.float64(sin_theta)
    x, y, z = _turned(np.float64(ux), np.float64(uy), np.float64(uz), v, sine, c, s)
    return type(ux)(x), type(ux)(y), type(ux)(z)
