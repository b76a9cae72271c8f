"""The exact rejection of `perez_cells` in plain numpy, equal to the bit."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels import constants as k
from aomc_sky.kernels.plain import _from_mu2, philox, sincos_turned, unit
from aomc_sky.kernels.plain_perez_law import first_factor, second_factor

_U64 = np.uint64


def luminance(mu, h, sky):
    """Relative luminance of the model for b <= 0; `sky` starts with a, b, c, d, e."""
    a, b, c, d, e = sky[:5]
    return first_factor(mu, a, b) * second_factor(h, c, d, e)


def _is_rejected(directions, word, bound, sky):
    x, y, z = (values.astype(np.float64) for values in directions)
    dx, dy, dz = x + sky[8], y + sky[9], z + sky[10]
    chord = np.minimum(0.25 * ((dx * dx + dy * dy) + dz * dz), 1.0)
    limit = ((word >> _U64(11)).astype(np.float64) * 2.0**-53) * bound
    return limit >= luminance(-z, chord, sky)


def reject(directions, p, perez, jitter, key, rank, band):
    """Replace the directions that the luminance rejects; p, `perez` and the rest hold one entry per photon.

    `perez` is (threshold, bound, sky, steps) as in the kernel, its first two already looked up.
    """
    threshold, bound, sky, steps = perez
    word = philox(key, rank, band, int(k.ACCEPT))[0] if jitter else steps[0] + rank * steps[1]
    left = np.flatnonzero((word >> _U64(32)) >= threshold)
    left = left[_is_rejected([d[left] for d in directions], word[left], bound[left], sky)]
    trial = 1
    while left.size and trial < int(k.LAST_TRIAL):
        first, second = philox(key, rank[left], band, trial)
        word = (((first & k.REST_BITS) << k.REST_SHIFT) | (second & k.REST_BITS)) << k.ACCEPT_SHIFT
        kind = directions[0].dtype
        u, v = unit(first & k.PLACE_BITS, kind), unit(second & k.PLACE_BITS, kind)
        q = tuple(values[left] for values in p)
        new = _from_mu2(q, u, *sincos_turned(q[4], q[5], q[3], v))
        for values, replaced in zip(directions, new, strict=True):
            values[left] = replaced
        left = left[_is_rejected(new, word, bound[left], sky)]
        trial += 1
    return directions
