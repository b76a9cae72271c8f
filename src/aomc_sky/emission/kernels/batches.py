"""Sums over the photons of a batch, in a fixed order that gives the same digits everywhere, and their MCPL records."""

from __future__ import annotations

import numpy as np

from aomc_sky.emission.kernels.plain import packed
from aomc_sky.kernels.arithmetic.constants import U32
from aomc_sky.kernels.jit import no_refcount


@no_refcount
def block_sums(uz):
    """Sums of mu and 1 / mu in the order of the photons, mu = -uz, in float64."""
    mu_sum = 0.0
    inverse_sum = 0.0
    for j in range(uz.size):
        mu = -np.float64(uz[j])
        mu_sum += mu
        inverse_sum += 1.0 / mu
    return mu_sum, inverse_sum


@no_refcount
def weighted_block_sums(uz, weight):
    """Sums of the weight w, of w mu and of w / mu, likewise."""
    weight_sum = 0.0
    mu_sum = 0.0
    scalar_sum = 0.0
    for j in range(uz.size):
        w = np.float64(weight[j])
        mu = -np.float64(uz[j])
        weight_sum += w
        mu_sum += w * mu
        scalar_sum += w / mu
    return weight_sum, mu_sum, scalar_sum


@no_refcount
def pack(ux, uy, uz, cell, energy, flags, n_flagged, first, second, signed_energy, user_flags):
    """Write `packed` and user flags into the fields of records: `flags` + cell, or 0 from the cell `n_flagged` on."""
    for i in range(ux.size):
        first[i], second[i], signed_energy[i] = packed(ux[i], uy[i], uz[i], energy)
        user_flags[i] = flags + U32(cell[i]) if cell[i] < n_flagged else U32(0)
