"""The Rayleigh phase function for use inside an @njit function of a transport code.

Each takes and returns scalars; the result has the precision of the first argument, and float32 is worked
out in float64. The bits are those of `aomc_sky.rayleigh`. Nothing is checked: gamma and xi lie in [0, 1].
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.jit import inner, shared
from aomc_sky.kernels.phase import rayleigh as plain

_cubic_share = inner(plain.cubic_share)
_invert = inner(plain.invert)
_ends = inner(plain.ends)
_density = inner(plain.density)
_cumulated = inner(plain.cumulated)


@shared
def sample_mu(xi, gamma):
    """Cosine mu of the scattering angle; xi is the probability of a smaller one."""
    return type(xi)(_invert(np.float64(xi), _cubic_share(np.float64(gamma))))


@shared
def sample_mu_sin(xi, gamma):
    """mu, 1 - mu and the sine of the scattering angle."""
    x = np.float64(xi)
    k = _cubic_share(np.float64(gamma))
    mu = _invert(x, k)
    v, w = _ends(x, mu, k)
    return type(xi)(mu), type(xi)(v), type(xi)(np.sqrt(v * w))


@shared
def pdf_mu(mu, gamma):
    """Density over mu, normalised to 1 on [-1, 1]."""
    return type(mu)(_density(np.float64(mu), np.float64(gamma)))


@shared
def cdf_mu(mu, gamma):
    """Probability of a smaller mu."""
    return type(mu)(_cumulated(np.float64(mu), np.float64(gamma)))
