"""Photons per second of our methods, and of numpy's `choice` beside them, turn and turn about."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from aomc_sky.benchmark.accuracy import buffer_of, drain, source_of
from aomc_sky.benchmark.methods import METHODS
from aomc_sky.benchmark.skies import BenchSky
from aomc_sky.benchmark.timing import in_turns, ratio
from aomc_sky.grid import PatchGrid
from aomc_sky.source.photon_source import PhotonSource

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


def measure_speed(sky: BenchSky, n_photons: int, turns: int) -> SpeedRun:
    """Time every method and numpy's `choice`, after one turn that does not count.

    Ours fill reused buffers of 65 536 photons and settle their counts beforehand; `choice` has no such step.
    """
    return timed({**our_contenders(sky, n_photons), **numpy_contender(sky, n_photons)}, n_photons, turns)


def timed(contenders: Contenders, n_photons: int, turns: int, left_out: tuple[str, ...] = ()) -> SpeedRun:
    """A speed run of these contenders."""
    return SpeedRun(n_photons=n_photons, turns=turns, times=in_turns(contenders, turns), left_out=left_out)


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


def numpy_contender(sky: BenchSky, n_photons: int) -> dict[str, Callable[[], object]]:
    """Numpy as one writes it first: `choice` and float64."""
    sampler = NumpySampler(sky.grid, sky.mass / sky.mass.sum(), np.float64)
    return {CHOICE: partial(sampler.choice, n_photons)}
