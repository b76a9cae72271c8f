"""The laws inside a cell: six parameters and two uniform numbers become a travel direction, for arrays and kernels.

Parameters of a cell, in the order of `Component.cell`. The first four depend on the zenith ring, the
last two on the azimuth column, so that a grid of 90 x 360 patches needs 90 + 360 entries, not 32 400.

================ ==================================================================================
law              h0, h1, h2, h3 | t0, t1
================ ==================================================================================
CELL_MU2         sin^2 at the near edge, growth of sin^2, cos^2 at the far edge, half the azimuth
                 width in quarter turns | sine, cosine of the centre azimuth
CELL_SLOPED      as CELL_MU2, at the place that `sloped` gives
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

from aomc_sky.kernels.arithmetic.constants import LAST_TRIAL, LOW32, S32, SLOPE_STEP, U64
from aomc_sky.kernels.arithmetic.elementary import (
    NARROW_HALF_WIDTH,
    sincos_turned_any,
    sincos_turned_narrow,
    unit,
)
from aomc_sky.kernels.arithmetic.rng import philox_pair
from aomc_sky.kernels.formula import by_width, formulas, kind_of, smaller

CELL_MU2, CELL_MU, BEAM, DISC, DISC_AT_HORIZON = DRAWN = range(5)
"""Numbers of the laws whose directions are in `direction_of` of the emission and `direction` of aomc_sky.h."""

HG, BECKMANN = 6, 8
"""The first and the last law of lobes, whose photons have their turn later."""


_below_one = by_width(lambda x: smaller(x, np.float32(1.0 - 2.0**-24)), lambda x: smaller(x, 1.0 - 2.0**-53))


def _on_slope(u, slope):
    """Root x in [0, 1) of (1 - slope) x + slope x^2 = u, the integral of 1 + slope (2x - 1).

    It is the root for a u within 2 ulp of 1 of the one given.
    """
    rest = kind_of(u)(1) - slope
    four = kind_of(u)(4)
    return _below_one((u + u) / (rest + np.sqrt(rest * rest + four * slope * u)))


def sloped(u, v, word):
    """The place (u, v) in a cell of `Law.CELL_SLOPED`; the halves of a word are its slopes in steps, 32 bits each.

    A slope of 0 leaves a number as it is.
    """
    kind = kind_of(u)
    step = kind(SLOPE_STEP)
    slope_u = kind(np.int32(word >> S32)) * step
    slope_v = kind(np.int32(word & LOW32)) * step
    return _on_slope(u, slope_u), _on_slope(v, slope_v)


def slope_words(slope):
    """The words of `sloped`, uint64 (n,), of slopes (n, 2)."""
    steps = np.rint(slope / SLOPE_STEP).astype(np.int64)
    return (steps[:, 0].astype(np.uint64) << S32) | (steps[:, 1].astype(np.uint64) & LOW32)


def from_mu2(h0, h1, h2, u, sine, cosine):
    """Travel direction for an azimuth, uniform in mu^2."""
    radius = np.sqrt(h0 + h1 * u)
    return -(radius * cosine), -(radius * sine), -np.sqrt(h2 + h1 * (kind_of(u)(1) - u))


def from_mu(h0, h1, h2, u, sine, cosine):
    """Travel direction for an azimuth, uniform in mu."""
    one = kind_of(u)(1)
    mu = h2 + h1 * (one - u)
    radius = np.sqrt((h0 + h1 * u) * (one + mu))
    return -(radius * cosine), -(radius * sine), -mu


def disc(h0, h1, h2, h3, t0, t1, u, v):
    """Travel direction of a uniform disc above the horizon, flux law.

    A disc of uniform radiance sends through the horizontal as its orthographic projection does,
    which is the inside of an ellipse (Nusselt): uniform there, and the height follows.
    """
    one, zero = kind_of(u)(1), kind_of(u)(0)
    s, c = sincos_turned_any(zero, one, one + one, v)
    root = np.sqrt(u)
    along = h2 * root * c
    across = h2 * root * s
    x = h3 * h0 + along * h1
    # 1 - x^2 - y^2 as a sum of squares: the height of the flat disc, and the bulge of the sphere on it
    height = h3 * h1 - along * h0
    mu = np.sqrt(height * height + h2 * h2 * (one - u))
    return -(x * t1 - across * t0), -(x * t0 + across * t1), -mu


def disc_at_horizon_trial(h0, h1, h2, h3, t0, t1, u, v):
    """Whether a point lies on a uniform disc that the horizon cuts, and its travel direction: flux law by rejection.

    Proposals are uniform in mu^2 and azimuth over the rectangle around the visible part; at least
    60 % lie on the disc (measured in the tests). Trial 0 uses the placement's point, later ones
    draws 1, 2, ... of Philox.
    """
    one, zero = kind_of(u)(1), kind_of(u)(0)
    sin_z = np.sqrt(one - h3 * h3)
    mu2 = h0 * (one - u)
    mu = np.sqrt(mu2)
    far = np.sqrt(one - mu2)
    s, c = sincos_turned_any(zero, one, h1, v)
    dx = far * c - sin_z
    dy = far * s
    dz = mu - h3
    return dx * dx + dy * dy + dz * dz <= h2, -(far * (c * t1 - s * t0)), -(far * (c * t0 + s * t1)), -mu


def discs(p, u, v, key, rank, band):
    """`CellLaw.directions` of DISC, and below those of the other laws."""
    return disc(*p, u, v)


def discs_at_horizon(p, u, v, key, rank, band):
    """By as many trials as each photon needs."""
    out = [np.empty_like(u) for _ in range(3)]
    left = np.arange(u.size)
    trial = 0
    while left.size and trial < LAST_TRIAL:
        hit, *directions = disc_at_horizon_trial(*(x[left] for x in p), u, v)
        for o, values in zip(out, directions, strict=True):
            o[left] = values
        left = left[~hit]
        trial += 1
        a, b = philox_pair(key, rank[left], U64(band), U64(trial))
        u, v = unit(a, u), unit(b, v)
    return out


def turned(t0, t1, half_width, v):
    """`sincos_turned_any` of arrays, by the short series alone where it is due everywhere."""
    if np.all(half_width <= v.dtype.type(NARROW_HALF_WIDTH)):
        return sincos_turned_narrow(t0, t1, half_width, v)
    return sincos_turned_any(t0, t1, half_width, v)


def in_mu2(p, u, v, key, rank, band):
    """Of CELL_MU2 and BEAM."""
    h0, h1, h2, half_width, t0, t1 = p
    return from_mu2(h0, h1, h2, u, *turned(t0, t1, half_width, v))


def in_mu(p, u, v, key, rank, band):
    """Of CELL_MU."""
    h0, h1, h2, half_width, t0, t1 = p
    return from_mu(h0, h1, h2, u, *turned(t0, t1, half_width, v))


def positions_in_cells(rank, jitter, key, band, shifts, steps, ring_offset, like):
    """The two uniform numbers of each photon; `ring_offset` is what its ring adds to the second one's word."""
    if jitter:
        a, b = philox_pair(key, rank, U64(band), U64(0))
    else:
        a, b = shifts[0] + rank * steps[0], shifts[1] + rank * steps[1] + ring_offset
    return unit(a, like), unit(b, like)


formulas(_on_slope, sloped, from_mu2, from_mu, disc, disc_at_horizon_trial)
