"""The laws inside a cell: six parameters and two uniform numbers become a travel direction.

Parameters of a cell, in the order of `Component.cell`:

========== ============================================================================
law        p0, p1, p2, p3, p4, p5
========== ============================================================================
CELL_MU2   sin^2 at the near edge, growth of sin^2, cos^2 at the far edge, azimuth start
           (quadrant, rest in quarter turns), azimuth width in quarter turns
CELL_MU    1 - mu at the near edge, growth of 1 - mu, mu at the far edge, azimuth as above
BEAM       as CELL_MU2 with no growth and no width
DISC       sin and cos of the centre's zenith angle, sin of the radius, centre azimuth
           (quadrant, rest), cos of the radius
DISC_AT_.. mu^2 at the upper rim, half width of the bounding azimuth range in quarter turns,
           squared chord of the radius, centre azimuth (quadrant, rest), centre's mu
========== ============================================================================

mu^2 and sin^2 come from sums of positive terms: sin^2 = p0 + p1 u, cos^2 = p2 + p1 (1 - u); nothing
cancels next to the zenith or the horizon.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.elementary import sincos_azimuth, unit
from aomc_sky.kernels.jit import inner
from aomc_sky.kernels.rng import philox_pair

CELL_MU2 = 0
CELL_MU = 1
BEAM = 2
DISC = 3
DISC_AT_HORIZON = 4

_ZERO = np.uint64(0)
_ONE = np.uint64(1)


@inner
def cell_mu2(p0, p1, p2, p3, p4, p5, u, v):
    """Travel direction, uniform in mu^2 and azimuth."""
    one = type(u)(1)
    sine, cosine = sincos_azimuth(p3, p4, p5, v)
    radius = np.sqrt(p0 + p1 * u)
    return -(radius * cosine), -(radius * sine), -np.sqrt(p2 + p1 * (one - u))


@inner
def cell_mu(p0, p1, p2, p3, p4, p5, u, v):
    """Travel direction, uniform in mu and azimuth."""
    one = type(u)(1)
    sine, cosine = sincos_azimuth(p3, p4, p5, v)
    mu = p2 + p1 * (one - u)
    radius = np.sqrt((p0 + p1 * u) * (one + mu))
    return -(radius * cosine), -(radius * sine), -mu


@inner
def disc(p0, p1, p2, p3, p4, p5, u, v):
    """Travel direction of a uniform disc above the horizon, flux law.

    A disc of uniform radiance sends through the horizontal as its orthographic projection does,
    which is the inside of an ellipse (Nusselt): uniform there, and the height follows.
    """
    one, zero = type(u)(1), type(u)(0)
    s, c = sincos_azimuth(zero, zero, type(u)(4), v)
    root = np.sqrt(u)
    along = p2 * root * c
    across = p2 * root * s
    x = p5 * p0 + along * p1
    # 1 - x^2 - y^2 as a sum of squares: the height of the flat disc, and the bulge of the sphere on it
    height = p5 * p1 - along * p0
    mu = np.sqrt(height * height + p2 * p2 * (one - u))
    s0, c0 = sincos_azimuth(p3, p4, zero, zero)
    return -(x * c0 - across * s0), -(x * s0 + across * c0), -mu


@inner
def disc_at_horizon(p0, p1, p2, p3, p4, p5, u, v, key, rank, band):
    """Travel direction of a uniform disc that the horizon cuts, flux law, by rejection.

    Proposals are uniform in mu^2 and azimuth over the rectangle around the visible part; at least
    60 % lie on the disc (measured in the tests). Trial 0 uses the placement's point, later ones
    draws 1, 2, ... of Philox.
    """
    one, zero = type(u)(1), type(u)(0)
    sin_z = np.sqrt(one - p5 * p5)
    trial = _ZERO
    while True:
        mu2 = p0 * (one - u)
        mu = np.sqrt(mu2)
        far = np.sqrt(one - mu2)
        s, c = sincos_azimuth(zero, zero, p1, np.abs(v + v - one))
        s = -s if v + v < one else s
        dx = far * c - sin_z
        dy = far * s
        dz = mu - p5
        if dx * dx + dy * dy + dz * dz <= p2:
            s0, c0 = sincos_azimuth(p3, p4, zero, zero)
            return -(far * (c * c0 - s * s0)), -(far * (c * s0 + s * c0)), -mu
        trial += _ONE
        a, b = philox_pair(key, rank, band, trial)
        u = unit(a, u)
        v = unit(b, v)
