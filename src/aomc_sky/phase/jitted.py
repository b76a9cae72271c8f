"""The phase functions for use inside an @njit function of your own; importing this loads numba.

The names are `rayleigh_` and `hg_` before those of the two modules, and `new_direction`::

    from numba import njit
    from aomc_sky.phase import jitted

    @njit
    def scatter(ux, uy, uz, xi, share, g):
        mu, one_minus_mu, sin_theta = jitted.hg_sample_mu_sin(xi, g)
        return jitted.new_direction(ux, uy, uz, one_minus_mu, sin_theta, share)

Scalars in, scalars out, in the precision of the first argument; the bits are those of `aomc_sky.rayleigh`,
`aomc_sky.henyey_greenstein` and `aomc_sky.scattering`. Nothing is checked inside: arguments outside their
ranges give meaningless numbers.
"""

from __future__ import annotations

from aomc_sky.kernels.phase.jitted import (
    hg_cdf,
    hg_pdf_sr,
    hg_sample_mu,
    hg_sample_mu_sin,
    hg_survival,
    new_direction,
    rayleigh_cdf_mu,
    rayleigh_pdf_mu,
    rayleigh_sample_mu,
    rayleigh_sample_mu_sin,
)

__all__ = [
    "hg_cdf",
    "hg_pdf_sr",
    "hg_sample_mu",
    "hg_sample_mu_sin",
    "hg_survival",
    "new_direction",
    "rayleigh_cdf_mu",
    "rayleigh_pdf_mu",
    "rayleigh_sample_mu",
    "rayleigh_sample_mu_sin",
]
