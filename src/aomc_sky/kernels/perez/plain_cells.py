"""The exact rejection of `cells` in plain numpy, equal to the bit."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic import constants as k
from aomc_sky.kernels.arithmetic.constants import U64
from aomc_sky.kernels.arithmetic.plain import philox, sincos_turned, unit
from aomc_sky.kernels.cells.plain import from_mu2
from aomc_sky.kernels.perez.plain_law import first_factor, second_factor


def luminance(mu, h, sky):
    """Relative luminance of the model for b <= 0; `sky` starts with a, b, c, d, e."""
    a, b, c, d, e = sky[:5]
    return first_factor(mu, a, b) * second_factor(h, c, d, e)


def tilted(u, v, cell_word):
    """The place (u, v) after the move along the luminance's slope, and J, as in the kernel."""
    kind = u.dtype.type
    one, step = kind(1), kind(k.TILT_STEP)
    both = cell_word.view(np.int32)
    tilt_u = (both >> 22).astype(kind) * step
    tilt_v = ((both << 10) >> 22).astype(kind) * step
    rest_u, rest_v = one - u, one - v
    jacobian = (one + tilt_u * (rest_u - u)) * (one + tilt_v * (rest_v - v))
    return u * (one + tilt_u * rest_u), v * (one + tilt_v * rest_v), jacobian


def _is_rejected(directions, jacobian, word, bound, sky):
    x, y, z = (values.astype(np.float64) for values in directions)
    dx, dy, dz = x + sky[8], y + sky[9], z + sky[10]
    chord = np.minimum(0.25 * ((dx * dx + dy * dy) + dz * dz), 1.0)
    limit = ((word >> U64(11)).astype(np.float64) * 2.0**-53) * bound
    return limit >= luminance(-z, chord, sky) * jacobian.astype(np.float64)


def accept_words(rank, steps, key, band, jitter):
    """The 64-bit uniform words that decide trial 0."""
    return philox(key, rank, band, int(k.ACCEPT))[0] if jitter else steps[0] + rank * steps[1]


def place_perez(p, perez, u, v, word, key, rank, band):
    """Directions of photons of law PEREZ: moved along the slope of the luminance, and replaced where it rejects them.

    `p`, the place (u, v), the words of trial 0 and ranks hold one entry per photon, like the first two of
    `perez`, (words of the cells, bounds, sky).
    """
    cell_word, bound, sky = perez
    u, v, jacobian = tilted(u, v, cell_word)
    directions = from_mu2(p, u, *sincos_turned(p[4], p[5], p[3], v))
    left = np.flatnonzero((word >> U64(52)) >= (cell_word & np.uint32(0xFFF)))
    left = left[_is_rejected([d[left] for d in directions], jacobian[left], word[left], bound[left], sky)]
    trial = 1
    while left.size and trial < int(k.LAST_TRIAL):
        first, second = philox(key, rank[left], band, trial)
        word = (((first & k.REST_BITS) << k.REST_SHIFT) | (second & k.REST_BITS)) << k.ACCEPT_SHIFT
        kind = directions[0].dtype
        u, v, again = tilted(unit(first & k.PLACE_BITS, kind), unit(second & k.PLACE_BITS, kind), cell_word[left])
        q = tuple(values[left] for values in p)
        new = from_mu2(q, u, *sincos_turned(q[4], q[5], q[3], v))
        for values, replaced in zip(directions, new, strict=True):
            values[left] = replaced
        left = left[_is_rejected(new, again, word, bound[left], sky)]
        trial += 1
    return directions
