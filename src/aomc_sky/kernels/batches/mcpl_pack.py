"""Directions of photons packed into MCPL records (adaptive projection), equal to libmcpl to the bit."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import U32
from aomc_sky.kernels.jit import kernel


@kernel
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
