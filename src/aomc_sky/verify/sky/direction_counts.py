"""Photons counted by zone of the sky and inside patches, block by block, in bounded memory."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from aomc_sky.directions import Frame
from aomc_sky.outputs.photons.files import in_order
from aomc_sky.sampling.streams import stream_key
from aomc_sky.system import n_cpus
from aomc_sky.verify.sky.patches import FoundPatches, InteriorCounts, PatchFinder, PatchInterior, PhotonAngles
from aomc_sky.verify.sky.repeats import RepeatFinder, RepeatSample
from aomc_sky.verify.sky.zones import MARGIN_DEG, WHOLE_TURN

LENGTH_TOLERANCE = 1e-5
"""How far the square of a direction's length may be from 1, as libmcpl has it."""

_CHUNK = 16_384
"""Photons whose angles, zones and steps stay in the cache of a core."""


@dataclass(frozen=True, kw_only=True, slots=True)
class DirectionCounts:
    """Photons of a waveband."""

    #: All of them.
    n: int
    #: Photons of each zone. [shape (n_zone,)]
    zone: np.ndarray
    #: Those that the thinning keeps; 0 where nothing was thinned. [shape (n_zone,)]
    kept: np.ndarray
    #: weight, weight2: Sums of weights and of their squares. [shape (n_zone,)]
    weight: np.ndarray
    weight2: np.ndarray
    #: Smallest and largest weight; (inf, -inf) without photons.
    weight_range: tuple[float, float]
    #: n_upward, n_bad_length: Photons that do not come from above, and those whose direction is no unit vector.
    n_upward: int
    n_bad_length: int
    #: Photons in zones that expect none, farther from their edges than rounding brings them.
    n_dark: int
    #: Places inside patches.
    interior: InteriorCounts | None
    #: What shows copies of photons.
    repeats: RepeatSample | None = None

    @property
    def weights_differ(self) -> bool:
        """Whether there are two different weights."""
        return self.weight_range[0] < self.weight_range[1]

    def __add__(self, other: DirectionCounts) -> DirectionCounts:
        low = min(self.weight_range[0], other.weight_range[0])
        high = max(self.weight_range[1], other.weight_range[1])
        both = self.interior is not None and other.interior is not None
        copied = self.repeats is not None and other.repeats is not None
        return DirectionCounts(
            n=self.n + other.n,
            zone=self.zone + other.zone,
            kept=self.kept + other.kept,
            weight=self.weight + other.weight,
            weight2=self.weight2 + other.weight2,
            weight_range=(low, high),
            n_upward=self.n_upward + other.n_upward,
            n_bad_length=self.n_bad_length + other.n_bad_length,
            n_dark=self.n_dark + other.n_dark,
            interior=self.interior + other.interior if both else None,  # type: ignore[operator]
            repeats=self.repeats + other.repeats if copied else None,  # type: ignore[operator]
        )


@dataclass(frozen=True, kw_only=True, slots=True)
class PhotonRows:
    """A block of photons of one waveband."""

    #: Index of the first one.
    start: int
    #: Travel directions. [shape (n, 3)]
    direction: np.ndarray
    #: None where every weight is 1. [shape (n,)]
    weight: np.ndarray | None = None

    def part(self, start: int, stop: int) -> PhotonRows:
        """Some of them."""
        weight = None if self.weight is None else self.weight[start:stop]
        return PhotonRows(start=self.start + start, direction=self.direction[start:stop], weight=weight)


PhotonBlock = PhotonRows | Callable[[], PhotonRows]
"""A block of photons, or what reads it when a thread comes to it."""


def rows_of(block: PhotonBlock) -> PhotonRows:
    """The photons of a block, read now if they were not."""
    return block() if callable(block) else block


@dataclass(frozen=True, kw_only=True, slots=True)
class DirectionCounter:
    """What blocks are counted by."""

    #: Of the zones of the sky.
    zones: PatchFinder
    #: Zones that expect no photon. [shape (n_zone,)]
    is_dark: np.ndarray
    #: The patches whose inside is looked at.
    interior: PatchInterior | None
    #: Which way z grows in the directions.
    frame: Frame = Frame.UP
    #: Zones of the patches of `interior`, from `zone_of_patches`; None where a zone cuts patches. [shape (n_patch,)]
    zone_of_patch: np.ndarray | None = None
    #: Key of the thinning; None where no test needs it. [0 to 2^64 - 1]
    thinning_key: int | None = None
    #: What finds copies; None where they are not looked for.
    repeats: RepeatFinder | None = None

    def count(self, rows: PhotonRows) -> DirectionCounts:
        """Count one block, in chunks that fit the cache of a core."""
        with np.errstate(over="ignore", invalid="ignore"):  # of damaged photons; they are counted as such
            total = self._count(rows.part(0, _CHUNK))
            for start in range(_CHUNK, len(rows.direction), _CHUNK):
                total = total + self._count(rows.part(start, start + _CHUNK))
        return total

    def _count(self, rows: PhotonRows) -> DirectionCounts:
        angles = PhotonAngles.of(rows.direction, self.frame)
        n, n_zones = len(rows.direction), self.zones.grid.n_patches
        patches = None if self.interior is None else self.interior.find(angles)
        zone = self._zone(angles, patches)
        of_zones = np.bincount(zone, minlength=n_zones + 1).astype(np.float64)
        weight: np.ndarray = of_zones
        weight2: np.ndarray = of_zones
        weight_range = (1.0, 1.0) if n else (np.inf, -np.inf)
        if rows.weight is not None:
            w = np.asarray(rows.weight, dtype=np.float64)
            weight, weight2 = np.bincount(zone, w, n_zones + 1), np.bincount(zone, w * w, n_zones + 1)
            weight_range = (float(w.min(initial=np.inf)), float(w.max(initial=-np.inf)))
        n_unit = np.count_nonzero(np.abs(angles.length2 - 1) <= LENGTH_TOLERANCE)
        return DirectionCounts(
            n=n,
            zone=of_zones[1:],
            kept=self._kept(rows.start, zone),
            weight=weight[1:],
            weight2=weight2[1:],
            weight_range=weight_range,
            n_upward=int(of_zones[0]),
            n_bad_length=n - int(n_unit),
            n_dark=self._n_dark(zone, angles),
            interior=None if self.interior is None or patches is None else self.interior.tally(angles, patches),
            repeats=None if self.repeats is None else self.repeats.sample(rows.direction),
        )

    def _zone(self, angles: PhotonAngles, patches: FoundPatches | None) -> np.ndarray:
        """Zone of each photon from 1; 0 where it does not come from above."""
        if patches is not None and self.zone_of_patch is not None:
            found = patches
            zone: np.ndarray = self.zone_of_patch.take(patches.number, mode="clip")
        else:
            found = self.zones.find(angles.zenith_deg, angles.azimuth_deg)
            zone = found.number
        zone += 1
        zone *= found.is_inside
        return zone

    def _kept(self, start: int, zone: np.ndarray) -> np.ndarray:
        n_zones = self.zones.grid.n_patches
        if self.thinning_key is None:
            return np.zeros(n_zones)
        kept = zone * is_kept(self.thinning_key, start, zone.size)
        return np.bincount(kept, minlength=n_zones + 1)[1:].astype(np.float64)

    def _n_dark(self, zone: np.ndarray, angles: PhotonAngles) -> int:
        if not self.is_dark.any():
            return 0
        in_dark = np.flatnonzero(np.append(False, self.is_dark).take(zone, mode="clip"))
        if in_dark.size == 0:
            return 0
        zones = self.zones.grid
        ring, column = np.divmod(zone[in_dark] - 1, zones.n_azimuth)
        zenith, azimuth = angles.zenith_deg[in_dark], angles.azimuth_deg[in_dark]
        by_ring = np.abs(zenith[:, None] - zones.zenith_bounds_deg[ring]).min(axis=1)
        ends = azimuth[:, None] - zones.azimuth_bounds_deg[column]
        around = np.abs(ends - WHOLE_TURN * np.rint(ends / WHOLE_TURN)).min(axis=1) * np.sin(np.deg2rad(zenith))
        return int(np.count_nonzero(np.minimum(by_ring, around) > MARGIN_DEG))

    def count_all(self, blocks: Iterable[PhotonBlock], threads: int = 0) -> DirectionCounts:
        """Read and count all blocks on threads; the counts are the same on any number of them."""
        total = self.count(PhotonRows(start=0, direction=np.zeros((0, 3))))
        with closing(map_in_order(lambda block: self.count(rows_of(block)), blocks, threads)) as counted:
            for part in counted:
                total = total + part
        return total


THINNING = "verify-coin"
"""Name of the stream that chooses the photons that are kept; no photon is made from it."""

_WORD = 64
_WORDS_PER_STEP = 4  # numpy's Philox gives four words for each value of its counter


def thinning_key(seed: int) -> int:
    """Key of the choice of photons of a seed."""
    return stream_key(seed, THINNING)


def is_kept(key: int, start: int, n: int) -> np.ndarray:
    """Whether photons [start, start + n) are kept: each with a chance of one half.

    Bit i of the words of Philox4x64-10 by a key from `thinning_key`: any split of a file keeps the same photons.
    """
    per_step = _WORD * _WORDS_PER_STEP
    step, offset = divmod(start, per_step)
    generator = np.random.Philox(key=[key, 0], counter=[step, 0, 0, 0])
    words = np.asarray(generator.random_raw((offset + n + _WORD - 1) // _WORD), dtype="<u8")
    return np.unpackbits(words.view(np.uint8), bitorder="little")[offset : offset + n].view(bool)


_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


def map_in_order(
    work: Callable[[_Item], _Result], items: Iterable[_Item], threads: int = 0
) -> Generator[_Result, None, None]:
    """Yield what `work` makes of every item, in their order; memory holds `threads` + 1 items at a time.

    Items are read on the caller's thread; 0 threads: one per CPU. Numpy and SHA-256 let other threads run.
    """
    threads = threads or n_cpus()
    with ThreadPoolExecutor(max_workers=threads, thread_name_prefix="aomc-sky") as executor:
        yield from in_order(executor, threads, work, items)
