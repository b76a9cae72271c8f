"""The photon source: random access to every photon of a plan, without state."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from functools import cached_property
from typing import Any

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.grid import PatchGrid
from aomc_sky.kernels.constants import R2_STEP_U, R2_STEP_V
from aomc_sky.sampling.streams import philox_pair
from aomc_sky.source.band_table import BandTable, CellWords
from aomc_sky.source.footprint import Footprint, FootprintShape
from aomc_sky.source.moments import Moments, cell_moments, mean_moments
from aomc_sky.source.photons import PhotonBatch, batch_arrays
from aomc_sky.source.plan import Plan
from aomc_sky.source.sampling_options import Order, Placement
from aomc_sky.source.start_up import use_kernels

_CACHED_BANDS = 4


class PhotonSource:
    """Photon i of a band as a pure function of (plan, band, i).

    Parameters
    ----------
    plan : Plan
        The settled run, from `Scene.source` or from a run folder's plan.npz.

    Notes
    -----
    Any range, in any order, on any thread or machine gives the same bits. Instances hold no state
    besides caches, can be pickled, and may be shared between threads.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self._bands: dict[int, BandTable] = {}
        self._finders: tuple[int, Any] = (-1, None)
        self._streams: tuple[int, tuple[Any, ...]] = (-1, ())
        self._lock = threading.Lock()

    @classmethod
    def from_plan(cls, plan: Plan) -> PhotonSource:
        """Rebuild the source from a plan alone."""
        return cls(plan)

    def __getstate__(self) -> dict[str, Any]:
        return {"plan": self.plan}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(state["plan"])  # type: ignore[misc]

    def __repr__(self) -> str:
        return f"<PhotonSource: {self.n_bands} bands, {self.plan.n_cells} cells, {self.total} photons>"

    @property
    def n_bands(self) -> int:
        """Number of wavebands."""
        return self.plan.n_bands

    @property
    def counts(self) -> np.ndarray:
        """Photons of each cell, int64, shape (n_band, n_cell), cells of all components in order."""
        return np.diff(self.plan.arrays["cumulative"], axis=1)

    def n_photons(self, band: int) -> int:
        """Photons launched in a band."""
        return int(self.plan.arrays["cumulative"][self._band(band), -1])

    @property
    def total(self) -> int:
        """Photons launched in all bands."""
        return sum(self.n_photons(band) for band in range(self.n_bands))

    @property
    def components(self) -> tuple[Component, ...]:
        """Components in the order of their cells; strengths and masses share the sum 1 of each row."""
        plan, start = self.plan, self.plan.arrays["component_start"]
        parts = []
        for k, name in enumerate(plan.component_names):
            cells = slice(int(start[k]), int(start[k + 1]))
            mass = plan.arrays["mass"][:, cells]
            law = Law(int(plan.arrays["law"][cells.start]))
            cell = plan.arrays["cell"][cells]
            parts.append(
                Component(name=name, law=law, strength=mass.sum(axis=1), mass=mass, cell=cell, grid=plan.grid_of(k))
            )
        return tuple(parts)

    @property
    def grid(self) -> PatchGrid | None:
        """Patches of the first component that has any."""
        grids = (self.plan.grid_of(k) for k in range(len(self.plan.component_names)))
        return next((grid for grid in grids if grid is not None), None)

    @property
    def dtype(self) -> np.dtype:
        """Precision of directions, positions and weights."""
        return np.dtype(self.plan.options["precision"])

    @property
    def footprint(self) -> Footprint:
        """Where photons enter the surface."""
        shape, size_x, size_y = self.plan.options["footprint"]
        return Footprint(shape=FootprintShape(shape), size_x_m=size_x, size_y_m=size_y)

    @property
    def has_positions(self) -> bool:
        """Whether batches carry x and y."""
        return self.footprint.shape is not FootprintShape.POINT

    @property
    def has_weights(self) -> bool:
        """Whether batches carry weights."""
        return self.plan.arrays["weight"].size > 0

    def mass(self, band: int) -> np.ndarray:
        """Probability of each cell, float64, shape (n_cell,), sum 1."""
        return self.plan.arrays["mass"][self.plan.arrays["row_of_band"][self._band(band)]]

    def expected(self, band: int) -> np.ndarray:
        """Requested photons x probability of each cell, float64, shape (n_cell,)."""
        return float(self.plan.arrays["requested"][self._band(band)]) * self.mass(band)

    def exact_moments(self, band: int) -> Moments:
        """Exact means of mu and 1/mu of a band's photons, from the masses."""
        return mean_moments(self.mass(band), *self._cell_moments)

    @cached_property
    def _cell_moments(self) -> tuple[np.ndarray, np.ndarray]:
        return cell_moments(self.plan.arrays["law"], self.plan.arrays["cell"])

    @cached_property
    def _words(self) -> CellWords:
        return CellWords.of(self.plan.arrays["cell"], self.plan.arrays["law"], self.dtype)

    @cached_property
    def _weight(self) -> np.ndarray:
        return self.plan.arrays["weight"].astype(self.dtype)

    def _band(self, band: int) -> int:
        if not 0 <= band < self.n_bands:
            raise IndexError(f"band {band} does not exist; bands run from 0 to {self.n_bands - 1}")
        return int(band)

    def _table(self, band: int) -> BandTable:
        with self._lock:
            table = self._bands.get(band)
            if table is None:
                table = BandTable.of(self.plan.arrays["cumulative"][band], self.plan.arrays["law"], self._words)
                while len(self._bands) >= _CACHED_BANDS:
                    self._bands.pop(next(iter(self._bands)))
                self._bands[band] = table
            return table

    def photons(
        self, band: int = 0, start: int = 0, stop: int | None = None, *, out: PhotonBatch | None = None
    ) -> PhotonBatch:
        """Emit the photons [start, stop) of a band.

        Parameters
        ----------
        band : int
            Waveband. [0 to n_bands - 1]
        start, stop : int
            Range of photon indices; None is the end. [0 <= start <= stop <= n_photons(band)]
        out : PhotonBatch, optional
            Its arrays are filled and used by the result; at least stop - start entries each.

        Returns
        -------
        PhotonBatch
            Fresh arrays unless `out` is given. Directions have unit length within 3e-7 (float32) or
            6e-16 (float64).
        """
        n = self.n_photons(band)
        stop = n if stop is None else stop
        if not 0 <= start <= stop <= n:
            raise IndexError(f"photons {start} to {stop} do not exist; band {band} has photons 0 to {n}")
        arrays = batch_arrays(
            stop - start, self.dtype, out, with_positions=self.has_positions, with_weights=self.has_weights
        )
        if stop > start:
            self._emit(band, start, arrays)
        wavelength = float(self.plan.arrays["wavelength_nm"][band])
        return PhotonBatch(**arrays, band=band, start=start, wavelength_nm=wavelength)  # type: ignore[arg-type]

    def batches(self, band: int = 0, size: int = 65_536, out: PhotonBatch | None = None) -> Iterator[PhotonBatch]:
        """Yield all photons of a band in batches of `size`, the last one shorter; see `photons`."""
        if size < 1:
            raise ValueError(f"size must be at least 1, got {size}")
        n = self.n_photons(band)
        for start in range(0, n, size):
            yield self.photons(band, start, min(start + size, n), out=out)

    def _emit(self, band: int, start: int, arrays: dict[str, Any]) -> None:
        if use_kernels(arrays["ux"].size):
            self._emit_compiled(band, start, arrays)
        else:
            self._emit_plain(band, start, arrays)
        if self.has_weights:
            self._weigh(band, arrays)

    def _stream_arguments(self, band: int) -> tuple[Any, ...]:
        """Order keys or None, shifts, steps, placement key, band, and whether places come from Philox."""
        known, arguments = self._streams  # one assignment each way: threads see a pair that belongs together
        if known != band:
            arguments = self._new_stream_arguments(band)
            self._streams = (band, arguments)
        return arguments

    def _new_stream_arguments(self, band: int) -> tuple[Any, ...]:
        options = self.plan.options
        order_key, shift_key, place_key, _ = (np.uint64(k) for k in self.plan.arrays["keys"])
        by_rank = options["placement"] == Placement.R2.value
        steps = np.array([R2_STEP_U, R2_STEP_V] if by_rank else [0, 0], dtype=np.uint64)
        shifts = _band_words(shift_key, band) if by_rank else np.full(2, 1 << 63, dtype=np.uint64)
        order_keys = _order_keys(order_key, band) if options["order"] == Order.SHUFFLED.value else None
        jitter = True if options["placement"] == Placement.PHILOX.value else None
        return order_keys, shifts, steps, place_key, np.uint64(band), jitter

    def _emit_compiled(self, band: int, start: int, arrays: dict[str, Any]) -> None:
        from aomc_sky.kernels.emit import emit

        table, words, stream = self._table(band), self._words, self._stream_arguments(band)
        order_keys, shifts, steps, _, _, jitter = stream
        is_plain = True if table.is_plain and jitter is None else None
        if is_plain and order_keys is None and table.has_long_runs:
            self._emit_runs(table, start, shifts, steps, arrays)
        else:
            emit(
                np.uint64(start),
                np.uint64(table.n),
                *stream,
                table.cumulative,
                table.guide,
                table.guide_shift,
                table.place,
                words.half_bits,
                words.words,
                table.law,
                table.main_in_mu,
                table.main_is_wide,
                is_plain,
                table.cell_of_slot,
                *(arrays[name] for name in ("ux", "uy", "uz", "patch")),
            )
        if self.has_positions:
            from aomc_sky.kernels.positions import circle_positions, rectangle_positions

            key, footprint = np.uint64(self.plan.arrays["keys"][3]), self.footprint
            address = (np.uint64(start), key, np.uint64(band))
            if footprint.shape is FootprintShape.CIRCLE:
                circle_positions(*address, footprint.size_x_m / 2, arrays["x"], arrays["y"])
            else:
                sizes = (footprint.size_x_m, footprint.size_y_m)
                rectangle_positions(*address, *sizes, arrays["x"], arrays["y"])

    def _emit_runs(
        self, table: BandTable, start: int, shifts: np.ndarray, steps: np.ndarray, arrays: dict[str, Any]
    ) -> None:
        """The same photons as `emit` in the order of the cells, where all cells are plain ones."""
        from aomc_sky.kernels.emit_runs import emit_runs

        emit_runs(
            np.uint64(start),
            shifts,
            steps,
            table.cumulative,
            table.guide,
            table.guide_shift,
            table.place,
            self._words.half_bits,
            self._words.words.view(self.dtype),
            table.cell_of_slot,
            *(arrays[name] for name in ("ux", "uy", "uz", "patch")),
        )

    def _emit_plain(self, band: int, start: int, arrays: dict[str, Any]) -> None:
        from aomc_sky.kernels import plain

        plan, size = self.plan.arrays, arrays["ux"].size
        plain.emit(  # type: ignore[call-arg]
            start,
            start + size,
            self.n_photons(band),
            *self._stream_arguments(band),
            self._finder(band),
            self._cells,
            plan["law"],
            *(arrays[name] for name in ("ux", "uy", "uz", "patch")),
        )
        if self.has_positions:
            footprint, key = self.footprint, np.uint64(plan["keys"][3])
            is_circle = footprint.shape is FootprintShape.CIRCLE
            sizes = (footprint.size_x_m, footprint.size_y_m)
            plain.positions(is_circle, start, key, band, *sizes, arrays["x"], arrays["y"])

    @cached_property
    def _cells(self) -> np.ndarray:
        return np.asfortranarray(self.plan.arrays["cell"].astype(self.dtype))

    def _finder(self, band: int) -> Any:
        from aomc_sky.kernels.plain import slot_finder

        with self._lock:
            if self._finders[0] != band:
                self._finders = (band, slot_finder(self.plan.arrays["cumulative"][band]))
            return self._finders[1]

    def _weigh(self, band: int, arrays: dict[str, np.ndarray]) -> None:
        row = self.plan.arrays["row_of_band"][band]
        weight = arrays["weight"]
        np.take(self._weight[row], arrays["patch"], out=weight)
        law = self.plan.arrays["law"]
        if np.any(law == Law.CELL_MU):
            in_mu = (law == Law.CELL_MU)[arrays["patch"]]
            np.multiply(weight, -arrays["uz"], out=weight, where=in_mu)


def _band_words(key: np.uint64, band: int) -> np.ndarray:
    """Two 64-bit words of a band from a stream: Philox counter (0, 0, band, 0)."""
    return np.array(philox_pair(int(key), 0, band, 0), dtype=np.uint64)


def _order_keys(key: np.uint64, band: int) -> np.ndarray:
    """Three 32-bit round keys of a band's order."""
    first, second = (int(w) for w in _band_words(key, band))
    return np.array([first & 0xFFFFFFFF, first >> 32, second & 0xFFFFFFFF], dtype=np.uint64)
