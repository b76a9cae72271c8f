"""A batch of photons: a struct of arrays, and how a caller's arrays are reused."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

import aomc_sky
from aomc_sky.directions import sky_angles
from aomc_sky.errors import require_kind
from aomc_sky.grid import PatchGrid
from aomc_sky.record import same_content

Arrays = dict[str, Any]
"""Arrays of a batch by name; None for those that it does not have."""


class Photon(NamedTuple):
    """One photon as plain numbers, for codes that take one at a time.

    Examples
    --------
    >>> source = sky.Scene(
    ...     wavebands=[550.0], n_photons=10, components=sky.DirectBeam(sun_zenith_deg=0.0)
    ... ).source()
    >>> photon = next(source.one_by_one())
    >>> photon.band, photon.index_in_band, photon.uz
    (0, 0, -1.0)
    """

    band: int  #: Waveband. [0 to n_bands - 1]
    index_in_band: int
    wavelength_nm: float
    ux: float  #: Travel direction, unit vector, z up: uz < 0.
    uy: float
    uz: float
    x: float  #: Position at the surface; 0 without a footprint. [m]
    y: float
    weight: float  #: 1 where weights do not differ.


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class PhotonBatch:
    """Photons [start, start + n) of one waveband.

    Parameters
    ----------
    ux, uy, uz : ndarray, float32 or float64, shape (n,)
        Travel direction, unit vector, z up: uz < 0.
    patch : ndarray, int32, shape (n,)
        Cell of the photon: index into a row of `PhotonSource.counts`.
    band : int
        Waveband. [0 to n_bands - 1]
    start : int
        Index of the first photon in its band.
    wavelength_nm : float
        Wavelength of the band. [nm]
    x, y : ndarray, precision of ux, shape (n,), or None
        Position at the surface where the scene has a footprint. [m]
    weight : ndarray, precision of ux, shape (n,), or None
        Statistical weight, mean 1, where weights differ and were asked for.
    q, u : ndarray, float32, shape (n,), or None
        Q/I and U/I of the photon's patch in the meridian plane of its direction (docs/conventions.md), where a part of
        the light is polarised. 0 for photons of parts that are not. [-1 to 1]
    numbers : ndarray, precision of ux, shape (n, k), or None
        Further coordinates of each photon's low-discrepancy point, uniform in [0, 1), where `numbers=k` asked for them.

    Examples
    --------
    >>> source = sky.Scene(wavebands=[550.0], n_photons=1000, components="uniform").source(
    ...     seed=1
    ... )
    >>> batch = source.photons(band=0, start=100, stop=110)
    >>> len(batch), batch.start, batch.ux.dtype
    (10, 100, dtype('float32'))
    """

    ux: np.ndarray
    uy: np.ndarray
    uz: np.ndarray
    patch: np.ndarray
    band: int
    start: int
    wavelength_nm: float
    x: np.ndarray | None = None
    y: np.ndarray | None = None
    weight: np.ndarray | None = None
    q: np.ndarray | None = None
    u: np.ndarray | None = None
    numbers: np.ndarray | None = None

    __eq__ = same_content
    __array_ufunc__ = None  #: An array that is compared with a batch asks the batch, too.

    def __repr__(self) -> str:
        parts = "".join(f", {name}" for name in _NAMES[4:] if getattr(self, name) is not None)
        return (
            f"<PhotonBatch: photons {self.start} to {self.start + len(self) - 1} of band {self.band} at "
            f"{self.wavelength_nm:g} nm, {self.ux.dtype}{parts}>"
        )

    def _repr_html_(self) -> str:
        from aomc_sky.emission.notebook import MOST_ROWS, html

        columns = self[:MOST_ROWS].to_dict()
        rows = [
            (self.start + k, *(f"{float(v):.6g}" for v in one))
            for k, one in enumerate(zip(*columns.values(), strict=True))
        ]
        return html(repr(self)[1:-1], ("photon", *columns), rows, len(self), self._dome)

    def _dome(self) -> Any:
        """Photons per steradian in 18 x 36 patches; of many photons, a million from the first."""
        grid, some = PatchGrid.regular(18, 36), self[:1_000_000]
        zenith, azimuth = map(np.rad2deg, sky_angles(some.directions.astype(np.float64)))
        patch = grid.patch_of(np.minimum(zenith, 90.0), azimuth)
        values = np.bincount(patch, minlength=grid.n_patches) / grid.solid_angle_sr
        return aomc_sky.plot(values, grid=grid, label="photons per steradian [sr$^{-1}$]", size_px=480)

    def __iter__(self) -> Iterator[Photon]:
        """The photons one by one."""
        columns = self.to_dict()
        zeros, ones = itertools.repeat(0.0), itertools.repeat(1.0)
        parts = [columns[n].tolist() for n in ("ux", "uy", "uz")]
        parts += [columns[n].tolist() if n in columns else zeros for n in ("x", "y")]
        parts.append(columns["weight"].tolist() if "weight" in columns else ones)
        for k, numbers in enumerate(zip(*parts, strict=False), start=self.start):
            yield Photon(self.band, k, self.wavelength_nm, *numbers)

    def __len__(self) -> int:
        return int(self.ux.size)

    def __getitem__(self, photons: slice) -> PhotonBatch:
        """The photons of a slice of step 1, as views of these arrays."""
        if not isinstance(photons, slice):
            raise TypeError("a batch takes slices, for example batch[:1000]; one photon is batch[i : i + 1]")
        first, _, step = photons.indices(len(self))
        if step != 1:
            raise ValueError("photons of a batch follow each other; take every k-th from its arrays")
        arrays: Arrays = {name: array[photons] for name in _NAMES if (array := getattr(self, name)) is not None}
        return replace(self, start=self.start + first, **arrays)

    def to_dict(self) -> dict[str, np.ndarray]:
        """The arrays that there are, by name: `pandas.DataFrame(batch.to_dict())`, alike for polars.

        For xarray ``xarray.Dataset({name: ("photon", array) for name, array in batch.to_dict().items()})``. Numbers are
        the columns n1, n2, n3.
        """
        columns = {f"n{k}": c for k, c in enumerate(() if self.numbers is None else self.numbers.T, 1)}
        return {name: array for name in _NAMES[:-1] if (array := getattr(self, name)) is not None} | columns

    @property
    def directions(self) -> np.ndarray:
        """Travel directions as one new array, shape (n, 3)."""
        return np.stack([self.ux, self.uy, self.uz], axis=-1)

    @property
    def positions(self) -> np.ndarray | None:
        """Positions as one new array, shape (n, 2), or None. [m]"""
        return None if self.x is None or self.y is None else np.stack([self.x, self.y], axis=-1)


_NAMES = ("ux", "uy", "uz", "patch", "x", "y", "weight", "q", "u", "numbers")
_CELL = np.dtype(np.int32)

MAX_NUMBERS = 3
"""Most numbers that a photon carries for its host."""


def batch_arrays(
    n: int,
    dtype: np.dtype,
    out: PhotonBatch | None,
    *,
    with_positions: bool,
    with_weights: bool,
    with_stokes: bool = False,
    n_numbers: int = 0,
) -> Arrays:
    """Arrays of length n for a batch: new ones, or the first n entries of those of `out`.

    Numbers are (n, n_numbers), each column in one piece. ValueError: the arrays of `out` are too short, of another
    type, not contiguous, read-only, or overlap.
    """
    position, weight = dtype if with_positions else None, dtype if with_weights else None
    stokes = np.dtype(np.float32) if with_stokes else None
    expected = (dtype, dtype, dtype, _CELL, position, position, weight, stokes, stokes)
    if out is None:
        arrays: Arrays = {
            name: None if k is None else np.empty(n, k) for name, k in zip(_NAMES, expected, strict=False)
        }
        return arrays | {"numbers": np.empty((n_numbers, n), dtype).T if n_numbers else None}
    require_kind(out, PhotonBatch, "out=batch, one that `photons` returned")
    arrays = dict.fromkeys(_NAMES)
    present: list[np.ndarray] = []
    for name, kind in zip(_NAMES, (*expected, dtype if n_numbers else None), strict=True):
        if kind is None:
            continue
        array = getattr(out, name)
        rest = (n_numbers,) if name == "numbers" else ()
        fits = (
            isinstance(array, np.ndarray)
            and array.dtype == kind
            and array.shape[1:] == rest
            and array.shape[:1] >= (n,)
        )
        if not fits or not (flags := array.T.flags).c_contiguous or not flags.writeable:
            shape = (
                f"Fortran-ordered {kind} array of {n_numbers} columns and" if rest else f"contiguous {kind} array of"
            )
            raise ValueError(f"out.{name} must be a writable {shape} at least {n} entries")
        arrays[name] = array = array[:n]
        for other in present:  # a loop, for every thread waits while another one looks
            if np.may_share_memory(array, other):
                raise ValueError("the arrays of out overlap; every array needs memory of its own")
        present.append(array)
    return arrays


def number_columns(numbers: np.ndarray) -> list[np.ndarray]:
    """The columns of the numbers of photons, as many as there may be; empty ones for those that are not there."""
    return [*numbers.T, *[np.empty(0, numbers.dtype)] * (MAX_NUMBERS - numbers.shape[1])]
