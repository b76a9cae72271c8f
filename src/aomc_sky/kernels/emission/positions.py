"""Where photons enter the surface: uniform over a circle or a rectangle, from a stream of their own."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import U64, ZERO
from aomc_sky.kernels.arithmetic.elementary import sincos_turned_any, unit
from aomc_sky.kernels.arithmetic.rng import philox_pair
from aomc_sky.kernels.jit import kernel


@kernel
def circle_positions(start, key, band, radius, x, y):
    """Uniform over a circle around the origin: r = radius sqrt(u); start and key uint64."""
    for j in range(U64(x.size)):
        a, b = philox_pair(key, start + j, band, ZERO)
        u, v = unit(a, x[j]), unit(b, x[j])
        one = type(u)(1)
        sine, cosine = sincos_turned_any(one - one, one, one + one, v)
        r = type(u)(radius) * np.sqrt(u)
        x[j], y[j] = r * cosine, r * sine


@kernel
def rectangle_positions(start, key, band, size_x, size_y, x, y):
    """Uniform over a rectangle centred on the origin; start and key uint64."""
    for j in range(U64(x.size)):
        a, b = philox_pair(key, start + j, band, ZERO)
        half = type(x[j])(0.5)
        x[j] = type(x[j])(size_x) * (unit(a, x[j]) - half)
        y[j] = type(x[j])(size_y) * (unit(b, x[j]) - half)
