"""The samplers of the phase functions over arrays.

Each law has loops of its own, and one for a single parameter, whose part of the work then stands outside the
loop: so they become vectors.
"""

from __future__ import annotations

from aomc_sky.kernels.jit import kernel
from aomc_sky.kernels.phase.jitted import hg_sample_mu as _hg_mu
from aomc_sky.kernels.phase.jitted import hg_sample_mu_sin as _hg_mu_sin
from aomc_sky.kernels.phase.jitted import rayleigh_sample_mu as _rayleigh_mu
from aomc_sky.kernels.phase.jitted import rayleigh_sample_mu_sin as _rayleigh_mu_sin


@kernel
def fill_mu(is_hg, xi, parameter, mu):
    """`sample_mu` over an array, for one parameter or as many as numbers."""
    n = xi.size
    one = parameter[0]
    if parameter.size == 1 and is_hg:
        for k in range(n):
            mu[k] = _hg_mu(xi[k], one)
    elif parameter.size == 1:
        for k in range(n):
            mu[k] = _rayleigh_mu(xi[k], one)
    elif is_hg:
        for k in range(n):
            mu[k] = _hg_mu(xi[k], parameter[k])
    else:
        for k in range(n):
            mu[k] = _rayleigh_mu(xi[k], parameter[k])


@kernel
def fill_mu_sin(is_hg, xi, parameter, mu, one_minus_mu, sin_theta):
    """`sample_mu_sin` over an array, for one parameter or as many as numbers."""
    n = xi.size
    one = parameter[0]
    if parameter.size == 1 and is_hg:
        for k in range(n):
            mu[k], one_minus_mu[k], sin_theta[k] = _hg_mu_sin(xi[k], one)
    elif parameter.size == 1:
        for k in range(n):
            mu[k], one_minus_mu[k], sin_theta[k] = _rayleigh_mu_sin(xi[k], one)
    elif is_hg:
        for k in range(n):
            mu[k], one_minus_mu[k], sin_theta[k] = _hg_mu_sin(xi[k], parameter[k])
    else:
        for k in range(n):
            mu[k], one_minus_mu[k], sin_theta[k] = _rayleigh_mu_sin(xi[k], parameter[k])
