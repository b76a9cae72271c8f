"""From a plan to arrays of photons: which kernel makes them, and the tables it reads."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from aomc_sky.component import CellLaw, Law
from aomc_sky.emission.band_tables import (
    BandTable,
    CellWords,
    Rings,
    StreamWords,
    lobe_offset_words,
)
from aomc_sky.emission.kernels.hooks import QUEUE, REJECTION
from aomc_sky.emission.photons import number_columns
from aomc_sky.kernels.arithmetic.constants import ANY_WIDTH, IN_MU, NARROW, NUMBER_STEPS, on_cache_lines, scratch_words
from aomc_sky.kernels.backend import use_kernels
from aomc_sky.kernels.cells.laws import slope_words
from aomc_sky.plan.footprint import Footprint, FootprintShape
from aomc_sky.plan.laws import law_of
from aomc_sky.plan.options import Placement
from aomc_sky.plan.plan import Plan

T = TypeVar("T")

_CACHED_BANDS = 4
_OUTPUTS = ("ux", "uy", "uz", "patch")


class _BandCache:
    """Results for the last few bands, shared by threads; one thread prepares each."""

    def __init__(self) -> None:
        self._kept: dict[int, Any] = {}
        self._lock = threading.Lock()

    def get(self, band: int, prepare: Callable[[int], T]) -> T:
        """The result for a band."""
        prepared = self._kept.get(band)
        if prepared is None:
            with self._lock:
                if (prepared := self._kept.get(band)) is None:
                    prepared = prepare(band)
                    while len(self._kept) >= _CACHED_BANDS:
                        self._kept.pop(next(iter(self._kept)))
                    self._kept[band] = prepared
        return prepared


class _Scratch(threading.local):
    """Memory of each thread for kernels.

    Vector loops read stale values behind the last photon, so memory is kept per precision.
    """

    def __init__(self) -> None:
        self._words: dict[np.dtype, np.ndarray] = {}

    def words(self, n: int, precision: np.dtype) -> np.ndarray:
        """Memory of n words."""
        words = self._words.get(precision)
        if words is None or words.size != n:
            words = self._words[precision] = on_cache_lines(np.zeros(n, np.uint64))
        return words


_scratch = _Scratch()


class Emitter:
    """Fills arrays with the photons of a plan; compiled kernels and plain numpy give the same bits."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.dtype = np.dtype(plan.options["precision"])
        shape, size_x, size_y = plan.options["footprint"]
        self.footprint = Footprint(shape=FootprintShape(shape), size_x_m=size_x, size_y_m=size_y)
        self._streams, self._kernels, self._finders, self._falls, self._plain_slopes = (_BandCache() for _ in range(5))

    @property
    def has_positions(self) -> bool:
        """Whether photons have a position."""
        return self.footprint.shape is not FootprintShape.POINT

    def fill(self, band: int, start: int, arrays: dict[str, Any]) -> None:
        """Write the photons from `start` on into arrays `ux`, `uy`, `uz`, `patch`, `x`, `y` and `numbers` if there.

        Here and below `band` is a replicate band, and photons are counted from its first one; see `Plan`.
        """
        if use_kernels(arrays["ux"].size):
            self.fill_compiled(band, start, arrays)
        else:
            self.fill_plain(band, start, arrays)

    @cached_property
    def _words(self) -> CellWords:
        return CellWords.of(self.plan.arrays["cell"], self._rings.of_cell, self.dtype)

    @cached_property
    def _rings(self) -> Rings:
        return Rings.of(self.plan.arrays)

    @cached_property
    def _laws(self) -> dict[Law, CellLaw]:
        """The laws of the plan; no other slice is imported."""
        return {Law(number): law_of(Law(number)) for number in np.unique(self.plan.arrays["law"]).tolist()}

    @cached_property
    def _start_law(self) -> np.ndarray:
        """The law by which the photons of each cell start."""
        law = self.plan.arrays["law"]
        for number, of_slice in self._laws.items():
            if of_slice.starts_as is not None:
                law = np.where(law == number, np.int8(of_slice.starts_as), law)
        return law

    def _hook_tables(self, hook: str) -> Any:
        make = next((law.hook_tables for law in self._laws.values() if law.hook == hook), None)
        return None if make is None else make(self.plan.arrays)

    @cached_property
    def _rejection(self) -> Any:
        is_centre = self.plan.options["placement"] == Placement.CENTRE.value
        return None if is_centre else self._hook_tables(REJECTION)

    @cached_property
    def _queue(self) -> Any:
        return self._hook_tables(QUEUE)

    @cached_property
    def hooks(self) -> tuple[str, ...]:
        """Names of the hooks that the plan needs; see `kernels.hooks`."""
        tables = {REJECTION: self._rejection, QUEUE: self._queue}
        return tuple(hook for hook, table in tables.items() if table is not None)

    @cached_property
    def _cells(self) -> np.ndarray:
        return np.asfortranarray(self.plan.arrays["cell"].astype(self.dtype))

    def _slopes(self, band: int) -> np.ndarray | None:
        """Words of the slopes of all cells of a band, or None where the plan has none."""
        arrays = self.plan.arrays
        is_centre = self.plan.options["placement"] == Placement.CENTRE.value
        parts = {k: arrays[f"slope_{k}"] for k in range(len(self.plan.component_names)) if f"slope_{k}" in arrays}
        if is_centre or not parts:
            return None
        row, slope = int(arrays["row_of_band"][band % self.plan.n_bands]), np.zeros((self.plan.n_cells, 2))
        for k, of_component in parts.items():
            start, end = arrays["component_start"][k : k + 2]
            slope[start:end] = of_component[row if len(of_component) > 1 else 0]
        return slope_words(slope)

    def _lobe_steps(self, band: int) -> tuple[object, ...]:
        """Words for the first trials of the lobes of a band: the steps of the decision, `falls` with `paces`."""
        lobes, cumulative = self._queue, self.plan.arrays["cumulative"]
        assert lobes is not None
        prepare = lambda b: lobes.falls(cumulative[b], lobe_offset_words(self.plan, b, lobes.cell))  # noqa: E731
        return self._stream(band).accept, self._falls.get(band, prepare)

    def _stream(self, band: int) -> StreamWords:
        return self._streams.get(band, lambda b: StreamWords.of(self.plan, b, self._rings))

    def _tables(self, band: int) -> tuple[BandTable, tuple[object, ...], np.ndarray, Any, Any]:
        """Tables of a band with photons: the band, the search from rank to cell, the cells, Perez, lobes."""
        arrays, words, stream = self.plan.arrays, self._words, self._stream(band)
        hooks = self._rejection, self._queue, self._slopes(band)
        table = BandTable.of(arrays["cumulative"][band], self._start_law, words, *hooks)
        search = (table.cumulative, table.guide, table.guide_shift, table.place)
        perez = None if table.rejection is None else (*table.rejection, stream.accept)
        lobes = None if table.queue is None else (*table.queue, *self._lobe_steps(band))
        return table, search, words.with_turns(stream.turns), perez, lobes

    def _kernel(self, band: int) -> tuple[str, tuple[object, ...]]:
        """The name of the kernel that makes a band's photons, and its arguments after the outputs and the memory."""
        stream = self._stream(band)
        table, search, cells, perez, lobes = self._tables(band)
        is_common = table.is_common and not stream.jitter and perez is None and lobes is None
        if is_common and not stream.order_keys.size and table.has_long_runs:
            parameters = (cells, cells.view(self.dtype), table.main)
            return "emit_runs", (stream.shifts, stream.steps, *search, *parameters, table.cell_of_slot)
        laws = (table.main, None if is_common else table.law, table.one_disc, perez, lobes, table.slopes)
        return "emit", (np.uint64(table.n), *stream.arguments(), *search, cells, *laws, table.cell_of_slot)

    def _compiled(self, band: int) -> tuple[str, Callable[..., None], tuple[object, ...]]:
        """`_kernel` with its function. One thread binds it, because each of two would compile its own."""
        from aomc_sky.emission.kernels import emit

        name, arguments = self._kernel(band)
        return name, emit.emit_runs if name == "emit_runs" else emit.emit_with(*self.hooks), arguments

    def n_photons(self, band: int) -> int:
        """Photons launched in a band."""
        return int(self.plan.arrays["cumulative"][band, -1])

    @cached_property
    def _n_scratch(self) -> int:
        return scratch_words(0 if self._queue is None else self._queue.cell.size)

    def host_arguments(self, band: int) -> tuple[str, tuple[object, ...]]:
        """The name of the kernel of a band with photons, and its block for `next`: words of memory, then arguments."""
        name, arguments = self._kernel(band)
        return name, (np.uint64(0 if name == "emit_runs" else self._n_scratch), *arguments)

    def photon_arguments(self, band: int) -> tuple[object, ...]:
        """The arguments of `emission.kernels.sampler.photon_at` after the index, for a band with photons."""
        from aomc_sky.kernels.cells.order import split_order

        stream = self._stream(band)
        table, search, cells, perez, lobes = self._tables(band)
        order = None
        if stream.order_keys.size:
            order = tuple(np.array([table.n, *split_order(np.uint64(table.n or 1)), *stream.order_keys], np.uint64))
        _, *rest, jitter = stream.arguments()
        ways = (True if table.main == way else None for way in (IN_MU, ANY_WIDTH, NARROW))
        laws = (table.law if table.law.size else None, *ways, perez, lobes, table.slopes)
        return order, *rest, True if jitter else None, *search, cells, cells.view(self.dtype), *laws

    def number_arguments(self, band: int) -> tuple[object, ...]:
        """The last arguments of `kernels.numbers` for a band."""
        stream = self._stream(band)
        key, counter = stream.position_key, (stream.band, stream.jitter)
        return np.uint64(self.n_photons(band)), stream.order_keys, stream.number_shifts, NUMBER_STEPS, key, *counter

    def fill_compiled(self, band: int, start: int, arrays: dict[str, Any]) -> None:
        """As `fill`, by the compiled kernels."""
        _, kernel, arguments = self._kernels.get(band, self._compiled)
        memory = _scratch.words(self._n_scratch, self.dtype)
        kernel(np.uint64(start), *(arrays[output] for output in _OUTPUTS), memory, *arguments)
        if self.has_positions:
            from aomc_sky.emission.kernels import emit

            emit.positions(*self._position_arguments(band, np.uint64(start)), arrays["x"], arrays["y"])
        if arrays.get("numbers") is not None:
            from aomc_sky.emission.kernels.numbers import numbers_of_photons

            numbers_of_photons(np.uint64(start), *number_columns(arrays["numbers"]), *self.number_arguments(band))

    def _position_arguments(self, band: int, start: Any) -> tuple[object, ...]:
        stream, footprint = self._stream(band), self.footprint
        sizes = np.float64(footprint.size_x_m), np.float64(footprint.size_y_m)
        return footprint.shape is FootprintShape.CIRCLE, start, stream.position_key, stream.band, *sizes

    def fill_plain(self, band: int, start: int, arrays: dict[str, Any]) -> None:
        """As `fill`, in plain numpy."""
        from aomc_sky.emission.kernels import plain
        from aomc_sky.kernels.cells.order import slot_finder

        cumulative, stream = self.plan.arrays["cumulative"][band], self._stream(band)
        perez, lobes = self._rejection, self._queue
        plain.emit(  # type: ignore[call-arg]
            start,
            start + arrays["ux"].size,
            int(cumulative[-1]),
            *stream.arguments(),
            self._finders.get(band, lambda b: slot_finder(self.plan.arrays["cumulative"][b])),
            (self._rings.of_cell, stream.turns),
            self._cells,
            self.plan.arrays["law"],
            None if perez is None else (perez.word, perez.bound, perez.sky, stream.accept),
            None if lobes is None else (lobes.lobe, lobes.tables, *self._lobe_steps(band)),
            self._plain_slopes.get(band, self._slopes),
            *(arrays[name] for name in _OUTPUTS),
        )
        if self.has_positions:
            plain.positions(*self._position_arguments(band, start), arrays["x"], arrays["y"])  # type: ignore[call-arg]
        if arrays.get("numbers") is not None:
            plain.numbers(start, arrays["numbers"], *self.number_arguments(band))
