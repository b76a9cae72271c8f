"""The laws inside a cell: six parameters and two uniform numbers become a travel direction.

Parameters of a cell, in the order of `Component.cell`. The first four depend on the zenith ring, the
last two on the azimuth column, so that a grid of 90 x 360 patches needs 90 + 360 entries, not 32 400.

================ ==================================================================================
law              h0, h1, h2, h3 | t0, t1
================ ==================================================================================
CELL_MU2         sin^2 at the near edge, growth of sin^2, cos^2 at the far edge, half the azimuth
                 width in quarter turns | sine, cosine of the centre azimuth
CELL_MU          1 - mu at the near edge, growth of 1 - mu, mu at the far edge, half width | the same
BEAM             as CELL_MU2 with no growth and no width
DISC             sine, cosine of the centre's zenith angle, sine, cosine of the radius | the same
DISC_AT_HORIZON  mu^2 at the upper rim, half width of the bounding azimuth range in quarter turns,
                 squared chord of the radius, centre's mu | the same
HG, GGX,         mean of mu, 0, mean of 1 / mu, 0 | 0, 1: for the books alone; photons come from `lobes.cells`
BECKMANN
================ ==================================================================================

mu^2 and sin^2 come from sums of positive terms, sin^2 = h0 + h1 u, cos^2 = h2 + h1 (1 - u): nothing
cancels next to the zenith or the horizon.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import ONE, ZERO
from aomc_sky.kernels.arithmetic.elementary import sincos_turned_any, unit
from aomc_sky.kernels.arithmetic.rng import philox_pair
from aomc_sky.kernels.jit import inner_reader

CELL_MU2 = 0
CELL_MU = 1
BEAM = 2
DISC = 3
DISC_AT_HORIZON = 4
PEREZ = 5
HG = 6
GGX = 7
BECKMANN = 8


@inner_reader
def from_mu2(h0, h1, h2, u, sine, cosine):
    """Travel direction for an azimuth, uniform in mu^2."""
    radius = np.sqrt(h0 + h1 * u)
    return -(radius * cosine), -(radius * sine), -np.sqrt(h2 + h1 * (type(u)(1) - u))


@inner_reader
def from_mu(h0, h1, h2, u, sine, cosine):
    """Travel direction for an azimuth, uniform in mu."""
    one = type(u)(1)
    mu = h2 + h1 * (one - u)
    radius = np.sqrt((h0 + h1 * u) * (one + mu))
    return -(radius * cosine), -(radius * sine), -mu


@inner_reader
def disc(h0, h1, h2, h3, t0, t1, u, v):
    """Travel direction of a uniform disc above the horizon, flux law.

    A disc of uniform radiance sends through the horizontal as its orthographic projection does,
    which is the inside of an ellipse (Nusselt): uniform there, and the height follows.
    """
    one, zero = type(u)(1), type(u)(0)
    s, c = sincos_turned_any(zero, one, one + one, v)
    root = np.sqrt(u)
    along = h2 * root * c
    across = h2 * root * s
    x = h3 * h0 + along * h1
    # 1 - x^2 - y^2 as a sum of squares: the height of the flat disc, and the bulge of the sphere on it
    height = h3 * h1 - along * h0
    mu = np.sqrt(height * height + h2 * h2 * (one - u))
    return -(x * t1 - across * t0), -(x * t0 + across * t1), -mu


@inner_reader
def disc_at_horizon(h0, h1, h2, h3, t0, t1, u, v, key, rank, band):
    """Travel direction of a uniform disc that the horizon cuts, flux law, by rejection.

    Proposals are uniform in mu^2 and azimuth over the rectangle around the visible part; at least
    60 % lie on the disc (measured in the tests). Trial 0 uses the placement's point, later ones
    draws 1, 2, ... of Philox.
    """
    one, zero = type(u)(1), type(u)(0)
    sin_z = np.sqrt(one - h3 * h3)
    trial = ZERO
    while True:
        mu2 = h0 * (one - u)
        mu = np.sqrt(mu2)
        far = np.sqrt(one - mu2)
        s, c = sincos_turned_any(zero, one, h1, v)
        dx = far * c - sin_z
        dy = far * s
        dz = mu - h3
        if dx * dx + dy * dy + dz * dz <= h2:
            return -(far * (c * t1 - s * t0)), -(far * (c * t0 + s * t1)), -mu
        trial += ONE
        a, b = philox_pair(key, rank, band, trial)
        u = unit(a, u)
        v = unit(b, v)
