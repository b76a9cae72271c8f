"""The photon source: random access to every photon of a plan, without state."""

from __future__ import annotations

import heapq
import operator
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

import aomc_sky
from aomc_sky.component import Component
from aomc_sky.emission.emitter import Emitter
from aomc_sky.emission.irradiance import Moments, cell_moments, mean_moments, moments_of_rows
from aomc_sky.emission.photons import MAX_NUMBERS, Arrays, Photon, PhotonBatch, batch_arrays
from aomc_sky.errors import UsageError, require_kind, require_switch
from aomc_sky.float_mode import in_default_mode, require_default
from aomc_sky.grid import PatchGrid
from aomc_sky.kernels.backend import announce_photons
from aomc_sky.plan.options import Footprint
from aomc_sky.plan.plan import Plan
from aomc_sky.whole_number import as_index, as_index_within

if TYPE_CHECKING:
    from aomc_sky.emission.host import NumbaSampler

_BLOCK = 2**20
"""Photons that are made in one piece, a few milliseconds."""


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

    Examples
    --------
    >>> source = sky.Scene(
    ...     wavebands=[440.0, 550.0], n_photons=1000, components="uniform"
    ... ).source(seed=1)
    >>> everything, part = (
    ...     source.photons(band=1),
    ...     source.photons(band=1, start=500, stop=510),
    ... )
    >>> np.array_equal(everything.ux[500:510], part.ux)
    True
    """

    def __init__(self, plan: Plan) -> None:
        require_kind(plan, Plan, "sky.PhotonSource(sky.Plan.load('plan.npz'))")
        self.plan = plan
        self._n_bands = plan.n_bands
        self._emitter = Emitter(plan)
        self._stokes_of_row: dict[int, np.ndarray] = {}  # q and u of those that were asked for, float32 (2, n_cell)
        self._weight_of_row: dict[int, np.ndarray] = {}  # in the precision of the source, (n_cell,)

    @classmethod
    @in_default_mode
    def from_plan(cls, plan: Plan) -> PhotonSource:
        """Rebuild the source from a plan alone.

        Raises
        ------
        InputFileError
            E952 to E955: no photons can be made from such a plan.
        """
        return cls(plan)

    def __getstate__(self) -> dict[str, Any]:
        return {"plan": self.plan}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(state["plan"])  # type: ignore[misc]

    def __repr__(self) -> str:
        return f"<PhotonSource: {self.n_bands} bands, {self.plan.n_cells} cells, {self.total} photons>"

    def _repr_html_(self) -> str:
        from aomc_sky.emission.notebook import MOST_ROWS, html

        nm = self.plan.wavelength_nm.tolist()
        rows = [
            (band, f"{nm[band]:g}", self.n_photons(band), f"{self.exact_moments(band).mean_mu:.6f}")
            for band in range(min(self.n_bands, MOST_ROWS))
        ]
        head = ("band", "nm", "photons", "mean cosine")
        bands = range(min(self.n_bands, 3))
        return html(repr(self)[1:-1], head, rows, self.n_bands, lambda: aomc_sky.plot(self, bands=bands, size_px=640))

    @property
    def n_bands(self) -> int:
        """Number of wavebands."""
        return self._n_bands

    @property
    def counts(self) -> np.ndarray:
        """Photons of each cell, int64, shape (n_band, n_cell), cells of all components in order."""
        counts = np.diff(self.plan.cumulative, axis=1)
        return counts.reshape(self.replicates, self.n_bands, -1).sum(axis=0) if self.replicates > 1 else counts

    def n_photons(self, band: int) -> int:
        """Photons launched in a band."""
        return self.launched[self._band(band)]

    @cached_property
    def launched(self) -> tuple[int, ...]:
        """Photons launched in each band."""
        return tuple(self._first[:, -1].tolist())

    @cached_property
    def replicates(self) -> int:
        """Independent randomisations that share the photons of each band, one after the other."""
        return self.plan.replicates

    def replicate_range(self, band: int, replicate: int) -> tuple[int, int]:
        """Photons [start, stop) of a band that make one replicate.

        Parameters
        ----------
        band : int
            Waveband. [0 to n_bands - 1]
        replicate : int
            Its number. [0 to replicates - 1]
        """
        replicate = _integer(replicate, "replicate")
        if not 0 <= replicate < self.replicates:
            raise IndexError(f"replicate {replicate} does not exist; they run from 0 to {self.replicates - 1}")
        first = self._first[self._band(band)]
        return int(first[replicate]), int(first[replicate + 1])

    def replicate_counts(self, band: int) -> np.ndarray:
        """Photons of each cell in each replicate of a band, int64, shape (replicates, n_cell)."""
        return np.diff(self.plan.cumulative[self._band(band) :: self.n_bands], axis=1)

    def replicate_parts(self, band: int, start: int, stop: int) -> list[tuple[int, int, int]]:
        """Split photons [start, stop) of a band where replicates begin.

        Returns
        -------
        list of (replicate, start, stop)
            Indices of photons in the band; empty parts are left out.
        """
        start, stop = _integer(start, "start"), _integer(stop, "stop")
        if self.replicates == 1:
            return [(0, start, stop)] if stop > start else []
        first = self._first[self._band(band)]
        inner = range(int(np.searchsorted(first, start, "right")) - 1, int(np.searchsorted(first, stop, "left")))
        return [(r, max(start, int(first[r])), min(stop, int(first[r + 1]))) for r in inner if stop > start]

    @property
    def total(self) -> int:
        """Photons launched in all bands."""
        return sum(self.launched)

    def irradiance(self, band: int = 0) -> dict[str, float] | None:
        """Irradiance of each component on a horizontal plane, by name, or None if it is unknown. [W m-2 nm-1]"""
        absolute = self.plan.bands[self._band(band)].irradiance_W_m2_nm
        return None if absolute is None else dict(zip(self.plan.component_names, absolute, strict=True))

    def horizon_loss(self, band: int = 0) -> float:
        """Share of the lobes' light that comes from below the horizon and sends no photons. [0 to 1]"""
        return self.plan.bands[self._band(band)].horizon_loss

    @property
    def components(self) -> tuple[Component, ...]:
        """Components in the order of their cells; strengths and masses share the sum 1 of each row."""
        return self.plan.components

    def components_of(self, band: int) -> tuple[Component, ...]:
        """The components of a band, with one row of everything."""
        row = self.plan.bands[self._band(band)].row
        return tuple(component.of_row(row) for component in self.components)

    @property
    def bands_differ_inside_cells(self) -> bool:
        """Whether photons lie in cells in another way in each band."""
        return any(component.slope is not None and len(component.slope) > 1 for component in self.components)

    @property
    def grid(self) -> PatchGrid | Any:  # as `Scene.irradiance`
        """Patches of the first component that has any, or None."""
        return next((component.grid for component in self.components if component.grid is not None), None)

    @cached_property
    def dtype(self) -> np.dtype:
        """Precision of directions, positions and weights."""
        return self._emitter.dtype

    @property
    def footprint(self) -> Footprint:
        """Area of the surface through which photons enter."""
        return self._emitter.footprint

    @cached_property
    def has_positions(self) -> bool:
        """Whether batches carry x and y."""
        return self._emitter.has_positions

    @cached_property
    def has_weights(self) -> bool:
        """Whether batches carry weights."""
        return self.has_bias or any(component.weight is not None for component in self.components)

    @property
    def has_bias(self) -> bool:
        """Whether photons are shared out otherwise than light."""
        return self.plan.bias is not None

    @cached_property
    def has_polarisation(self) -> bool:
        """Whether batches carry q and u."""
        return any(component.stokes is not None for component in self.components)

    def stokes(self, band: int = 0) -> np.ndarray:
        """Q/I and U/I of the light of each cell of a band, float64 (n_cell, 2); 0 where it is not polarised.

        In the meridian plane of the photon, as docs/conventions.md has it: the rows by `PhotonBatch.patch`. The mean of
        a cell is weighted by flux.
        """
        stokes = self.plan.stokes(self._band(band))
        return np.zeros((self.plan.n_cells, 2)) if stokes is None else stokes

    def mass(self, band: int) -> np.ndarray:
        """Share of the light of each cell, float64, shape (n_cell,), sum 1."""
        return self.plan.mass(self._band(band))

    def launch(self, band: int) -> np.ndarray:
        """Share of the photons of each cell, float64, shape (n_cell,), sum 1: that of the light without a bias."""
        return self.plan.launch(self._band(band))

    def component_of(self, patch: ArrayLike) -> np.ndarray:
        """Number of the component of cells, int64, shape of `patch`: an index of `components`.

        Parameters
        ----------
        patch : array_like, int
            Cells, as `PhotonBatch.patch` has them. [0 to n_cell - 1]
        """
        cells = np.asarray(patch)
        if cells.dtype.kind not in "iu":
            raise UsageError(f"patch: cells have whole numbers, got an array of {cells.dtype}")
        if cells.size and not (cells.min() >= 0 and cells.max() < self.plan.n_cells):
            raise IndexError(f"cells run from 0 to {self.plan.n_cells - 1}, got {cells.min()} to {cells.max()}")
        return np.searchsorted(self.plan.component_start, cells, side="right") - 1

    def weights(self, band: int) -> np.ndarray:
        """Weight of the photons of each cell, float64, shape (n_cell,): its light over its photons, 1 without a bias.

        Where `weights=True` gives photons that are launched by solid angle a weight, `PhotonBatch.weight` alone has it.
        """
        band = self._band(band)
        weight = None if self.plan.bias is None else self.plan.weight(band)
        return np.ones(self.plan.n_cells) if weight is None else weight

    def effective_photons(self, band: int) -> float:
        """As many independent photons of weight 1 would have the scatter of the weights: (sum w)^2 / sum w^2."""
        band = self._band(band)
        if self.plan.bias is None:
            return float(self.n_photons(band))
        counts, weight = self.counts[band], self.weights(band)
        squares = float(np.sum(counts * weight**2))
        return float(np.sum(counts * weight)) ** 2 / squares if squares else 0.0

    def expected(self, band: int) -> np.ndarray:
        """Requested photons x share of the photons of each cell, float64, shape (n_cell,)."""
        return float(self.plan.bands[self._band(band)].requested) * self.launch(band)

    def exact_moments(self, band: int) -> Moments:
        """Exact means of mu and 1/mu of a band's light, from the masses."""
        return mean_moments(self.mass(band), *self.cell_moments(band))

    def moments_of(self, bands: Sequence[int]) -> list[Moments]:
        """`exact_moments` of several bands; bands of one sky share theirs."""
        if self.bands_differ_inside_cells:
            return [self.exact_moments(band) for band in bands]
        rows = [self.plan.bands[band].row for band in bands]
        band_of_row = dict(zip(rows, bands, strict=True))
        moments = moments_of_rows(self.plan.masses(band_of_row.values()), *self._cell_moments)
        of_row = dict(zip(band_of_row, moments, strict=True))
        return [of_row[row] for row in rows]

    def cell_moments(self, band: int) -> tuple[np.ndarray, np.ndarray]:
        """Mean of mu and of 1 / mu over each cell of a band, (n_cell,) each; see `emission.irradiance.cell_moments`."""
        components = self.components_of(band)
        return cell_moments(components) if self.bands_differ_inside_cells else self._cell_moments

    @cached_property
    def _cell_moments(self) -> tuple[np.ndarray, np.ndarray]:
        return cell_moments(self.components)

    @cached_property
    def _first(self) -> np.ndarray:
        """First photon of each replicate in its band, and the band's photons last, (n_band, replicates + 1)."""
        launched = self.plan.cumulative[:, -1].reshape(self.replicates, self.n_bands)
        return np.vstack([np.zeros_like(launched[:1]), np.cumsum(launched, axis=0)]).T

    @cached_property
    def _has_mu(self) -> np.ndarray | None:
        """Whether the weights of each cell have a factor mu; None where none has."""
        has_mu = self.plan.weight_has_mu
        return has_mu if has_mu.any() else None

    def _band(self, band: int) -> int:
        band = _integer(band, "band")
        if not 0 <= band < self.n_bands:
            raise IndexError(f"band {band} does not exist; bands run from 0 to {self.n_bands - 1}")
        return band

    def photons(
        self,
        band: int = 0,
        start: int = 0,
        stop: int | None = None,
        *,
        out: PhotonBatch | None = None,
        numbers: int = 0,
    ) -> PhotonBatch:
        """Emit the photons [start, stop) of a band.

        Numbers are for the transport's first choices in a photon's life: the first free path, scattering angle and
        azimuth. They are as even as the directions and go with them: each is uniform in [0, 1), and so are several, and
        several with the direction. They depend on the rank of the photon in patch order and leave its direction as it
        is. With Philox placement they are independent; see the page of the methods.

        Parameters
        ----------
        band : int
            Waveband. [0 to n_bands - 1]
        start, stop : int
            Range of photon indices; None is the end. [0 <= start <= stop <= n_photons(band)]
        out : PhotonBatch, optional
            Its arrays are filled and used by the result; at least stop - start entries each.
        numbers : int
            How many numbers each photon carries. [0 to 3]

        Returns
        -------
        PhotonBatch
            Fresh arrays unless `out` is given. Directions have unit length within 3.5e-7 (float32) or
            8.5e-16 (float64).

        Notes
        -----
        Fresh arrays of many million photons take several times as long as batches: the operating system clears new
        memory page by page, which takes longer than to fill it. `out`, and `batches`, use memory that is there.

        Raises
        ------
        IndexError
            A band or photons that do not exist.
        UsageError
            A band, start or stop that is no whole number: a boolean, a float, text; numbers outside 0 to 3.
        """
        band = self._band(band)
        n = self.launched[band]
        start, stop = _integer(start, "start"), n if stop is None else _integer(stop, "stop")
        if not 0 <= start <= stop <= n:
            raise IndexError(f"photons {start} to {stop} do not exist; band {band} has photons 0 to {n}")
        return self._filled(band, start, self._arrays(stop - start, out, _checked_numbers(numbers)))

    def batches(
        self, band: int = 0, size: int = 65_536, out: PhotonBatch | None = None, *, numbers: int = 0
    ) -> Iterator[PhotonBatch]:
        """Yield all photons of a band in batches of `size`, the last one shorter; see `photons`."""
        band, size, numbers = self._band(band), _integer(size, "size"), _checked_numbers(numbers)
        if size < 1:
            raise ValueError(f"size must be at least 1, got {size}")
        n = self.n_photons(band)
        reused = None if out is None else self._arrays(min(size, n), out, numbers)
        for start in range(0, n, size):
            length = min(size, n - start)
            arrays = self._arrays(length, None, numbers) if reused is None else _entries(reused, slice(length))
            yield self._filled(band, start, arrays)

    def one_by_one(self) -> Iterator[Photon]:
        """Yield all photons of all wavebands one at a time, wavebands interleaved in the ratio of their photons.

        For codes that ask for the next particle. Any first part of it has all wavebands in their shares, each within
        one photon; every waveband's photons come in order. Cost: 2 to 6 us a photon; `batches` is a hundred times as
        fast.
        """

        def photons_of_band(band: int) -> Iterator[tuple[float, Photon]]:
            n = self.n_photons(band)
            for batch in self.batches(band, 4096):
                yield from (((photon.index_in_band + 0.5) / n, photon) for photon in batch)

        bands = (photons_of_band(band) for band in range(self.n_bands))
        return (photon for _, photon in heapq.merge(*bands, key=operator.itemgetter(0)))

    def weights_for(self, scene: Any, batch: PhotonBatch, band: int = 0, *, absolute: bool = False) -> np.ndarray:
        """Weights of a batch's photons under another sky: one run of transport holds the answer for every sky.

        The mean over all photons of the run of weight x tally is the tally under the diffuse light of `scene`. The
        tally must be an unweighted one: the weights of a bias are in these already. They follow `Scene.radiance` in the
        direction of each photon, so the patches of the run make no error. Best is a run of the mean of the skies that
        are wanted: its error is 1.1 to 1.3 times that of a run of its own.

        Parameters
        ----------
        scene : Scene
            The other sky, without a beam.
        batch : PhotonBatch
            Photons of this source.
        band : int
            Waveband of `scene`. [0 to n_bands - 1]
        absolute : bool
            In W m-2 nm-1, for a scene whose irradiance is known.

        Returns
        -------
        ndarray, float64, shape (n,)
            0 for photons of a beam. Their mean over the run is 1, or with `absolute` the irradiance of the sky.

        Raises
        ------
        UsageError
            A scene with a beam; photons by solid angle or in the middle of patches; light where the run has no photons;
            fewer than 1000 effective photons.
        """
        from aomc_sky.emission.sky_weights import sky_weights

        if not hasattr(scene, "row_of_band"):
            raise UsageError(f"expected a Scene, got {type(scene).__name__}")
        if not isinstance(batch, PhotonBatch):
            raise UsageError(f"expected a PhotonBatch, got {type(batch).__name__}")
        band = as_index_within(band, "band", 0, scene.wavebands.n_bands - 1)
        return sky_weights(self, scene, batch, band, absolute=absolute)

    def cell_irradiances(self, band: int) -> list[np.ndarray]:
        """Irradiance of the cells of each component: W m-2 nm-1, or shares of all light where that is not known."""
        parts = np.split(self.mass(band), self.plan.component_start[1:-1])
        absolute = self.irradiance(band)
        if absolute is None:
            return parts
        totals = [absolute[name] for name in self.plan.component_names]
        lit = [part.sum() > 0 for part in parts]
        return [part * (t / part.sum()) if is_lit else part for part, t, is_lit in zip(parts, totals, lit, strict=True)]

    def numba_sampler(
        self, band: int = 0, *, numbers: int = 0, weighted: bool = False, replicate: int | None = None
    ) -> NumbaSampler:
        """Return the photons of a band as jitted functions for your own `@njit` loop; see `NumbaSampler`.

        Each photon carries `numbers` further numbers, 0 to 3; see `photons`. The photons of a source with a bias have
        weights: `weighted` says that the loop counts photon i with `weights[patch(i)]`. Of a source with replicates
        the sampler has one, whose photons count from its first.

        Raises
        ------
        UsageError
            The photons have weights and the loop does not know; weights of photons by solid angle, which cells do not
            have; replicates of which none is named; numba's compiler is off.
        """
        from aomc_sky.emission.host import NumbaSampler

        require_default("a sampler inside a numba loop")
        require_switch(weighted, "weighted")
        how: dict[str, Any] = {"weighted": weighted, "replicate": replicate}
        return NumbaSampler(self._emitter, self._band(band), _checked_numbers(numbers), **how)

    @in_default_mode
    def to_bytes(self) -> bytes:
        """Return the source as one block of bytes for ``aomc_sky.h``, with which any code makes its photons.

        The bytes are those of `aomc_sky.write_source`: for an extension module, a message to other processes, a
        resource of a library.
        """
        from aomc_sky.emission.source_file import source_bytes

        return source_bytes(self._emitter)

    def _arrays(self, n: int, out: PhotonBatch | None, numbers: int) -> Arrays:
        has = {"with_positions": self.has_positions, "with_weights": self.has_weights}
        has["with_stokes"] = self.has_polarisation
        return batch_arrays(n, self.dtype, out, **has, n_numbers=numbers)

    @in_default_mode
    def _filled(self, band: int, start: int, arrays: Arrays) -> PhotonBatch:
        """The photons from `start` on, as many as the arrays hold; between two blocks Ctrl-C is answered."""
        n = arrays["ux"].size
        if n > _BLOCK:
            announce_photons(n)
        for lo in range(0, n, _BLOCK):
            part = arrays if n <= _BLOCK else _entries(arrays, slice(lo, lo + _BLOCK))
            self._emit(band, start + lo, part)
            if self.has_weights:
                self._weigh(band, part)
            if self.has_polarisation:
                self._polarise(band, part)
        wavelength = self.plan.bands[band].wavelength_nm
        return PhotonBatch(**arrays, band=band, start=start, wavelength_nm=wavelength)

    def _emit(self, band: int, start: int, arrays: Arrays) -> None:
        if self.replicates == 1:
            self._emitter.fill(band, start, arrays)
            return
        for replicate, begin, end in self.replicate_parts(band, start, start + arrays["ux"].size):
            views = _entries(arrays, slice(begin - start, end - start))
            self._emitter.fill(replicate * self.n_bands + band, begin - self.replicate_range(band, replicate)[0], views)

    def _polarise(self, band: int, arrays: Arrays) -> None:
        row = self.plan.bands[band].row
        if (columns := self._stokes_of_row.get(row)) is None:
            columns = self._stokes_of_row[row] = np.ascontiguousarray(self.stokes(band).T, np.float32)
        for name, column in zip("qu", columns, strict=True):
            np.take(column, arrays["patch"], out=arrays[name])

    def _weigh(self, band: int, arrays: dict[str, Any]) -> None:
        weight, row = arrays["weight"], self.plan.bands[band].row
        if (of_cell := self._weight_of_row.get(row)) is None:
            of_cell = self._weight_of_row[row] = np.asarray(self.plan.weight(band)).astype(self.dtype)
        np.take(of_cell, arrays["patch"], out=weight)
        if self._has_mu is not None:
            np.multiply(weight, -arrays["uz"], out=weight, where=self._has_mu[arrays["patch"]])


def _entries(arrays: Arrays, part: slice) -> Arrays:
    return {name: None if array is None else array[part] for name, array in arrays.items()}


def _checked_numbers(value: Any) -> int:
    """Numbers that a photon carries; a UsageError outside 0 to 3."""
    is_quick = type(value) is int and 0 <= value <= MAX_NUMBERS
    return value if is_quick else as_index_within(value, "numbers", 0, MAX_NUMBERS)


def _integer(value: Any, name: str) -> int:
    """As `as_index`, but quick for Python's own integers: calls for single photons need it."""
    return value if type(value) is int else as_index(value, name)
