"""One scattering step for use inside an @njit function of a transport code.

The bits are those of `aomc_sky.scattering`; float32 is worked out in float64. Nothing is checked.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.jit import inner, shared
from aomc_sky.kernels.phase import scatter as plain

_cos_sin = inner(plain.cos_sin)
_turned = inner(plain.turned)


@shared
def new_direction(ux, uy, uz, one_minus_mu, sin_theta, azimuth_share):
    """Direction after scattering by theta; `azimuth_share` is uniform in [0, 1). The precision is that of ux."""
    c, s = _cos_sin(np.float64(azimuth_share))
    v, sine = np.float64(one_minus_mu), np.float64(sin_theta)
    x, y, z = _turned(np.float64(ux), np.float64(uy), np.float64(uz), v, sine, c, s)
    return type(ux)(x), type(ux)(y), type(ux)(z)
