"""Other people's samplers for the same job, and what limits them all: photons of a table of patches, uniform in each.

Every peer chooses patches by its library's own means, then places each photon uniformly in mu^2 and azimuth and turns
it into a unit vector, with that library's functions. Patches and places are drawn independently, so the error of a
peer's photons is that of the method `iid`. numpy's sampler is that of `samplers.py`.
"""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import numpy as np

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.errors import MissingExtraError, UsageError
from aomc_sky.extras import optional_module
from aomc_sky.grid import PatchGrid
from bench.harness import in_turns
from bench.samplers import BATCH, CHOICE, NumpySampler, SpeedRun, buffer_of, our_contenders, speed_source
from bench.skies import BenchSky

STORES = {"stores of 12 bytes": 12, "stores of 24 bytes": 24}
TWO_THREADS = "default, two threads"
HOST = "default, one photon per call"
MULTINOMIAL = "numpy multinomial + repeat"
MITSUBA = "Mitsuba 3 DiscreteDistribution"

Peer = Callable[[int], Any]
"""A sampler that is set up once for a table, then makes any number of photons."""


def measure_peers(sky: BenchSky, n_photons: int, turns: int) -> SpeedRun:
    """Time our methods, their hosts, all peers and plain stores on the table of a sky.

    Ours fill reused buffers of 65 536 photons and settle their counts beforehand, as scipy and Mitsuba do with their
    tables; numpy's `choice` and `multinomial` have no such step.
    """
    contenders, left_out = our_contenders(sky, n_photons), []
    try:
        contenders[HOST] = _host(sky, n_photons)
    except UsageError as error:
        left_out.append(f"{HOST} is left out: {error}")
    peers, missing = peers_of_table(sky.grid, sky.mass)
    for name, peer in peers.items():
        contenders[name] = partial(peer, n_photons)
    for name, size in STORES.items():
        contenders[name] = partial(StoreLimit(BATCH, size), n_photons)
    with ThreadPoolExecutor(2, thread_name_prefix="aomc-sky-bench") as pool:
        contenders[TWO_THREADS] = two_threads(speed_source(sky, "default", n_photons), pool)
        times = in_turns(contenders, turns)
    return SpeedRun(n_photons=n_photons, turns=turns, times=times, left_out=(*left_out, *missing))


def two_threads(source: PhotonSource, pool: ThreadPoolExecutor) -> Callable[[], object]:
    """All photons once: both threads take the next chunk when they are free, each with buffers of its own."""
    n = source.n_photons(0)
    buffers = [buffer_of(source) for _ in range(2)]

    def work(thread: int, chunks: itertools.count[int]) -> None:
        while (start := next(chunks)) < n:
            source.photons(0, start, min(start + BATCH, n), out=buffers[thread])

    def drained() -> None:
        chunks = itertools.count(0, BATCH)
        for done in [pool.submit(work, thread, chunks) for thread in range(2)]:
            done.result()

    return drained


def _host(sky: BenchSky, n_photons: int) -> Callable[[], object]:
    """A jitted loop that asks for one photon after the other."""
    from numba import njit

    sample = speed_source(sky, "default", n_photons).numba_sampler(0).sample

    @njit(nogil=True)
    def loop(n: int) -> tuple[float, float, float]:
        x_sum, y_sum, z_sum = 0.0, 0.0, 0.0  # so that no part of the photons can be left out
        for i in range(n):
            x, y, z = sample(i)
            x_sum += x
            y_sum += y
            z_sum += z
        return x_sum, y_sum, z_sum

    return partial(loop, n_photons)


def peers_of_table(grid: PatchGrid, mass: np.ndarray) -> tuple[dict[str, Peer], list[str]]:
    """The peers by name, set up for masses of any scale; and a line for each that is absent or does not work here."""
    p = mass / mass.sum()
    plain, tuned = NumpySampler(grid, p, np.float64), NumpySampler(grid, p, np.float32)
    peers: dict[str, Peer] = {
        CHOICE: plain.choice,
        MULTINOMIAL: plain.multinomial,
        "numpy choice, float32": tuned.choice,
        "numpy multinomial + repeat, float32": tuned.multinomial,
        **_scipy_peers(plain),
    }
    try:
        peers[MITSUBA] = MitsubaPeer(grid, p)
    except MissingExtraError as error:
        return peers, [f"Mitsuba 3 is left out: {error}"]
    return peers, []


def _scipy_peers(places: NumpySampler) -> dict[str, Peer]:
    from scipy.stats import sampling

    generator = np.random.default_rng(2)
    alias = sampling.DiscreteAliasUrn(places.mass, random_state=generator)
    guide = sampling.DiscreteGuideTable(places.mass, random_state=generator)
    return {
        "scipy DiscreteAliasUrn": lambda n: places.directions(alias.rvs(n)),
        "scipy DiscreteGuideTable": lambda n: places.directions(guide.rvs(n)),
    }


class StoreLimit:
    """Plain stores into reused buffers of a batch: nothing that writes its photons can be faster.

    A photon has 12 or 24 bytes: three components in float32 or in float64.
    """

    def __init__(self, batch: int, bytes_per_photon: int) -> None:
        self._arrays = [np.zeros(batch, f"f{bytes_per_photon // 3}") for _ in range(3)]
        self._batch = batch

    def __call__(self, n_photons: int) -> None:
        """Store this many photons."""
        for _ in range(0, n_photons, self._batch):
            for array in self._arrays:
                array.fill(0.5)


_BATCH = 262_144
"""Photons per launch: with fewer the launches cost more, with more the caches."""


class MitsubaPeer:
    """Mitsuba set up for a table; called with a number of photons it makes them, in Dr.Jit's own reused memory.

    A MissingExtraError says that Mitsuba is not installed, or that it finds no LLVM library.
    """

    def __init__(self, grid: PatchGrid, p: np.ndarray) -> None:
        mi, dr = self._mi, self._dr = _mitsuba()
        near, far = grid.ring_mu()
        start, end = (np.deg2rad(edge).astype(np.float32) for edge in grid.azimuth_bounds_deg.T)
        columns = (near**2 - far**2, far**2, end - start, start)
        self._growth, self._far_mu2, self._width, self._azimuth = (mi.Float(c.astype(np.float32)) for c in columns)
        self._table = mi.DiscreteDistribution(mi.Float(p.astype(np.float32)))
        self._n_azimuth = grid.n_azimuth
        self._generators: dict[int, Any] = {}
        dr.sync_thread()

    def __call__(self, n_photons: int) -> Any:
        """Make photons batch by batch; returns the last batch."""
        vector = None
        for begin in range(0, n_photons, _BATCH):
            vector = self._launch(min(_BATCH, n_photons - begin))
        return vector

    def _launch(self, n: int) -> Any:
        dr, generator = self._dr, self._generators.setdefault(n, self._mi.PCG32(size=n))
        patch = self._table.sample(generator.next_float32())
        ring = patch // self._n_azimuth
        mu2 = self._place(self._growth, self._far_mu2, ring, generator)
        sine, cosine = dr.sincos(self._place(self._width, self._azimuth, patch - ring * self._n_azimuth, generator))
        across = dr.sqrt(1 - mu2)
        vector = self._mi.Vector3f(-across * cosine, -across * sine, -dr.sqrt(mu2))
        dr.eval(vector, generator)
        dr.sync_thread()
        return vector

    def _place(self, width: Any, start: Any, index: Any, generator: Any) -> Any:
        """A uniform place between the two bounds of a ring or column."""
        dr, kind = self._dr, self._mi.Float
        return dr.fma(dr.gather(kind, width, index), generator.next_float32(), dr.gather(kind, start, index))


def _mitsuba() -> tuple[Any, Any]:
    """Mitsuba and Dr.Jit, set to one thread, after a sum that shows that the backend works."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        mi, dr = optional_module("mitsuba", extra="bench"), optional_module("drjit", extra="bench")
        try:
            mi.set_variant("llvm_ad_mono")
            dr.set_thread_count(0)  # no helpers: the calling thread works alone
            dr.eval(mi.Float(1.0, 2.0) + 1.0)
        except (ImportError, RuntimeError) as error:
            reason = str(error).strip().splitlines()[0]
            raise MissingExtraError(
                f"its LLVM backend does not start ({reason}); install LLVM's shared library, for example libllvm15"
            ) from error
    return mi, dr
