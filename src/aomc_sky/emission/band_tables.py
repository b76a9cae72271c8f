"""Tables of one waveband in the form the emission kernels read: the words of its random streams, and its cells.

Rings and CellWords hold the cells of a plan, BandTable and StreamWords those of one band. Further tables of a law are
in its slice (`CellLaw.hook_tables`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.component import Law
from aomc_sky.kernels.arithmetic.constants import (
    ACCEPT_STEP,
    ANY_WIDTH,
    IN_MU,
    NARROW,
    QUARTER,
    R2_STEP_U,
    R2_STEP_V,
    RING_STEP,
)
from aomc_sky.kernels.arithmetic.elementary import NARROW_HALF_WIDTH
from aomc_sky.plan.options import Order, Placement
from aomc_sky.plan.plan import Plan
from aomc_sky.plan.sampling.streams import philox_pair

_UPPER_HALF = np.uint64(0xFFFFFFFF00000000)
_GUIDE_ENTRIES = 80_000
_SHORT = 2**32
_LONG_RUN = 8
_COMMON = (Law.CELL_MU2, Law.CELL_MU, Law.BEAM, Law.DISC, Law.DISC_AT_HORIZON)


@dataclass(frozen=True, kw_only=True, slots=True)
class Rings:
    """The ring of each cell.

    A ring is a run of cells of one component with the same first three parameters: a zenith row of a grid. A beam, a
    disc and a lobe are a ring each. Rings count from 0 through all components.
    """

    of_cell: np.ndarray  #: number of each cell's ring, int64 (n_cell,)
    first: np.ndarray  #: first cell of each ring, int64 (n_ring,)

    @classmethod
    def of(cls, arrays: dict[str, np.ndarray]) -> Rings:
        """Find them in the arrays of a plan."""
        cell = arrays["cell"]
        starts = np.ones(cell.shape[0], dtype=bool)
        starts[1:] = np.any(cell[1:, :3] != cell[:-1, :3], axis=1)
        starts[arrays["component_start"][:-1]] = True
        return cls(of_cell=np.cumsum(starts) - 1, first=np.flatnonzero(starts))

    def turns(self, cumulative: np.ndarray) -> np.ndarray:
        """Turns of the rings, 64-bit fractions that are added to shift + rank x step of v; (n_ring,).

        Steps along a ring count from its first photon, and rings start a golden ratio apart. Photons of neighbouring
        rings are therefore never nearly in step. The array `cumulative` (n_cell + 1,) counts the band's photons before
        each cell.
        """
        number = np.arange(self.first.size, dtype=np.uint64)
        turns = number * RING_STEP - cumulative[self.first].astype(np.uint64) * R2_STEP_V
        return turns & _UPPER_HALF  # a turn beside float32 parameters has 32 bits


@dataclass(frozen=True, kw_only=True, slots=True)
class StreamWords:
    """Keys, shifts and steps of a band, in the form the kernels read."""

    #: 32-bit round keys of the shuffled order, uint64 (3,); empty leaves photons in the order of the cells.
    order_keys: np.ndarray
    #: Position in the cell as a 64-bit fraction: shift + rank x step, uint64 (2,) each. A step of 0 is the centre.
    shifts: np.ndarray
    steps: np.ndarray
    turns: np.ndarray  #: `Rings.turns`
    #: Shift and step of the words that decide the first trial of a rejection; the key of what moves them for lobes.
    accept: np.ndarray
    placement_key: np.uint64
    position_key: np.uint64
    #: Shifts of the numbers for hosts, uint64 (3,).
    number_shifts: np.ndarray
    #: The band's part of the Philox counters.
    band: np.uint64
    #: 1 where positions come from Philox instead, else 0.
    jitter: np.uint64

    @classmethod
    def of(cls, plan: Plan, band: int, rings: Rings) -> StreamWords:
        """Derive the words of a band from the keys and the counts of the plan."""
        order_key, shift_key, placement_key, position_key = (np.uint64(k) for k in plan.arrays["keys"])
        by_rank = plan.options["placement"] == Placement.R2.value
        shuffled = plan.options["order"] == Order.SHUFFLED.value
        half = np.full(2, 1 << 63, dtype=np.uint64)
        return cls(
            order_keys=_order_keys(order_key, band) if shuffled else np.empty(0, np.uint64),
            shifts=_band_words(shift_key, band) if by_rank else half,
            steps=np.array([R2_STEP_U, R2_STEP_V] if by_rank else [0, 0], dtype=np.uint64),
            turns=rings.turns(plan.arrays["cumulative"][band]) if by_rank else np.zeros(rings.first.size, np.uint64),
            accept=np.insert(_band_words(shift_key, band, 1), 1, ACCEPT_STEP),
            placement_key=placement_key,
            position_key=position_key,
            number_shifts=np.append(_band_words(shift_key, band, 3), _band_words(shift_key, band, 4)[:1]),
            band=np.uint64(band),
            jitter=np.uint64(plan.options["placement"] == Placement.PHILOX.value),
        )

    def arguments(self) -> tuple[object, ...]:
        """The first arguments of the emission after the range, in their order."""
        return self.order_keys, self.shifts, self.steps, self.placement_key, self.band, self.jitter


def lobe_offset_words(plan: Plan, band: int, cells: np.ndarray) -> np.ndarray:
    """A 64-bit word for each lobe of a band, addressed by its cell: Philox counter (cell, 0, band, 2)."""
    key = int(plan.arrays["keys"][1])
    return np.array([philox_pair(key, cell, band, 2)[0] for cell in cells.tolist()], dtype=np.uint64)


def _band_words(key: np.uint64, band: int, draw: int = 0) -> np.ndarray:
    """Two 64-bit words of a band from a stream: Philox counter (0, 0, band, draw)."""
    return np.array(philox_pair(int(key), 0, band, draw), dtype=np.uint64)


def _order_keys(key: np.uint64, band: int) -> np.ndarray:
    """Three 32-bit round keys of a band's order."""
    first, second = (int(w) for w in _band_words(key, band))
    return np.array([first & 0xFFFFFFFF, first >> 32, second & 0xFFFFFFFF], dtype=np.uint64)


@dataclass(frozen=True, kw_only=True, slots=True)
class CellWords:
    """Cell parameters as words: distinct heads and tails, and where each cell finds its own."""

    #: Heads (four floats each, the fourth the ring's turn), then tails, uint64; see `kernels.cells.blocks`.
    words: np.ndarray
    #: Position of each cell's head in the upper half, of its tail in the lower one; uint32 or uint64 (n_cell,).
    place: np.ndarray
    #: int8 (n_cell,): 0 for a cell without azimuth extent, 1 up to 3 degrees, 2 up to 90, 3 beyond.
    width: np.ndarray
    #: Number of each head's ring, int64 (n_head,).
    ring_of_head: np.ndarray
    #: Words of a head or a tail: 2 for float32, 4 for float64.
    per_row: int

    @classmethod
    def of(cls, cell: np.ndarray, ring_of_cell: np.ndarray, dtype: np.dtype) -> CellWords:
        """Build the words of all cells (n_cell, 6), whose rings have numbers (n_cell,), in one precision."""
        values = cell.astype(dtype)
        blank = np.zeros((cell.shape[0], 1), dtype)
        number = np.ascontiguousarray(ring_of_cell, dtype=np.int64).view(dtype).reshape(cell.shape[0], -1)
        heads, first, head_of_cell = _distinct_rows(np.hstack([values[:, :3], blank, number]))
        tails, _, tail_of_cell = _distinct_rows(np.hstack([values[:, 4:], values[:, 3:4], blank]))
        heads = np.ascontiguousarray(heads[:, :4])
        words = np.concatenate([heads.view(np.uint64).ravel(), tails.view(np.uint64).ravel()])
        per_row = heads.view(np.uint64).shape[1]
        head = head_of_cell.astype(np.uint64) * np.uint64(per_row)
        tail = (tail_of_cell.astype(np.uint64) + np.uint64(heads.shape[0])) * np.uint64(per_row)
        short = words.size < 2**16
        half_bits = np.uint64(16 if short else 32)
        place = ((head << half_bits) | tail).astype(np.uint32 if short else np.uint64)
        limits = np.array([0.0, NARROW_HALF_WIDTH, 0.5], dtype)
        width = np.searchsorted(limits, values[:, 3], side="left").astype(np.int8)
        return cls(words=words, place=place, width=width, ring_of_head=ring_of_cell[first], per_row=per_row)

    def with_turns(self, turns: np.ndarray) -> np.ndarray:
        """The words with the turn of each ring, uint64 (n_ring,), beside its other parameters."""
        words = self.words.copy()
        n_head = self.ring_of_head.size
        heads = words[: n_head * self.per_row].reshape(n_head, self.per_row)
        own = turns[self.ring_of_head]
        if self.per_row == 4:
            heads[:, 3] = own
        else:
            heads.view(np.uint32)[:, 3] = own >> np.uint64(32)
        return words


def _distinct_rows(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unique rows, first index, inverse."""
    rows = np.ascontiguousarray(rows)
    keys = rows.view(np.dtype((np.void, rows.dtype.itemsize * rows.shape[1]))).ravel()
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    return np.ascontiguousarray(rows[first]), first, inverse.ravel()


@dataclass(frozen=True, kw_only=True, slots=True)
class BandTable:
    """Arguments of `kernels.emit` for a band with `n` photons."""

    n: int
    cumulative: np.ndarray
    guide: np.ndarray
    guide_shift: np.uint64
    place: np.ndarray
    #: Law of each slot; empty where all go the main way.
    law: np.ndarray
    #: The slot of a disc, if all others go the main way; else -1.
    one_disc: np.int32
    #: The way of most slots, one of `constants.NARROW` and those after it.
    main: np.uint64
    #: Empty where slot = cell.
    cell_of_slot: np.ndarray
    #: Tables of the hooks for these slots.
    rejection: tuple[Any, ...] | None
    queue: tuple[Any, ...] | None
    slopes: np.ndarray | None  #: words of the slopes of these slots

    @property
    def is_common(self) -> bool:
        """Whether every slot is uniform in mu^2 before hooks, all cells narrow or none, at most 90 degrees wide."""
        return self.law.size == 0 and int(self.main) <= int(QUARTER) and self.slopes is None

    @property
    def has_long_runs(self) -> bool:
        """Whether cells hold enough photons for a loop of their own to pay."""
        return self.n >= _LONG_RUN * (self.cumulative.size - 3)

    @classmethod
    def of(
        cls,
        cumulative: np.ndarray,
        law: np.ndarray,
        cells: CellWords,
        rejection: Any,
        queue: Any,
        slopes: np.ndarray | None,
    ) -> BandTable:
        """Build the tables; photons of a cell start by its `law`, before a rejection or a queue (`hook_tables`)."""
        n = int(cumulative[-1])
        counts = np.diff(cumulative)
        slots = np.flatnonzero(counts)
        if 4 * slots.size >= 3 * law.size and np.all(law == law[0]):
            slots = np.arange(law.size)  # few cells are empty: stepping over them costs less than renaming
        slot_law = law[slots]
        short = n < _SHORT
        kind = np.dtype(np.uint32) if short else np.dtype(np.uint64)
        ends = np.append(cumulative[slots], n).astype(kind)
        sentinels = np.full(2, 2**32 - 1 if short else 2**64 - 1, kind)
        entries = max(_GUIDE_ENTRIES, slots.size)  # with fewer, ranks would walk over slots
        shift = max(0, ((n - 1) // entries).bit_length())
        guide = _guide(ends, shift).astype(np.uint16 if slots.size < 2**16 else np.uint32)
        ends = np.concatenate([ends, sentinels])
        main = _main_law(slot_law, counts[slots])
        is_main, is_complete = slot_law == main, slots.size == law.size
        is_same = is_main | ~np.isin(slot_law, _COMMON)  # what a queue makes is overwritten whatever it starts as
        others = np.flatnonzero(~(is_same | ((slot_law == Law.BEAM) & (main == Law.CELL_MU2))))
        has_one_disc = others.size == 1 and slot_law[others[0]] == Law.DISC
        width = cells.width if is_complete else cells.width[slots]
        widths = set(np.flatnonzero(np.bincount(width, weights=is_main)).tolist()) - {0}
        if main == Law.CELL_MU:
            way = IN_MU
        elif widths == {1}:
            way = NARROW
        else:
            way = QUARTER if widths <= {2} else ANY_WIDTH
        return cls(
            n=n,
            cumulative=ends,
            guide=guide,
            guide_shift=np.uint64(shift),
            place=cells.place if is_complete else cells.place[slots],
            law=slot_law if others.size else slot_law[:0],
            one_disc=np.int32(others[0] if has_one_disc else -1),
            main=way,
            cell_of_slot=slots[: 0 if is_complete else None].astype(np.int32),
            rejection=None if rejection is None else rejection.of_slots(slots),
            queue=None if queue is None else queue.of_slots(slots),
            slopes=None if slopes is None else slopes[slots],
        )


def _guide(ends: np.ndarray, shift: int) -> np.ndarray:
    """The slot that holds each 2^shift-th rank, from the ranks before each slot and their number at the end."""
    first = -(-ends.astype(np.int64) >> shift)  # of each slot, the first of these ranks in it or behind it
    return np.repeat(np.arange(ends.size - 1), np.diff(first))


def _main_law(slot_law: np.ndarray, count: np.ndarray) -> Law:
    """CELL_MU where it has more photons than CELL_MU2; beams count as cells of zero size."""
    is_in_mu = slot_law == Law.CELL_MU
    if not is_in_mu.any():
        return Law.CELL_MU2
    in_mu = int(count[is_in_mu].sum())
    in_mu2 = int(count[(slot_law == Law.CELL_MU2) | (slot_law == Law.BEAM)].sum())
    return Law.CELL_MU if in_mu > in_mu2 else Law.CELL_MU2
