"""A band as the kernels read it, packed in one place for batches, for single photons and for blocks of hosts."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from aomc_sky.component import Law
from aomc_sky.emission.band_tables import PackedCells, StreamWords
from aomc_sky.kernels.arithmetic.constants import ANY_WIDTH, IN_MU, NARROW, QUARTER

_GUIDE_ENTRIES = 80_000
_SHORT = 2**32
_LONG_RUN = 8
_COMMON = (Law.CELL_MU2, Law.CELL_MU, Law.BEAM, Law.DISC, Law.DISC_AT_HORIZON)


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
    law: (
        np.ndarray | None
    )  #: of each slot, int8; empty if `azimuth_kernel` makes all; None if no hook and no jitter either
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
    azimuth_kernel, slot_law, one_disc = _azimuth_kernel(
        law[slots], counts[slots], cells.width if is_complete else cells.width[slots]
    )
    perez = None if perez_tables is None else (*perez_tables.for_slots(slots), stream.accept)
    lobes = None if lobe_tables is None else (*lobe_tables.for_slots(slots), *lobe_steps)
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
    entries = max(_GUIDE_ENTRIES, before.size)  # with fewer, ranks would walk over slots
    shift = max(0, ((n - 1) // entries).bit_length())
    first = -(-ends.astype(np.int64) >> shift)  # of each slot, the first of the guide's ranks in it or behind it
    guide = np.repeat(np.arange(ends.size - 1), np.diff(first))
    guide = guide.astype(np.uint16 if before.size < 2**16 else np.uint32)
    return np.concatenate([ends, sentinels]), guide, np.uint64(shift)


def _azimuth_kernel(
    slot_law: np.ndarray, count: np.ndarray, width: np.ndarray
) -> tuple[np.uint64, np.ndarray, np.int32]:
    """The loop that makes most slots, the law of each slot where they differ, the slot of a disc that alone differs."""
    main = _main_law(slot_law, count)
    is_main = slot_law == main
    is_same = is_main | ~np.isin(slot_law, _COMMON)  # a hook overwrites photons of other laws
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
