"""Photons of the Perez sky inside a cell: exact rejection, so that the emitted law does not depend on the cells.

A photon starts as one of CELL_MU2, uniform in mu^2 and azimuth. It is moved along the slope of the luminance
(`tilted`), and kept with the probability max(f, 0) J / bound. J is the factor by which the move divides the density. No
luminance is computed if the uniform number of the photon lies below the lower bound of f J over the bound. The number
of trial 0 is a sequence by rank like the place (or Philox, draw ACCEPT). Trial t takes all from draw t of Philox: 42
bits for each coordinate of the place, 44 for the number. The formulas serve arrays, here, and the loops of `reject`.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import ACCEPT, LAST_TRIAL, TILT_STEP, U64
from aomc_sky.kernels.arithmetic.elementary import uniform_f64, unit
from aomc_sky.kernels.arithmetic.rng import later_words, philox_pair
from aomc_sky.kernels.cells.laws import from_mu2, turned
from aomc_sky.kernels.formula import formulas, kind_of, smaller
from aomc_sky.skies.perez.kernels.law import SUN_VECTOR, A, B, C, D, E, first_factor, second_factor

_S10 = np.int32(10)
_S22 = np.int32(22)
_S52 = np.uint64(52)
_LOW12 = np.uint32(0xFFF)


def tilted(u, v, cell_word):
    """The place (u, v) after the move along the luminance's slope, and J.

    u' = u + k u (1 - u) has the derivative 1 + k (1 - 2u), for v alike; J is the product of both. The word of a cell
    holds its tilts in 10 bits each, then the 12 of `is_taken_at_once`.
    """
    kind = kind_of(u)
    one, step = kind(1), kind(TILT_STEP)
    both = np.int32(cell_word)
    tilt_u = kind(both >> _S22) * step
    tilt_v = kind(np.int32(both << _S10) >> _S22) * step
    rest_u, rest_v = one - u, one - v
    jacobian = (one + tilt_u * (rest_u - u)) * (one + tilt_v * (rest_v - v))
    return u * (one + tilt_u * rest_u), v * (one + tilt_v * rest_v), jacobian


def is_taken_at_once(word, cell_word):
    """Whether the lower bound of a cell takes the photon with this word."""
    return (word >> _S52) < U64(cell_word & _LOW12)


def measured(x, y, z, word, bound, sun_x, sun_y, sun_z):
    """sin^2 of half the angle to the sun, mu, and the uniform number times the bound of one photon."""
    x, y, z = np.float64(x), np.float64(y), np.float64(z)
    dx, dy, dz = x + sun_x, y + sun_y, z + sun_z
    return smaller(0.25 * ((dx * dx + dy * dy) + dz * dz), 1.0), -z, uniform_f64(word) * bound


def is_rejected(x, y, z, jacobian, word, bound, sky):
    """Whether the luminance refuses a photon; `reject` has its steps in loops of their own."""
    sun_x, sun_y, sun_z = sky[SUN_VECTOR], sky[SUN_VECTOR + 1], sky[SUN_VECTOR + 2]
    chord, mu, limit = measured(x, y, z, word, bound, sun_x, sun_y, sun_z)
    return limit >= luminance(mu, chord, sky) * np.float64(jacobian)


def luminance(mu, h, sky):
    """Relative luminance of the model for b <= 0; `sky` starts with a, b, c, d, e."""
    return first_factor(mu, sky[A], sky[B]) * second_factor(h, sky[C], sky[D], sky[E])


def accept_words(rank, steps, key, band, jitter):
    """The 64-bit uniform words that decide trial 0, in plain numpy."""
    return philox_pair(key, rank, U64(band), ACCEPT)[0] if jitter else steps[0] + rank * steps[1]


def place_perez(p, perez, u, v, word, key, rank, band):
    """Directions of photons of law PEREZ in plain numpy.

    `p`, the place (u, v), the words of trial 0 and ranks hold one entry per photon, like the first two of
    `perez`, (words of the cells, bounds, sky).
    """
    cell_word, bound, sky = perez
    directions, jacobian = _tilted_directions(p, u, v, cell_word)
    left = np.flatnonzero(~is_taken_at_once(word, cell_word))
    left = left[is_rejected(*(d[left] for d in directions), jacobian[left], word[left], bound[left], sky)]
    trial = 1
    while left.size and trial < LAST_TRIAL:
        first, second, word = later_words(key, rank[left], U64(band), U64(trial))
        u, v = unit(first, directions[0]), unit(second, directions[0])
        new, again = _tilted_directions(tuple(values[left] for values in p), u, v, cell_word[left])
        for values, replaced in zip(directions, new, strict=True):
            values[left] = replaced
        left = left[is_rejected(*new, again, word, bound[left], sky)]
        trial += 1
    return directions


def _tilted_directions(p, u, v, cell_word):
    """Directions of moved photons, and J."""
    h0, h1, h2, half_width, t0, t1 = p
    u, v, jacobian = tilted(u, v, cell_word)
    return from_mu2(h0, h1, h2, u, *turned(t0, t1, half_width, v)), jacobian


formulas(tilted, is_taken_at_once, measured, is_rejected, luminance)
