"""Photons counted by zone of the sky and inside patches, block by block, in bounded memory."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from aomc_sky.directions import Frame, sky_from_travel
from aomc_sky.grid import PatchGrid
from aomc_sky.verify.coin import fair_coin
from aomc_sky.verify.fixed_places import MARGIN_DEG
from aomc_sky.verify.patch_interior import InteriorCounts, PatchInterior
from aomc_sky.verify.threads import in_order

LENGTH_TOLERANCE = 1e-5
"""How far the square of a direction's length may be from 1, as libmcpl has it."""

_ZENITH_DEG = 1e-3
"""So near to the zenith an azimuth says nothing, and counts as 0."""


@dataclass(frozen=True, kw_only=True, slots=True)
class DirectionCounts:
    """Photons of a waveband.

    Parameters
    ----------
    n : int
        All of them.
    zone : ndarray, float64, shape (n_zone,)
        Photons of each zone.
    kept : ndarray, float64, shape (n_zone,)
        Those that a fair coin keeps.
    weight, weight2 : ndarray, float64, shape (n_zone,)
        Sums of weights and of their squares.
    weight_range : tuple of float
        Smallest and largest weight; (inf, -inf) without photons.
    n_upward, n_bad_length : int
        Photons that do not come from above, and those whose direction is no unit vector.
    n_dark : int
        Photons in zones that expect none, farther from their edges than rounding brings them.
    interior : InteriorCounts or None
        Places inside patches.
    """

    n: int
    zone: np.ndarray
    kept: np.ndarray
    weight: np.ndarray
    weight2: np.ndarray
    weight_range: tuple[float, float]
    n_upward: int
    n_bad_length: int
    n_dark: int
    interior: InteriorCounts | None

    @property
    def weights_differ(self) -> bool:
        """Whether there are two different weights."""
        return self.weight_range[0] < self.weight_range[1]

    def __add__(self, other: DirectionCounts) -> DirectionCounts:
        low = min(self.weight_range[0], other.weight_range[0])
        high = max(self.weight_range[1], other.weight_range[1])
        both = self.interior is not None and other.interior is not None
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
        )


@dataclass(frozen=True, kw_only=True, slots=True)
class PhotonRows:
    """A block of photons of one waveband.

    Parameters
    ----------
    start : int
        Index of the first one.
    direction : ndarray, float, shape (n, 3)
        Travel directions.
    weight : ndarray, float64, shape (n,), or None
        None where every weight is 1.
    """

    start: int
    direction: np.ndarray
    weight: np.ndarray | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class DirectionCounter:
    """What blocks are counted by.

    Parameters
    ----------
    zones : PatchGrid
        Zones of the sky.
    is_dark : ndarray, bool, shape (n_zone,)
        Zones that expect no photon.
    interior : PatchInterior or None
        The patches whose inside is looked at.
    frame : Frame
        Which way z grows in the directions.
    coin_key : int
        Key of the fair coin. [0 to 2^64 - 1]
    """

    zones: PatchGrid
    is_dark: np.ndarray
    interior: PatchInterior | None
    frame: Frame = Frame.UP
    coin_key: int = 0

    def count(self, rows: PhotonRows) -> DirectionCounts:
        """Count one block."""
        direction = np.asarray(rows.direction, dtype=np.float64)
        length2 = np.einsum("ij,ij->i", direction, direction)
        zenith_rad, azimuth_rad = sky_from_travel(direction, self.frame)
        zenith, azimuth = np.rad2deg(zenith_rad), np.rad2deg(azimuth_rad)
        azimuth[zenith < _ZENITH_DEG] = 0.0
        zone = self.zones.patch_of(zenith, azimuth)
        from_above = zone >= 0
        weight = np.ones(len(zone)) if rows.weight is None else np.asarray(rows.weight, dtype=np.float64)
        kept = fair_coin(self.coin_key, rows.start, len(zone))
        n_zones = self.zones.n_patches
        seen, w = zone[from_above], weight[from_above]
        return DirectionCounts(
            n=len(zone),
            zone=np.bincount(seen, minlength=n_zones).astype(np.float64),
            kept=np.bincount(zone[from_above & kept], minlength=n_zones).astype(np.float64),
            weight=np.bincount(seen, w, n_zones),
            weight2=np.bincount(seen, w * w, n_zones),
            weight_range=(float(weight.min(initial=np.inf)), float(weight.max(initial=-np.inf))),
            n_upward=int(np.count_nonzero(~from_above)),
            n_bad_length=int(np.count_nonzero(~(np.abs(length2 - 1) <= LENGTH_TOLERANCE))),
            n_dark=self._n_dark(zone, zenith, azimuth),
            interior=None if self.interior is None else self.interior.tally(zenith, azimuth),
        )

    def _n_dark(self, zone: np.ndarray, zenith: np.ndarray, azimuth: np.ndarray) -> int:
        in_dark = np.flatnonzero((zone >= 0) & self.is_dark[zone])
        if in_dark.size == 0:
            return 0
        ring, column = np.divmod(zone[in_dark], self.zones.n_azimuth)
        zenith, azimuth = zenith[in_dark], azimuth[in_dark]
        by_ring = np.abs(zenith[:, None] - self.zones.zenith_bounds_deg[ring]).min(axis=1)
        ends = azimuth[:, None] - self.zones.azimuth_bounds_deg[column]
        around = np.abs(ends - 360.0 * np.rint(ends / 360.0)).min(axis=1) * np.sin(np.deg2rad(zenith))
        return int(np.count_nonzero(np.minimum(by_ring, around) > MARGIN_DEG))

    def count_all(self, blocks: Iterable[PhotonRows], threads: int = 0) -> DirectionCounts:
        """Count all blocks on threads; the counts are the same on any number of them."""
        total = self.count(PhotonRows(start=0, direction=np.zeros((0, 3))))
        for part in in_order(self.count, blocks, threads):
            total = total + part
        return total
