"""Photons per second of our methods, of their hosts and of the peers, turn and turn about, against plain stores."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

from aomc_sky.benchmark.accuracy import BATCH, buffer_of, drain, source_of
from aomc_sky.benchmark.methods import METHODS
from bench.peers import StoreLimit, peers_of_table
from aomc_sky.benchmark.skies import BenchSky
from bench.threads import two_threads
from aomc_sky.benchmark.timing import in_turns, ratio
from aomc_sky.errors import UsageError
from aomc_sky.source.photon_source import PhotonSource

STORES = {"stores of 12 bytes": 12, "stores of 24 bytes": 24}
TWO_THREADS = "default, two threads"
HOST = "default, one photon per call"
MULTINOMIAL, CHOICE = "numpy multinomial + repeat", "numpy choice"
MITSUBA = "Mitsuba 3 DiscreteDistribution"


@dataclass(frozen=True, kw_only=True, slots=True)
class SpeedRun:
    """Times of all contenders for the same number of photons of the same table.

    Parameters
    ----------
    n_photons, turns : int
        Photons of each turn, and turns that count.
    times : dict of str to list of float
        Wall-clock times. [s]
    left_out : tuple of str
        A line for every contender that could not take part.
    """

    n_photons: int
    turns: int
    times: dict[str, list[float]]
    left_out: tuple[str, ...]

    def ns_per_photon(self, name: str) -> float:
        """Median over the turns. [ns]"""
        return 1e9 * statistics.median(self.times[name]) / self.n_photons

    def ratio(self, slow: str, fast: str) -> float | None:
        """Median over the turns of how many times longer one took; None where one was left out."""
        if slow not in self.times or fast not in self.times:
            return None
        return ratio(self.times[slow], self.times[fast])


def measure_speed(sky: BenchSky, n_photons: int, turns: int) -> SpeedRun:
    """Time all contenders.

    Parameters
    ----------
    sky : BenchSky
        Its table of patches, for the peers know nothing else.
    n_photons : int
        Photons of each turn.
    turns : int
        Turns that count; one more comes first.

    Returns
    -------
    SpeedRun
        Ours fill reused buffers of 65 536 photons and settle their counts beforehand, as scipy and Mitsuba do with
        their tables; numpy's `choice` and `multinomial` have no such step.
    """
    contenders = _ours(sky, n_photons)
    left_out = []
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


def speed_source(sky: BenchSky, name: str, n_photons: int, precision: str = "float32") -> PhotonSource:
    """The photons of a method whose time is measured."""
    return source_of(sky, METHODS[name], n_photons, seed=1, precision=precision)


def _ours(sky: BenchSky, n_photons: int) -> dict[str, Callable[[], object]]:
    """Every method in float32, and the two orders of the default in float64."""
    contenders: dict[str, Callable[[], object]] = {}
    wanted = [(name, "float32") for name in METHODS] + [("default", "float64"), ("patch-order", "float64")]
    for name, precision in wanted:
        source = speed_source(sky, name, n_photons, precision)
        title = name if precision == "float32" else f"{name}, {precision}"
        contenders[title] = partial(drain, source, buffer_of(source))
    return contenders


def _host(sky: BenchSky, n_photons: int) -> Callable[[], object]:
    """A jitted loop that asks for one photon after the other."""
    from aomc_sky.kernels.hosts.loop import make_loop

    loop = make_loop(speed_source(sky, "default", n_photons).numba_sampler(0).sample)
    return partial(loop, n_photons)
