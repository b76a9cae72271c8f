"""The bars: what speed and error must keep, as ratios measured in one run on the machine at hand.

    python bench/check.py [--photons 1e5] [--replicates 4] [--turns 1] [--seed 1] [--json]

Exits with 1 when a bar is missed. A peer that is not installed is named as left out, with its bar.
"""

from __future__ import annotations

import argparse
import dataclasses
import functools
import json
import os
import sys
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from aomc_sky.benchmark.accuracy import Row, measure_errors
from aomc_sky.benchmark.run import Writer
from aomc_sky.benchmark.samplers import CHOICE, METHODS, SpeedRun, speed_source
from aomc_sky.benchmark.skies import bench_sky
from aomc_sky.benchmark.timing import machine_now, ratio
from aomc_sky.cli import options as cli_options
from aomc_sky.cli.terminal import table
from aomc_sky.errors import UsageError
from aomc_sky.kernels.backend import announce_photons
from bench import threads
from bench.harness import guarded
from bench.mcpl import mcpl_times
from bench.peers import HOST, MITSUBA, MULTINOMIAL, measure_peers
from bench.streamed import streamed_peak

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
    """A measured value beside what it must keep."""

    #: A key of `LIMITS`.
    name: str
    #: The ratio, or megabytes.
    value: float
    #: What stood behind it, for a person.
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
    """How much a check measures."""

    speed_photons: int = 4_000_000
    speed_turns: int = 7
    #: So many that the start of a thread does not count.
    thread_photons: int = 10_000_000
    thread_turns: int = 15
    error_photons: int = 1_000_000
    error_replicates: int = 64
    #: Of the short and of the long streamed run.
    memory_photons: tuple[int, int] = (1_000_000, 1_000_000_000)
    mcpl_photons: int = 1_000_000


@dataclass(frozen=True, kw_only=True, slots=True)
class Check:
    """All bars of a run."""

    #: In the order of `LIMITS`.
    bars: tuple[Bar, ...]
    #: A line for every bar that could not be measured here.
    left_out: tuple[str, ...]
    #: What has no bar: the biases of allocations that round without chance.
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
    """Measure every bar: times in one run with contenders in turns, errors from replicates."""
    announce_photons(10**12)  # compiled kernels from the first photon on
    bars, left_out = speed_bars(measure_peers(bench_sky("clear-uniform"), sizes.speed_photons, sizes.speed_turns))
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


def bar_table(check: Check, write: Writer) -> str:
    """Every bar with its value and whether it is kept."""
    rows = [
        (
            bar.name,
            f"{bar.value:.2f}",
            f"{bar.relation} {bar.limit:g}",
            "kept" if bar.is_kept else "MISSED",
            bar.detail,
        )
        for bar in check.bars
    ]
    return write(rows, ("bar", "measured", "limit", "", "behind it"))


def check_text(check: Check, write: Writer) -> str:
    """The bars for a terminal."""
    return "\n".join([bar_table(check, write), *check.left_out, *check.shown])


def sizes_of(photons: int | None, turns: int | None, replicates: int | None) -> CheckSizes:
    """The usual sizes of a check, or smaller ones for a machine or a test in a hurry."""
    if any(n is not None and n < 1 for n in (turns, replicates)):
        raise UsageError("replicates and turns must be at least 1")
    sizes = CheckSizes()
    if photons:
        sizes = CheckSizes(
            speed_photons=photons,
            thread_photons=photons,
            error_photons=photons,
            mcpl_photons=photons,
            memory_photons=(photons, 10 * photons),
        )
    changed = {"speed_turns": turns, "thread_turns": turns, "error_replicates": replicates}
    return dataclasses.replace(sizes, **{name: value for name, value in changed.items() if value is not None})


def as_json(check: Check, machine: str) -> dict[str, object]:
    """The bars as JSON values."""
    bars = [
        {"name": b.name, "value": b.value, "limit": b.limit, "relation": b.relation, "kept": b.is_kept}
        for b in check.bars
    ]
    return {"machine": machine, "bars": bars, "left_out": check.left_out, "kept": check.is_kept}


@guarded
def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--photons", type=cli_options.photon_total, metavar="N", help="of every measurement, as 1e5")
    parser.add_argument("--turns", type=cli_options.whole_number, metavar="T", help="turns behind every time")
    parser.add_argument("--replicates", type=cli_options.whole_number, metavar="R", help="runs behind every error")
    parser.add_argument("--seed", type=cli_options.seed, default=1, metavar="INT", help="first seed (default 1)")
    parser.add_argument("--json", action="store_true", help="one JSON object instead of the table")
    options = parser.parse_args(argv)
    machine = machine_now()
    check = run_check(sizes_of(options.photons, options.turns, options.replicates), seed=options.seed)
    if options.json:
        print(json.dumps(as_json(check, machine)))
    else:
        print(f"{machine}\n{check_text(check, functools.partial(table, n_left=1))}")
    missed = [bar.name for bar in check.bars if not bar.is_kept]
    if missed:
        print(f"{len(missed)} of {len(check.bars)} bars are missed: {'; '.join(missed)}", file=sys.stderr)
    return 0 if check.is_kept else 1


if __name__ == "__main__":
    raise SystemExit(main())
