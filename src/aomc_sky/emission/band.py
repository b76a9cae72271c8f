"""A band as the kernels read it, packed in one place for batches, for single photons and for blocks of hosts.

`Rings` and `PackedCells` hold the cells of a plan, `StreamWords` the words of one band, `Band` all that kernels read.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.kernels.arithmetic.constants import (
    ACCEPT_STEP,
    ANY_WIDTH,
    IN_MU,
    NARROW,
    NUMBER_STEPS,
    QUARTER,
    R2_STEP_U,
    R2_STEP_V,
    RING_STEP,
)
from aomc_sky.kernels.arithmetic.elementary import NARROW_HALF_WIDTH
from aomc_sky.kernels.cells.laws import DRAWN
from aomc_sky.kernels.cells.order import split_order
from aomc_sky.plan.laws import law_of
from aomc_sky.plan.options import Order, Placement
from aomc_sky.plan.plan import Plan
from aomc_sky.plan.streams import philox_pair, photon_keys

_SHORT = 2**32
_MANY = 10_000
_LONG_RUN = 8
_UPPER_HALF = np.uint64(0xFFFFFFFF00000000)


@dataclass(frozen=True, kw_only=True, slots=True)
class Rings:
    """The ring of each cell.

    A ring is a run of cells of one component with the same first three parameters: a zenith row of a grid. A beam, a
    disc and a lobe are a ring each. Rings count from 0 through all components.
    """

    ring_of_cell: np.ndarray  #: number of each cell's ring, int64 (n_cell,)
    first: np.ndarray  #: first cell of each ring, int64 (n_ring,)

    @classmethod
    def of(cls, components: Sequence[Component]) -> Rings:
        """Find them in the cells of a plan."""
        parts = [np.any(c.cell[1:, :3] != c.cell[:-1, :3], axis=1) for c in components]
        starts = np.concatenate([np.append(True, part) for part in parts])
        return cls(ring_of_cell=np.cumsum(starts) - 1, first=np.flatnonzero(starts))

    def ring_offsets(self, cumulative: np.ndarray) -> np.ndarray:
        """Offsets of the rings, 64-bit fractions that are added to shift + rank x step of v; (n_ring,).

        Steps along a ring count from its first photon, and rings start a golden ratio apart. Photons of neighbouring
        rings are therefore never nearly in step. The array `cumulative` (n_cell + 1,) counts the band's photons before
        each cell.
        """
        number = np.arange(self.first.size, dtype=np.uint64)
        offsets = number * RING_STEP - cumulative[self.first].astype(np.uint64) * R2_STEP_V
        return offsets & _UPPER_HALF  # an offset beside float32 parameters has 32 bits


@dataclass(frozen=True, kw_only=True, slots=True)
class StreamWords:
    """Keys, shifts and steps of a band, in the form the kernels read."""

    #: Of the shuffled order uint64 (6,): the number of photons, `split_order` of it, three 32-bit round keys. Empty
    #: where photons have the order of the cells.
    order: np.ndarray
    #: Position in the cell as a 64-bit fraction: shift + rank x step, uint64 (2,) each. A step of 0 is the centre.
    shifts: np.ndarray
    steps: np.ndarray
    ring_offsets: np.ndarray  #: `Rings.ring_offsets`
    #: Shift and step of the words that decide the first trial of a rejection; the key of what moves them for lobes.
    accept: np.ndarray
    placement_key: np.uint64
    position_key: np.uint64
    #: Of the numbers for hosts, uint64 (4,): keys of the net and of its ranks, or three shifts of the lattice.
    number_shifts: np.ndarray
    #: Steps of the lattice of the numbers, uint64 (3,); None where they are of the net.
    number_steps: np.ndarray | None
    #: The band's part of the Philox counters.
    band: np.uint64
    #: 1 where positions come from Philox instead, else 0.
    jitter: np.uint64

    @classmethod
    def of(cls, plan: Plan, band: int, rings: Rings) -> StreamWords:
        """Derive the words of a band from the keys and the counts of the plan."""
        order_key, shift_key, placement_key, position_key = photon_keys(plan.seed, plan.options["method"])
        by_rank = plan.options["placement"] == Placement.R2.value
        shuffled = plan.options["order"] == Order.SHUFFLED.value
        half, no_offsets = np.full(2, 1 << 63, dtype=np.uint64), np.zeros(rings.first.size, np.uint64)
        return cls(
            order=_order_words(order_key, band, plan.cumulative[band, -1]) if shuffled else np.empty(0, np.uint64),
            shifts=_band_words(shift_key, band) if by_rank else half,
            steps=np.array([R2_STEP_U, R2_STEP_V] if by_rank else [0, 0], dtype=np.uint64),
            ring_offsets=rings.ring_offsets(plan.cumulative[band]) if by_rank else no_offsets,
            accept=np.insert(_band_words(shift_key, band, 1), 1, ACCEPT_STEP),
            placement_key=placement_key,
            position_key=position_key,
            number_shifts=np.append(_band_words(shift_key, band, 3), _band_words(shift_key, band, 4)),
            number_steps=NUMBER_STEPS if _is_one_lattice(plan, band) else None,
            band=np.uint64(band),
            jitter=np.uint64(plan.options["placement"] == Placement.PHILOX.value),
        )


def _is_one_lattice(plan: Plan, band: int) -> bool:
    """Whether directions are points of R2 alone, whose lattice the numbers go on with: each component is one cell.

    Such a lattice has no periods but its own, which are short in a band of many photons. Cells and bins give directions
    others.
    """
    is_one_cell = all(c.n_cells == 1 and law_of(c.law).hook != "lobes" for c in plan.components)
    return is_one_cell and int(plan.cumulative[band, -1]) >= _MANY


def lobe_offset_words(plan: Plan, band: int, cells: np.ndarray) -> np.ndarray:
    """A 64-bit word for each lobe of a band, addressed by its cell: Philox counter (cell, 0, band, 2)."""
    key = int(photon_keys(plan.seed, plan.options["method"])[1])
    return np.array([philox_pair(key, cell, band, 2)[0] for cell in cells.tolist()], dtype=np.uint64)


def _band_words(key: np.uint64, band: int, draw: int = 0) -> np.ndarray:
    """Two 64-bit words of a band from a stream: Philox counter (0, 0, band, draw)."""
    return np.array(philox_pair(int(key), 0, band, draw), dtype=np.uint64)


def _order_words(key: np.uint64, band: int, n: int) -> np.ndarray:
    first, second = (int(w) for w in _band_words(key, band))
    keys = first & 0xFFFFFFFF, first >> 32, second & 0xFFFFFFFF
    return np.array([n, *split_order(np.uint64(n or 1)), *keys], dtype=np.uint64)


@dataclass(frozen=True, kw_only=True, slots=True)
class PackedCells:
    """Cell parameters as words: distinct heads and tails, and where each cell finds its own."""

    #: Heads (four floats each, the fourth the ring's offset), then tails, uint64; see `kernels.cells.blocks`.
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
    def of(cls, cell: np.ndarray, ring_of_cell: np.ndarray, dtype: np.dtype) -> PackedCells:
        """Build the words of all cells (n_cell, 6), whose rings have numbers (n_cell,), in one precision."""
        values = cell.astype(dtype)
        blank = np.zeros((cell.shape[0], 1), dtype)
        number = np.ascontiguousarray(ring_of_cell, dtype=np.int64).view(dtype).reshape(cell.shape[0], -1)
        heads, first, head_of_cell = _distinct_rows(np.hstack([values[:, :3], blank, number]), 1)
        columns = int(np.bincount(np.bincount(ring_of_cell)).argmax())
        tails, _, tail_of_cell = _distinct_rows(np.hstack([values[:, 4:], values[:, 3:4], blank]), columns)
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

    def with_ring_offsets(self, ring_offsets: np.ndarray) -> np.ndarray:
        """The words with the offset of each ring, uint64 (n_ring,), beside its other parameters."""
        words = self.words.copy()
        n_head = self.ring_of_head.size
        heads = words[: n_head * self.per_row].reshape(n_head, self.per_row)
        own = ring_offsets[self.ring_of_head]
        if self.per_row == 4:
            heads[:, 3] = own
        else:
            heads.view(np.uint32)[:, 3] = own >> np.uint64(32)
        return words


def _distinct_rows(rows: np.ndarray, step: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unique rows, first index, inverse.

    A row equal to the one `step` before is not sorted: rings repeat columns, and columns a ring.
    """
    rows = np.ascontiguousarray(rows)
    words, n = rows.view(np.uint64), len(rows)
    is_new = np.ones(n, bool)
    is_new[step:] = np.any(words[step:] != words[:-step], axis=1)
    source = np.zeros(-(-n // step) * step, np.int64)
    source[:n] = np.where(is_new, np.arange(n), 0)
    source = np.maximum.accumulate(source.reshape(-1, step), axis=0).ravel()[:n]
    new = np.flatnonzero(is_new)
    keys = rows[new].view(np.dtype((np.void, rows.dtype.itemsize * rows.shape[1]))).ravel()
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    first = new[first]
    return np.ascontiguousarray(rows[first]), first, inverse.ravel()[np.cumsum(is_new)[source] - 1]


class Band(NamedTuple):
    """The parameters that all kernels of the emission share, in their order: ``kernel(..., *band)``.

    A *slot* is a cell that has photons. numba leaves out the code for what is None.
    """

    order: np.ndarray  #: `StreamWords.order`; empty leaves photons in the order of the cells
    shifts: np.ndarray  #: position in the cell as a 64-bit fraction: shift + rank x step (+ the ring's offset for v)
    steps: np.ndarray
    key: np.uint64  #: of Philox, for positions and for what a rejection draws
    number: np.uint64  #: of the band in the counters of Philox
    jitter: np.uint64  #: not 0: Philox gives the position in the cell
    cumulative: np.ndarray  #: ranks before each slot, and two sentinels, uint32 or uint64 (n_slot + 3,)
    guide: np.ndarray  #: slot of every 2^guide_shift-th rank
    guide_shift: np.uint64
    place: np.ndarray  #: of each slot: halves are the positions of the ring's and the column's parameters in `words`
    words: np.ndarray  #: `PackedCells.words` with the ring offsets of the band
    values: np.ndarray  #: `words` as floats of the precision
    #: Of each slot, int8; empty if `azimuth_kernel` makes all; None if there is no hook and no jitter either.
    law: np.ndarray | None
    perez: tuple[Any, ...] | None  #: tables of the hook `perez` for the slots, and the steps of its first trial
    #: Of the hook `lobes`: the lobe of each slot (int32, -1 for none), the tables of `skies.lobes.kernels.law`, the
    #: steps of the first trial, and `bin_proposals` with `bins_per_photon`.
    lobes: tuple[Any, ...] | None
    slopes: np.ndarray | None  #: words of `laws.sloped` of the slots
    azimuth_kernel: np.uint64  #: the loop that makes most slots: `constants.NARROW` or one after it
    one_disc: np.int32  #: the slot of a disc, if `azimuth_kernel` makes all others; else -1
    cell_of_slot: np.ndarray  #: int32; empty if slot = cell

    @property
    def has_long_runs(self) -> bool:
        """Whether photons are in the order of the cells, which hold enough of them for a loop of their own to pay."""
        n_slots = self.cumulative.size - 3
        return self.law is None and not self.order.size and int(self.cumulative[n_slots]) >= _LONG_RUN * n_slots

    def known(self) -> tuple[object, ...]:
        """The parameters of `sampler.photon_at`, which is compiled for this band alone.

        None stands for what is empty or 0, and flags for `azimuth_kernel`: the types tell the compiler.
        """
        order = tuple(self.order) if self.order.size else None
        law = self.law if self.law is not None and self.law.size else None
        kernels = (True if self.azimuth_kernel == kernel else None for kernel in (IN_MU, ANY_WIDTH, NARROW))
        start, search = self[1:5], self[6:12]  # shifts to number, cumulative to values
        return order, *start, self.jitter or None, *search, law, self.perez, self.lobes, self.slopes, *kernels


def pack_band(
    cumulative: np.ndarray,
    stream: StreamWords,
    law: np.ndarray,
    cells: PackedCells,
    dtype: np.dtype,
    perez_tables: Any,
    lobe_tables: Any,
    lobe_steps: tuple[object, ...],
    slopes: np.ndarray | None,
) -> Band:
    """Pack a band; photons of a cell start by its `law`, before a hook (`CellLaw.hook_tables`)."""
    n = int(cumulative[-1])
    counts = np.diff(cumulative)
    slots = np.flatnonzero(counts)
    if 4 * slots.size >= 3 * law.size and np.all(law == law[0]):
        slots = np.arange(law.size)  # few cells are empty: stepping over them costs less than renaming
    is_complete = slots.size == law.size
    ends, guide, shift = _search(cumulative[slots], n)
    width = cells.width if is_complete else cells.width[slots]
    perez = None if perez_tables is None else (*perez_tables.for_slots(slots), stream.accept)
    lobes = None if lobe_tables is None else (*lobe_tables.for_slots(slots), *lobe_steps)
    is_lobe = np.zeros(slots.size, bool) if lobes is None else lobes[0] >= 0
    azimuth_kernel, slot_law, one_disc = _azimuth_kernel(law[slots], counts[slots], width, is_lobe)
    is_common = not slot_law.size and int(azimuth_kernel) <= int(QUARTER) and slopes is None and not stream.jitter
    words = cells.with_ring_offsets(stream.ring_offsets)
    return Band(
        order=stream.order,
        shifts=stream.shifts,
        steps=stream.steps,
        key=stream.placement_key,
        number=stream.band,
        jitter=stream.jitter,
        cumulative=ends,
        guide=guide,
        guide_shift=shift,
        place=cells.place if is_complete else cells.place[slots],
        words=words,
        values=words.view(dtype),
        law=None if is_common and perez is None and lobes is None else slot_law,
        perez=perez,
        lobes=lobes,
        slopes=None if slopes is None else slopes[slots],
        azimuth_kernel=azimuth_kernel,
        one_disc=one_disc,
        cell_of_slot=slots[: 0 if is_complete else None].astype(np.int32),
    )


def _search(before: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray, np.uint64]:
    """The members `cumulative`, `guide` and `guide_shift` from the ranks before each slot and the number of photons."""
    short = n < _SHORT
    kind = np.dtype(np.uint32) if short else np.dtype(np.uint64)
    ends = np.append(before, n).astype(kind)
    sentinels = np.full(2, 2**32 - 1 if short else 2**64 - 1, kind)
    # with fewer, ranks would walk over slots; with more, the guide would not fit the near caches
    entries = max(1024, min(24 * before.size, 80_000), 5 * before.size)
    shift = max(0, ((n - 1) // entries).bit_length())
    first = -(-ends.astype(np.int64) >> shift)  # of each slot, the first of the guide's ranks in it or behind it
    guide = np.repeat(np.arange(ends.size - 1), np.diff(first))
    guide = guide.astype(np.uint16 if before.size < 2**16 else np.uint32)
    return np.concatenate([ends, sentinels]), guide, np.uint64(shift)


def _azimuth_kernel(
    slot_law: np.ndarray, count: np.ndarray, width: np.ndarray, is_lobe: np.ndarray
) -> tuple[np.uint64, np.ndarray, np.int32]:
    """The loop that makes most slots, the law of each slot where they differ, the slot of a disc that alone differs."""
    if not np.all(is_lobe | np.isin(slot_law, DRAWN)):
        raise NotImplementedError(f"no kernel draws the laws {set(slot_law[~is_lobe].tolist()) - set(DRAWN)}")
    main = _main_law(slot_law, count)
    is_main = slot_law == main
    is_same = is_main | is_lobe  # the hook overwrites photons of lobes
    others = np.flatnonzero(~(is_same | ((slot_law == Law.BEAM) & (main == Law.CELL_MU2))))
    has_one_disc = others.size == 1 and slot_law[others[0]] == Law.DISC
    widths = set(np.flatnonzero(np.bincount(width, weights=is_main)).tolist()) - {0}
    if main == Law.CELL_MU:
        kernel = IN_MU
    elif widths == {1}:
        kernel = NARROW
    else:
        kernel = QUARTER if widths <= {2} else ANY_WIDTH
    return kernel, slot_law if others.size else slot_law[:0], np.int32(others[0] if has_one_disc else -1)


def _main_law(slot_law: np.ndarray, count: np.ndarray) -> Law:
    """CELL_MU where it has more photons than CELL_MU2; beams count as cells of zero size."""
    is_in_mu = slot_law == Law.CELL_MU
    if not is_in_mu.any():
        return Law.CELL_MU2
    in_mu = int(count[is_in_mu].sum())
    in_mu2 = int(count[(slot_law == Law.CELL_MU2) | (slot_law == Law.BEAM)].sum())
    return Law.CELL_MU if in_mu > in_mu2 else Law.CELL_MU2
