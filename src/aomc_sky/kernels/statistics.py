"""Sums over the photons of a block in a fixed order, so that every machine prints the same digits."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.jit import kernel


@kernel
def block_sums(uz):
    """Sum of mu and of 1 / mu over a block, mu = -uz, in float64 and in the order of the photons."""
    mu_sum = 0.0
    inverse_sum = 0.0
    for j in range(uz.size):
        mu = -np.float64(uz[j])
        mu_sum += mu
        inverse_sum += 1.0 / mu
    return mu_sum, inverse_sum
