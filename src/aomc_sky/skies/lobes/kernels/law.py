"""Photons of the lobes of background skies: the formulas, for arrays and kernels, and the whole in plain numpy.

A photon falls into one of 2^m bins, all equally likely. It is uniform in the bin in b, the share of the lobe that is
farther from the axis, and in the azimuth psi. The module `aomc_sky.skies.lobes.envelope` says which direction that is.
The photon stays with the probability cos(zenith) / bound of the bin; if not, it falls anew into any bin. The law is
therefore exactly lobe times cosine. All numbers are float64 for both precisions.

In a later trial a photon has two words of Philox (placement key; rank, band, trial). The upper 42 bits of each are its
place. The first m bits of the first word are the bin, the rest is the place in b; the second word has the place in psi.
The lower 22 bits of both are the number that decides.

With placement r2, trial 0 does not cut the bin out of the R2 number: bins would be strips narrower than the distance of
its points, and filled unevenly. The bin comes from the rank instead (`bin_of_rank`). The n photons of a lobe are shared
out over its bins like those of a band over its cells: floor(n b / 2^m + offset) before bin b. Each seed, band and lobe
has one offset. The bins of a cell lie side by side, each with the same probability. The two fractions are thus the
place in the whole cell of that bin.

Tables:

ranges     for each lobe its first bin, m, its first cell and 0
bins       for each bin its cell, counted from the first of the lobe, in the upper 16 bits; below, its number there
shapes     for each lobe M row by row without the 0 in its last row, and g
envelopes  the cells of `aomc_sky.skies.lobes.envelope`
kinds      the ends of the lobes of kind "hg" and "ggx"; for kernels the first slot of a lobe and the end of the last
bin_proposals    for each lobe of a band the rank of its first photon, n // 2^m, n % 2^m, the offset in units of
                 2^-(m + OFFSET_BITS), and m
bins_per_photon  for each lobe of a band 2^m / n and the begin of the line of `bin_of_rank`
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import ACCEPT, LAST_TRIAL, ONE, S32, U32, U64
from aomc_sky.kernels.arithmetic.elementary import log_of_parts, sincos_turned, split_power, uniform_f64
from aomc_sky.kernels.arithmetic.rng import later_words, philox_pair
from aomc_sky.kernels.formula import formulas, select

LOBE_COLUMNS = 9
RANGE_COLUMNS = 4
CELL_COLUMNS = 8
PROPOSAL_COLUMNS = 5
LINE_COLUMNS = 2

OFFSET_BITS = 30
"""Of an offset, behind the m bits that the shares of bins have; with m up to 16 no product has more than 62 bits."""

LINE_MARGIN = 2.0**-30
"""More than the rounding of the line in `bin_of_rank`: four operations on numbers up to 2^16, 2^-35."""

# the sequence that decides is moved by half a hash of the rank, two odd multipliers (those of the generators of Steele
# and Vigna 2021)
_MIX_A = np.uint64(0xD1342543DE82EF95)
_MIX_B = np.uint64(0xAF251AF3B0F025B5)
_OFFSET = np.uint64(OFFSET_BITS)
_INV64 = 2.0**-64
_UPPER52 = np.uint64(0xFFFFFFFFFFFFF000)
_MIDDLE = np.uint64(0x800)


def bin_of_rank(rank, before, each, rest, offset, bits, bins_per_photon, begin):
    """The bin of trial 0 of a photon: the last one whose first photon is not after this one.

    A line says the bin or the one below it, whole numbers say which; nothing depends on how the line is rounded.
    """
    own = rank - before
    least = U64(
        np.int32(np.float64(np.int64(own)) * bins_per_photon + begin)
    )  # signed: of stale ranks it is a little below 0
    above = least + ONE
    return least + U64(own >= each * above + (((rest * above << _OFFSET) + offset) >> (bits + _OFFSET)))


def decision_by_rank(rank, shift, step, key):
    """The word that decides trial 0: the sequence moved by up to half a turn.

    Without the move the sequence repeats its values along lines of the lattice of places. Next to the horizon, where
    few photons stay, whole lines then stayed or went together.
    """
    x = (rank ^ key) * _MIX_A
    x = x ^ (x >> S32)
    return shift + rank * step + ((x * _MIX_B) >> ONE)


def shares(part, span, t, least_b, width, least_a, count):
    """Shares a and b of the lobe nearer to and farther from the axis, neither of them 0.

    `t` is the place in `span` bins of a cell from its bin `part` on, in (0, 1).
    """
    return least_a + width * ((count - span - part) + span * (1.0 - t)), least_b + width * (part + span * t)


def heights_hg(a, b, g):
    """R and Z of "hg"."""
    near, far, gb = 1.0 - g, 1.0 + g, g * b
    p = (near * near) * (a + a * gb)
    q = (far * far) * (b * (near + gb))
    return np.sqrt(4.0 * (p * q)), q - p


def world(radius, z, sine, cosine, m0, m1, m2, m3, m4, m5, m6, m8):
    """Travel direction: minus M (R cos, R sin, Z), normalised."""
    along, across = radius * cosine, radius * sine
    x = m0 * along + m1 * across + m2 * z
    y = m3 * along + m4 * across + m5 * z
    up = m6 * along + m8 * z
    scale = -1.0 / np.sqrt(x * x + y * y + up * up)
    return x * scale, y * scale, up * scale


def beckmann_radius(a, b):
    """Root of -log(b), from a where that is small."""
    m, power = split_power(b)
    is_small, is_near = m < 0.7071067811865476, a < 0.25
    f = select(is_near, -a, select(is_small, m + m, m) - 1.0)
    return np.sqrt(-log_of_parts(f, select(is_near, 0.0, power - select(is_small, 1.0, 0.0))))


def place_of(word, bits):
    """Uniform float64 in (0, 1) from a word without its first bits: the middles of 2^52 parts. See `unit`."""
    return np.float64(((word << bits) & _UPPER52) | _MIDDLE) * _INV64


def _heights(a, b, lobe, g, kinds):
    """R and Z of photons of the lobes `lobe` with the asymmetries g."""
    is_hg, is_beckmann = lobe < kinds[0], lobe >= kinds[1]
    radius, z = np.sqrt(a), np.sqrt(b)
    radius[is_hg], z[is_hg] = heights_hg(a[is_hg], b[is_hg], g[is_hg])
    radius[is_beckmann], z[is_beckmann] = beckmann_radius(a[is_beckmann], b[is_beckmann]), 1.0
    return radius, z


def _fallen(number, first, second, lobe, tables):
    """Directions and bounds of photons of the lobes `lobe` from two words each.

    `number` holds the bins in whose cells they lie. If it is None, the first word names the bin.
    """
    ranges, bins, shapes, envelopes, kinds = tables
    start, bits, cell, _ = ranges.reshape(-1, RANGE_COLUMNS)[lobe].T
    one = bins[(start + (first >> (U64(64) - bits) if number is None else number)).astype(np.int64)]
    at = cell.astype(np.int64) + (one >> U32(16))
    b0, width, a0, count, half, t0, t1, bound = envelopes.reshape(-1, CELL_COLUMNS)[at].T
    if number is None:
        part, span, t = (one & U32(0xFFFF)).astype(np.float64), 1.0, place_of(first, bits)
    else:
        part, span, t = 0.0, count, place_of(first, U64(0))
    shape = shapes.reshape(-1, LOBE_COLUMNS)[lobe].T
    radius, z = _heights(*shares(part, span, t, b0, width, a0, count), lobe, shape[8], kinds)
    return world(radius, z, *sincos_turned(t0, t1, half, uniform_f64(second)), *shape[:8]), bound


def place_lobes(lobe, tables, words, key, rank, band):
    """Directions (float64) of photons of the lobes `lobe`; `words` is what `lobe_words` gives."""
    out = tuple(np.empty(lobe.size) for _ in range(3))
    left = np.arange(lobe.size)
    number, first, second, word = words
    trial = 0
    while left.size:
        directions, bound = _fallen(number, first, second, lobe[left], tables)
        for values, new in zip(out, directions, strict=True):
            values[left] = new
        left = left[uniform_f64(word) * bound + directions[2] >= 0.0]
        trial += 1
        if trial >= LAST_TRIAL:
            break
        number, (first, second, word) = None, later_words(key, rank[left], U64(band), U64(trial))
    return out


def lobe_words(rank, lobe, proposals, shifts, steps, accept, key, band, jitter):
    """Bin and three words of trial 0 of photons of the lobes `lobe`: by rank (r2), or with `jitter` (philox) no bin.

    The keys are those of `keys` in the plan. Philox gives two words of a key and a counter (x low, x high, band, draw).
    The `shifts` come from (shift key; 0, 0, band, 0). The parts of `accept` are shift, ACCEPT_STEP and the key of the
    hash; the first and the last come from (shift key; 0, 0, band, 1). The offset in `proposals` comes from (shift key;
    cell of the lobe, 0, band, 2). `key` is the placement key.
    """
    if jitter:
        return (None, *philox_pair(key, rank, U64(band), U64(0)), philox_pair(key, rank, U64(band), ACCEPT)[0])
    before, each, rest, offset, bits = proposals[0].reshape(-1, PROPOSAL_COLUMNS)[lobe].T
    bins_per_photon, begin = proposals[1].reshape(-1, LINE_COLUMNS)[lobe].T
    number = bin_of_rank(rank, before, each, rest, offset, bits, bins_per_photon, begin)
    places = shifts[0] + rank * steps[0], shifts[1] + rank * steps[1]
    return number, *places, decision_by_rank(rank, accept[0], accept[1], accept[2])


formulas(bin_of_rank, decision_by_rank, shares, heights_hg, world, beckmann_radius, place_of, is_inlined=True)
