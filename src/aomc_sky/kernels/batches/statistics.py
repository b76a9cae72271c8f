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


@kernel
def weighted_block_sums(uz, weight):
    """Sum of the weight w and of w / mu over a block, in float64 and in the order of the photons."""
    weight_sum = 0.0
    scalar_sum = 0.0
    for j in range(uz.size):
        w = np.float64(weight[j])
        weight_sum += w
        scalar_sum += w / -np.float64(uz[j])
    return weight_sum, scalar_sum
