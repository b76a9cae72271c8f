"""From a plan to arrays of photons: which kernel makes them, and the tables it reads."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from aomc_sky.component import CellLaw, Law
from aomc_sky.emission.band import Band, PackedCells, Rings, StreamWords, lobe_offset_words, pack_band
from aomc_sky.emission.photons import number_columns
from aomc_sky.kernels.arithmetic.constants import on_cache_lines, scratch_words
from aomc_sky.kernels.backend import use_kernels
from aomc_sky.kernels.cells.laws import slope_words
from aomc_sky.plan.laws import law_of
from aomc_sky.plan.options import Footprint, FootprintShape, Placement
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
        self.has_positions = self.footprint.shape is not FootprintShape.POINT
        self._streams, self._kernels, self._finders, self._proposals, self._slope_words = (
            _BandCache() for _ in range(5)
        )

    def fill(self, band: int, start: int, arrays: dict[str, Any]) -> None:
        """Write the photons from `start` on into arrays `ux`, `uy`, `uz`, `patch`, `x`, `y` and `numbers` if there.

        Here and below `band` is a replicate band, and photons are counted from its first one; see `Plan`.
        """
        if use_kernels(arrays["ux"].size):
            self.fill_compiled(band, start, arrays)
        else:
            self.fill_plain(band, start, arrays)

    @cached_property
    def _packed_cells(self) -> PackedCells:
        return PackedCells.of(self._cell, self._rings.ring_of_cell, self.dtype)

    @cached_property
    def _rings(self) -> Rings:
        return Rings.of(self.plan.components)

    @cached_property
    def _laws(self) -> dict[Law, CellLaw]:
        """The laws of the plan; no other slice is imported."""
        return {component.law: law_of(component.law) for component in self.plan.components}

    @cached_property
    def _law(self) -> np.ndarray:
        """The law of each cell, int8 (n_cell,)."""
        return self.plan.law

    @cached_property
    def _cell(self) -> np.ndarray:
        """Parameters of all cells, (n_cell, 6)."""
        return np.concatenate([component.cell for component in self.plan.components])

    @cached_property
    def _start_law(self) -> np.ndarray:
        """The law by which the photons of each cell start."""
        law = self._law
        for number, cell_law in self._laws.items():
            if cell_law.starts_as is not None:
                law = np.where(law == number, np.int8(cell_law.starts_as), law)
        return law

    def _hook_tables(self, hook: str) -> Any:
        make = next((law.hook_tables for law in self._laws.values() if law.hook == hook), None)
        return None if make is None else make(self.plan.components)

    @cached_property
    def _perez_tables(self) -> Any:
        is_centre = self.plan.options["placement"] == Placement.CENTRE.value
        return None if is_centre else self._hook_tables("perez")

    @cached_property
    def _lobe_tables(self) -> Any:
        return self._hook_tables("lobes")

    @cached_property
    def hooks(self) -> tuple[str, ...]:
        """Names of the hooks that the plan needs; see `kernels.hooks`."""
        tables = {"perez": self._perez_tables, "lobes": self._lobe_tables}
        return tuple(hook for hook, table in tables.items() if table is not None)

    @cached_property
    def _cells(self) -> np.ndarray:
        return np.asfortranarray(self._cell.astype(self.dtype))

    def _slopes(self, band: int) -> np.ndarray | None:
        """Words of the slopes of all cells of a band, or None where the plan has none."""
        is_centre = self.plan.options["placement"] == Placement.CENTRE.value
        components = self.plan.components
        if is_centre or all(component.slope is None for component in components):
            return None
        row = self.plan.bands[band % self.plan.n_bands].row
        parts = [
            c.slope[row if len(c.slope) > 1 else 0] if c.slope is not None else np.zeros((c.n_cells, 2))
            for c in components
        ]
        return slope_words(np.concatenate(parts))

    def _lobe_steps(self, band: int) -> tuple[object, ...]:
        """Words for the first trials of the lobes of a band: the steps of the decision, and of `bin_proposals`."""
        lobes, cumulative = self._lobe_tables, self.plan.cumulative
        assert lobes is not None
        prepare = lambda b: lobes.bin_proposals(cumulative[b], lobe_offset_words(self.plan, b, lobes.cell))  # noqa: E731
        return self._stream(band).accept, self._proposals.get(band, prepare)

    def _stream(self, band: int) -> StreamWords:
        return self._streams.get(band, lambda b: StreamWords.of(self.plan, b, self._rings))

    def _packed(self, band: int) -> Band:
        """The band as the kernels read it."""
        lobe_steps = () if self._lobe_tables is None else self._lobe_steps(band)
        hooks = self._perez_tables, self._lobe_tables, lobe_steps, self._slopes(band)
        cumulative = self.plan.cumulative[band]
        return pack_band(cumulative, self._stream(band), self._start_law, self._packed_cells, self.dtype, *hooks)

    def _compiled(self, band: int) -> tuple[Callable[..., None], Band]:
        """The kernel of a band. One thread binds it, because each of two would compile its own."""
        from aomc_sky.emission.kernels import emit

        packed = self._packed(band)
        return emit.emit_runs if packed.has_long_runs else emit.emit_with(*self.hooks), packed

    def n_photons(self, band: int) -> int:
        """Photons launched in a band."""
        return int(self.plan.cumulative[band, -1])

    @cached_property
    def _n_scratch(self) -> int:
        return scratch_words(0 if self._lobe_tables is None else self._lobe_tables.cell.size)

    def host_arguments(self, band: int) -> tuple[str, tuple[object, ...]]:
        """The name of the kernel of a band with photons, and its block for `next`: words of memory, then arguments."""
        packed = self._packed(band)
        return (
            ("emit_runs", (np.uint64(0), *packed))
            if packed.has_long_runs
            else ("emit", (np.uint64(self._n_scratch), *packed))
        )

    def photon_arguments(self, band: int) -> tuple[object, ...]:
        """The arguments of `emission.kernels.sampler.photon_at` after the index, for a band with photons."""
        return self._packed(band).known()

    def patch_arguments(self, band: int) -> tuple[object, ...]:
        """The arguments of `emission.kernels.sampler.make_patch` for a band with photons."""
        packed = self._packed(band)
        order = tuple(packed.order) if packed.order.size else None
        cells = packed.cell_of_slot if packed.cell_of_slot.size else None
        return order, packed.cumulative, packed.guide, packed.guide_shift, cells

    def number_arguments(self, band: int) -> tuple[object, ...]:
        """The last arguments of `kernels.numbers` for a band."""
        stream = self._stream(band)
        key, counter = stream.position_key, (stream.band, stream.jitter)
        return stream.order, stream.number_shifts, stream.number_steps, key, *counter

    def fill_compiled(self, band: int, start: int, arrays: dict[str, Any]) -> None:
        """As `fill`, by the compiled kernels."""
        kernel, packed = self._kernels.get(band, self._compiled)
        memory = _scratch.words(self._n_scratch, self.dtype)
        kernel(np.uint64(start), *(arrays[output] for output in _OUTPUTS), memory, *packed)
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

        stream = self._stream(band)
        perez, lobes = self._perez_tables, self._lobe_tables
        plain.emit(
            start,
            start + arrays["ux"].size,
            stream.order,
            stream.shifts,
            stream.steps,
            stream.placement_key,
            stream.band,
            stream.jitter,
            self._finders.get(band, lambda b: slot_finder(self.plan.cumulative[b])),
            (self._rings.ring_of_cell, stream.ring_offsets),
            self._cells,
            self._law,
            None if perez is None else (perez.word, perez.bound, perez.sky, stream.accept),
            None if lobes is None else (lobes.lobe, lobes.tables, *self._lobe_steps(band)),
            self._slope_words.get(band, self._slopes),
            *(arrays[name] for name in _OUTPUTS),
        )
        if self.has_positions:
            plain.positions(*self._position_arguments(band, start), arrays["x"], arrays["y"])  # type: ignore[call-arg]
        if arrays.get("numbers") is not None:
            plain.numbers(start, arrays["numbers"], *self.number_arguments(band))
