"""What speed and error must keep, as ratios measured in one run on the machine at hand."""

from __future__ import annotations

import os
from dataclasses import dataclass

from bench import threads
from aomc_sky.benchmark.accuracy import Row, measure_errors
from bench.libmcpl import mcpl_times
from aomc_sky.benchmark.methods import METHODS
from aomc_sky.benchmark.skies import bench_sky
from aomc_sky.benchmark.speed import CHOICE, HOST, MITSUBA, MULTINOMIAL, SpeedRun, measure_speed, speed_source
from bench.streamed import streamed_peak
from aomc_sky.benchmark.timing import ratio
from aomc_sky.kernels.backend import expect_photons

LIMITS = {
    "patch order against numpy multinomial + repeat": 40.0,
    "default against numpy choice": 20.0,
    "default against Mitsuba 3": 2.4,
    "two threads against one": 1.9,
    "two threads against two processes that share nothing": 0.9,
    "one photon per call of a numba host against the default": 6.0,
    "growth of a streamed run's memory [MB]": 50.0,
    "MCPL writer against a ctypes loop over libmcpl": 15.0,
    "planar irradiance, independent photons against default": 40.0,
    "cone, independent photons against default": 4.0,
    "histogram, independent photons against default": 6.0,
    "planar irradiance, within patches uniform": 300.0,
}
"""By name; the limits of docs/performance.md."""
AT_MOST = ("one photon per call of a numba host against the default", "growth of a streamed run's memory [MB]")
"""Bars from above; all others are from below."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Bar:
    """A measured value beside what it must keep.

    Parameters
    ----------
    name : str
        A key of `LIMITS`.
    value : float
        The ratio, or megabytes.
    detail : str
        What stood behind it, for a person.
    """

    name: str
    value: float
    detail: str = ""

    @property
    def limit(self) -> float:
        """What it must keep."""
        return LIMITS[self.name]

    @property
    def is_kept(self) -> bool:
        """Whether it does."""
        return self.value <= self.limit if self.name in AT_MOST else self.value >= self.limit

    @property
    def relation(self) -> str:
        """The sign between value and limit."""
        return "<=" if self.name in AT_MOST else ">="


@dataclass(frozen=True, kw_only=True, slots=True)
class CheckSizes:
    """How much a check measures.

    Parameters
    ----------
    speed_photons, speed_turns : int
        Photons and turns of the times.
    thread_photons, thread_turns : int
        Of the times of two threads, whose start must not count.
    error_photons, error_replicates : int
        Photons and replicates of the errors.
    memory_photons : (int, int)
        Of the short and of the long streamed run.
    mcpl_photons : int
        Of the MCPL files.
    """

    speed_photons: int = 4_000_000
    speed_turns: int = 7
    thread_photons: int = 10_000_000
    thread_turns: int = 15
    error_photons: int = 1_000_000
    error_replicates: int = 64
    memory_photons: tuple[int, int] = (1_000_000, 1_000_000_000)
    mcpl_photons: int = 1_000_000


@dataclass(frozen=True, kw_only=True, slots=True)
class Check:
    """All bars of a run.

    Parameters
    ----------
    bars : tuple of Bar
        In the order of `LIMITS`.
    left_out : tuple of str
        A line for every bar that could not be measured here.
    shown : tuple of str
        What has no bar: the biases of allocations that round without chance.
    """

    bars: tuple[Bar, ...]
    left_out: tuple[str, ...]
    shown: tuple[str, ...]

    @property
    def is_kept(self) -> bool:
        """Whether every bar that was measured is kept."""
        return all(bar.is_kept for bar in self.bars)


def speed_bars(run: SpeedRun) -> tuple[list[Bar], list[str]]:
    """Bars of a speed run, and a line for each that lacks a contender."""
    wanted = (
        ("patch order against numpy multinomial + repeat", MULTINOMIAL, "patch-order"),
        ("default against numpy choice", CHOICE, "default"),
        ("default against Mitsuba 3", MITSUBA, "default"),
        ("one photon per call of a numba host against the default", HOST, "default"),
    )
    bars, left_out = [], list(run.left_out)
    for name, slow, fast in wanted:
        found = run.ratio(slow, fast)
        if found is not None:
            detail = f"{run.ns_per_photon(slow):.2f} / {run.ns_per_photon(fast):.2f} ns"
            bars.append(Bar(name=name, value=found, detail=detail))
    return bars, left_out


def thread_bars(n_photons: int, turns: int) -> tuple[list[Bar], list[str]]:
    """What a second thread gives, beside what two processes show that the machine can give."""
    names = ("two threads against one", "two threads against two processes that share nothing")
    if (os.cpu_count() or 1) < 2:
        return [], [f"{name} is left out: this machine has one core" for name in names]
    times = threads.thread_times(speed_source(bench_sky("clear-uniform"), "default", n_photons), turns)
    by_threads = ratio(times[threads.ONE], times[threads.TWO_THREADS])
    by_processes = 2 * ratio(times[threads.ONE], times[threads.TWO_PROCESSES])
    detail = f"two processes of one thread do the work of {by_processes:.2f}"
    values = (by_threads, by_threads / by_processes)
    return [Bar(name=name, value=value, detail=detail) for name, value in zip(names, values, strict=True)], []


def _gain(rows: list[Row], better: str, quantity: str) -> tuple[float, str]:
    """How many times larger the error of independent photons is."""
    by_method = {row.method: row.error[quantity] for row in rows}
    return by_method["iid"] / by_method[better], f"{by_method['iid']:.2g} / {by_method[better]:.2g}"


def error_bars(sizes: CheckSizes, seed: int) -> list[Bar]:
    """Bars of the errors on the Perez clear sky."""
    n, replicates = sizes.error_photons, sizes.error_replicates

    def rows(sky: str, methods: tuple[str, ...], n_photons: int) -> list[Row]:
        chosen = [METHODS[name] for name in methods]
        return measure_errors(bench_sky(sky), chosen, n_photons, replicates=replicates, seed=seed, precision="float32")

    exact = rows("clear", ("default", "iid"), n)
    bars = []
    for quantity, title in (("planar", "planar irradiance"), ("cone", "cone"), ("histogram", "histogram")):
        value, detail = _gain(exact, "default", quantity)
        bars.append(Bar(name=f"{title}, independent photons against default", value=value, detail=detail))
    value, detail = _gain(rows("clear-uniform", ("default", "iid"), n), "default", "planar")
    bars.append(Bar(name="planar irradiance, within patches uniform", value=value, detail=detail))
    return bars


def shown_biases(seed: int) -> list[str]:
    """Lines on allocations that round without chance: their bias stays whatever the seed."""
    lines = []
    for name in ("largest-remainder", "aomc"):
        for n in (10_000, 1_000_000):
            (row,) = measure_errors(
                bench_sky("clear"), [METHODS[name]], n, replicates=8, seed=seed, precision="float32"
            )
            parts = ", ".join(f"{q} {100 * row.bias[q]:+.3g} %" for q in ("planar", "scalar", "cone", "ring"))
            lines.append(f"bias of {METHODS[name].title}, {n} photons: {parts}")
    return lines


def _memory_bar(few: int, many: int) -> Bar:
    """Growth of the peak memory of a process that streams photons; a first one fills the cache of compiled kernels."""
    streamed_peak(1)
    small, large = streamed_peak(few) / 1e6, streamed_peak(many) / 1e6
    detail = f"{small:.0f} MB at {few:.0e}, {large:.0f} MB at {many:.0e} photons"
    return Bar(name="growth of a streamed run's memory [MB]", value=large - small, detail=detail)


def run_check(sizes: CheckSizes, *, seed: int = 1) -> Check:
    """Measure every bar.

    Parameters
    ----------
    sizes : CheckSizes
        How much is measured.
    seed : int
        First seed of the errors.

    Returns
    -------
    Check
        Times come from one run with contenders in turns, errors from replicates.
    """
    expect_photons(10**12)  # compiled kernels from the first photon on
    bars, left_out = speed_bars(measure_speed(bench_sky("clear-uniform"), sizes.speed_photons, sizes.speed_turns))
    more, missing = thread_bars(sizes.thread_photons, sizes.thread_turns)
    bars, left_out = bars + more, left_out + missing
    bars.append(_memory_bar(*sizes.memory_photons))
    mcpl = mcpl_times(sizes.mcpl_photons, 3)
    if mcpl is None:
        left_out.append("the bar of MCPL is left out: the package mcpl is not installed (pip install mcpl)")
    else:
        bars.append(
            Bar(name="MCPL writer against a ctypes loop over libmcpl", value=ratio(mcpl["libmcpl"], mcpl["packed"]))
        )
    return Check(bars=(*bars, *error_bars(sizes, seed)), left_out=tuple(left_out), shown=tuple(shown_biases(seed)))
