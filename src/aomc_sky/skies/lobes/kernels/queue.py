"""Photons of lobes wait in a queue of their lobe, over the blocks of a call, until there are enough for long loops.

A photon that is rejected waits at the front of its queue for its next trial, together with new ones.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import (
    ACCEPT,
    FOUR,
    LAST_TRIAL,
    LOBE_COLUMN,
    LOBE_QUEUE_SIZE,
    ONE,
    SCRATCH_PHOTONS,
    THREE,
    TWO,
    U32,
    U64,
    ZERO,
)
from aomc_sky.kernels.arithmetic.rng import later_words, philox_pair
from aomc_sky.kernels.cells.blocks import column, whole_vectors
from aomc_sky.kernels.jit import inlined, inner_no_refcount
from aomc_sky.skies.lobes.kernels.law import LINE_COLUMNS, PROPOSAL_COLUMNS, bin_of_rank, decision_by_rank

QUEUE_SIZE = np.uint64(LOBE_QUEUE_SIZE)
"""Photons of a full queue, whole vectors; the columns of one stay in the cache."""

OVERHANG = np.uint64(32)
"""So far beyond the end of a queue its ranks may be read, by vectors that do not begin at its front."""

AHEAD = np.uint64(16)
"""So many photons before it is written the memory of one is asked for."""

_PROPOSAL_COLUMNS = np.uint64(PROPOSAL_COLUMNS)
_LINE_COLUMNS = np.uint64(LINE_COLUMNS)


@inner_no_refcount
def photons_of_lobes(m, slot, lobes, photons):
    """Photons of a block whose slot lies in the span of the lobes, in `photons`; return how many.

    Few slots between the first lobe and the last are none, and a comparison costs less than a look at a table.
    """
    kinds = lobes[1][4]
    begin = np.int64(kinds[2])
    span = U64(np.int64(kinds[3]) - begin)
    n, j = ZERO, ZERO
    while j < m:
        photons[n] = j
        n += U64(U64(np.int64(slot[j]) - begin) < span)
        j += ONE
    return n


@inner_no_refcount
def append_photons(k, n, lo, photons, slot, rank, lobe_of_slot, queues):
    """Append photons k to n of `photons` to their queues; return the next one and the lobe of the queue that is full.

    The block begins at photon `lo` of the call.
    """
    size, at, ranks = queues[0], queues[2], queues[3]
    full = np.int64(-1)
    while k < n:
        j = photons[k]
        k += ONE
        lobe = lobe_of_slot[U64(slot[j])]
        if lobe < 0:
            continue
        one = U64(lobe)
        before = size[one]
        to = one * QUEUE_SIZE + before
        at[to], ranks[to] = U32(lo + j), rank[j]
        size[one] = before + ONE
        if before + ONE == QUEUE_SIZE:
            full = np.int64(lobe)
            break
    return k, full


@inlined
def bin_proposal(lobe, proposals):
    """The arguments of `bin_of_rank` after the rank, for a lobe of a band."""
    f, p = _PROPOSAL_COLUMNS * U64(lobe), _LINE_COLUMNS * U64(lobe)
    whole, lines = proposals
    return whole[f], whole[f + ONE], whole[f + TWO], whole[f + THREE], whole[f + FOUR], lines[p], lines[p + ONE]


@inner_no_refcount
def bins_by_rank(lobe, again, n, rank, bin0, proposals, at):
    """Bins of trial 0 of the photons of a queue from `again` on, of a lobe whose first bin is `bin0`."""
    before, each, rest, offset, bits, bins_per_photon, begin = bin_proposal(lobe, proposals)
    for k in range(again, again + whole_vectors(n - again)):
        at[k] = bin0 + bin_of_rank(U64(rank[k]), before, each, rest, offset, bits, bins_per_photon, begin)


@inner_no_refcount
def _words_by_rank(again, n, rank, shifts, steps, accept, first, second, third):
    shift_u, shift_v, step_u, step_v, shift, step = shifts[0], shifts[1], steps[0], steps[1], accept[0], accept[1]
    mix_key = accept[2]
    for k in range(again, again + whole_vectors(n - again)):
        r = U64(rank[k])
        first[k], second[k] = shift_u + r * step_u, shift_v + r * step_v
        third[k] = decision_by_rank(r, shift, step, mix_key)


@inner_no_refcount
def _words_by_philox(again, n, rank, key, band, first, second, third):
    for k in range(again, again + whole_vectors(n - again)):
        first[k], second[k] = philox_pair(key, U64(rank[k]), band, ZERO)
        third[k], _ = philox_pair(key, U64(rank[k]), band, ACCEPT)


@inner_no_refcount
def _later_words(n, rank, trial, key, band, first, second, third):
    for k in range(whole_vectors(n)):
        first[k], second[k], third[k] = later_words(key, U64(rank[k]), band, U64(trial[k]))


@inner_no_refcount
def words_of_photons(again, n, rank, trial, steps, key, band, jitter, first, second, third):
    """The three words of the n photons of a queue: a later trial of the first `again` ones, trial 0 of the others.

    `steps` begins with shifts, steps, those of the decision.
    """
    if again > ZERO:
        _later_words(again, rank, trial, key, band, first, second, third)
    if jitter == ZERO:
        _words_by_rank(again, n, rank, steps[0], steps[1], steps[2], first, second, third)
    else:
        _words_by_philox(again, n, rank, key, band, first, second, third)


@inner_no_refcount
def back_to_front(n, rejected, again, at, rank, trial):
    """Move n rejected photons to the front of their queue; return how many may try again.

    The first `again` photons of the queue have been rejected before.
    """
    left, i = ZERO, ZERO
    while i < n:
        k = rejected[i]
        t = (trial[k] if k < again else U32(0)) + U32(1)
        at[left], rank[left], trial[left] = at[k], rank[k], t
        left += U64(U64(t) < LAST_TRIAL)
        i += ONE
    return left


@inner_no_refcount
def lobe_queues(memory, rank, n_lobe):
    """Empty queues, and memory for the photons of a block, whose ranks are like `rank`; the rest of `memory`.

    Sizes, retries; photon, rank and trial of each place in a queue; photons of lobes in a block.
    """
    size, retries, rest = memory[:n_lobe], memory[n_lobe : TWO * n_lobe], memory[TWO * n_lobe :]
    room = n_lobe * QUEUE_SIZE + U64(LOBE_COLUMN)
    end = THREE * room + U64(SCRATCH_PHOTONS)
    memory[: TWO * n_lobe + TWO * room] = ZERO
    return (
        size,
        retries,
        column(rest, ZERO, room, U32(0)),
        column(rest, ONE, room, rank),
        column(rest, TWO, room, U32(0)),
        rest[THREE * room : end],
    ), rest[end:]
