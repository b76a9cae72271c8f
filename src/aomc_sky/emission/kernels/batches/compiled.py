"""Sums over the photons of a batch, in a fixed order, so that every machine prints the same digits; its MCPL records.

A record has its direction packed (adaptive projection), equal to libmcpl to the bit.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import U32
from aomc_sky.kernels.jit import reader


@reader
def block_sums(uz):
    """Return the sums of mu and of 1 / mu over a block, mu = -uz, in float64 and in the order of the photons."""
    mu_sum = 0.0
    inverse_sum = 0.0
    for j in range(uz.size):
        mu = -np.float64(uz[j])
        mu_sum += mu
        inverse_sum += 1.0 / mu
    return mu_sum, inverse_sum


@reader
def weighted_block_sums(uz, weight):
    """Return the sums of the weight w and of w / mu over a block, in float64 and in the order of the photons."""
    weight_sum = 0.0
    scalar_sum = 0.0
    for j in range(uz.size):
        w = np.float64(weight[j])
        weight_sum += w
        scalar_sum += w / -np.float64(uz[j])
    return weight_sum, scalar_sum


@reader
def pack(ux, uy, uz, cell, energy, flags, n_flagged, first, second, signed_energy, user_flags):
    """Write direction, energy [MeV] and user flags of photons into the fields of their records, arrays of any strides.

    `first` and `second` are the two components of the unit vector that are smaller in magnitude, with 1 / uz in the
    place of the largest one, whose sign the energy carries. libmcpl divides in float64 and rounds; a division in
    float32 gives the same bits, for 53 >= 2 x 24 + 2. All floats have one precision. `flags` are those of a photon of
    cell 0; photons of the cells from `n_flagged` on have the flags 0.
    """
    one, infinity = ux.dtype.type(1.0), ux.dtype.type(np.inf)
    for i in range(ux.size):
        x, y, z = ux[i], uy[i], uz[i]
        far_x, far_y = abs(x), abs(y)
        is_flat = abs(z) < max(far_x, far_y)
        is_x = is_flat and far_x >= far_y
        is_y = is_flat and far_x < far_y
        inverse = one / z if z != 0 else infinity  # without a sign, also of -0
        first[i] = inverse if is_x else x
        second[i] = inverse if is_y else y
        signed_energy[i] = np.copysign(energy, x if is_x else (y if is_y else z))
        user_flags[i] = flags + U32(cell[i]) if cell[i] < n_flagged else U32(0)
