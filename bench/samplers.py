"""The samplers that are compared: ours, and numpy's beside them."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.emission.photons import PhotonBatch
from aomc_sky.grid import PatchGrid
from bench.harness import ratio
from bench.skies import BenchSky

BATCH = 65_536
"""Photons per call, into the same buffers."""


@dataclass(frozen=True, kw_only=True, slots=True)
class BenchMethod:
    """One way to sample a sky."""

    #: Name in tables and files.
    name: str
    #: For a person.
    title: str
    #: Keyword arguments of `Scene.source`.
    options: Mapping[str, str] = field(default_factory=dict)
    #: It knows patches alone: a continuous sky is given to it as masses of 90 x 360 patches.
    needs_table: bool = False
    #: False: every seed gives the same photons, so one replicate is enough.
    is_random: bool = True
    #: Another method that emits the same photons in another order, so that its errors are known.
    same_photons_as: str = ""


_METHODS = (
    BenchMethod(name="default", title="systematic + R2, shuffled"),
    BenchMethod(
        name="patch-order",
        title="systematic + R2, patch order",
        options={"order": "patch"},
        same_photons_as="default",
    ),
    BenchMethod(name="iid", title="independent photons", options={"method": "iid"}),
    BenchMethod(name="largest-remainder", title="largest remainder + R2", options={"allocation": "largest-remainder"}),
    BenchMethod(
        name="aomc",
        title="AOMC's rounding, patch centres",
        options={"allocation": "aomc", "placement": "centre"},
        needs_table=True,
        is_random=False,
    ),
)

METHODS = {method.name: method for method in _METHODS}
"""By name, in the order of the tables."""


def source_of(
    sky: BenchSky, method: BenchMethod, n_photons: int, *, seed: int, precision: str = "float32"
) -> PhotonSource:
    """The source of a method, its counts settled."""
    scene = sky.scene(n_photons, as_table=method.needs_table)
    options: dict[str, Any] = dict(method.options)
    return scene.source(seed=seed, precision=precision, **options)


def buffer_of(source: PhotonSource) -> PhotonBatch:
    """Buffers for batches of a source, touched once."""
    return source.photons(0, 0, min(BATCH, source.n_photons(0)))


def drain(source: PhotonSource, out: PhotonBatch) -> None:
    """Emit all photons of a source into the same buffers."""
    for _ in source.batches(0, BATCH, out=out):
        pass


CHOICE = "numpy choice"

Contenders = Mapping[str, Callable[[], object]]
"""By name; each call makes all photons once."""
Directions = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True, kw_only=True, slots=True)
class SpeedRun:
    """Times of all contenders for the same number of photons of the same table."""

    n_photons: int
    #: Turns that count.
    turns: int
    #: Wall-clock times, one per turn. [s]
    times: dict[str, list[float]]
    #: A line for every contender that could not take part.
    left_out: tuple[str, ...] = ()

    def ns_per_photon(self, name: str) -> float:
        """Median over the turns. [ns]"""
        return 1e9 * statistics.median(self.times[name]) / self.n_photons

    def ratio(self, slow: str, fast: str) -> float | None:
        """Median over the turns of how many times longer one took; None where one was left out."""
        if slow not in self.times or fast not in self.times:
            return None
        return ratio(self.times[slow], self.times[fast])


class NumpySampler:
    """Photons uniform in their patches, as one writes it with numpy: all random numbers and functions in one precision.

    float64 is numpy's own, float32 is tuned to the precision that is delivered. The masses sum to 1.
    """

    def __init__(self, grid: PatchGrid, mass: np.ndarray, dtype: type) -> None:
        self.rng = np.random.default_rng(1)
        self.mass, self.dtype, self.n_azimuth = mass, np.dtype(dtype), grid.n_azimuth
        near, far = grid.ring_mu()
        self._mu2: np.ndarray = (far**2).astype(dtype)
        self._growth: np.ndarray = (near**2 - far**2).astype(dtype)
        start, end = np.deg2rad(grid.azimuth_bounds_deg).T
        self._azimuth, self._width = start.astype(dtype), (end - start).astype(dtype)

    def directions(self, patch: np.ndarray) -> Directions:
        """Travel directions, float32, one per entry of `patch`."""
        ring, column = np.divmod(patch, self.n_azimuth)
        # numpy's stub knows the two precisions as literals alone
        draw: Callable[..., np.ndarray] = self.rng.random
        mu2 = self._mu2[ring] + self._growth[ring] * draw(patch.size, dtype=self.dtype)
        azimuth = self._azimuth[column] + self._width[column] * draw(patch.size, dtype=self.dtype)
        sine = np.sqrt(1 - mu2)
        vector = -sine * np.cos(azimuth), -sine * np.sin(azimuth), -np.sqrt(mu2)
        x, y, z = (component.astype(np.float32, copy=False) for component in vector)
        return x, y, z

    def choice(self, n_photons: int) -> Directions:
        """Patches drawn one by one."""
        return self.directions(self.rng.choice(self.mass.size, size=n_photons, p=self.mass))

    def multinomial(self, n_photons: int) -> Directions:
        """Photons sorted by patch."""
        return self.directions(np.repeat(np.arange(self.mass.size), self.rng.multinomial(n_photons, self.mass)))


def speed_source(sky: BenchSky, name: str, n_photons: int, precision: str = "float32") -> PhotonSource:
    """The photons of a method whose time is measured."""
    return source_of(sky, METHODS[name], n_photons, seed=1, precision=precision)


def our_contenders(sky: BenchSky, n_photons: int) -> dict[str, Callable[[], object]]:
    """Every method in float32, and the two orders of the default in float64."""
    contenders: dict[str, Callable[[], object]] = {}
    chosen = [(name, "float32") for name in METHODS] + [("default", "float64"), ("patch-order", "float64")]
    for name, precision in chosen:
        source = speed_source(sky, name, n_photons, precision)
        title = name if precision == "float32" else f"{name}, {precision}"
        contenders[title] = partial(drain, source, buffer_of(source))
    return contenders
