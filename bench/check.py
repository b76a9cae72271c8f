"""The bars: what speed and error must keep, as ratios measured in one run on the machine at hand.

    python bench/check.py [--photons 1e5] [--replicates 4] [--turns 1]

Exits with 1 when a bar is missed. A peer that is not installed is named as left out, with its bar.
"""

from __future__ import annotations

import argparse
import dataclasses
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from aomc_sky.errors import OutputError
from aomc_sky.kernels.backend import announce_photons
from bench.accuracy import Row, measure_errors
from bench.harness import count, guarded, machine, markdown_table
from bench.peers import HOST, MITSUBA, MULTINOMIAL, TWO_THREADS, measure_peers
from bench.samplers import CHOICE, METHODS, SpeedRun
from bench.skies import PEER_SKY, bench_sky

ROOT = Path(__file__).resolve().parents[1]
LIMITS = {
    "patch order against numpy multinomial + repeat": 40.0,
    "default against numpy choice": 20.0,
    "default against Mitsuba 3": 2.4,
    "two threads against one": 1.9,
    "one photon per call of a numba host against the default": 6.0,
    "growth of a streamed run's memory [MB]": 50.0,
    "planar irradiance, independent photons against default": 40.0,
    "cone, independent photons against default": 4.0,
    "histogram, independent photons against default": 6.0,
    "planar irradiance, within patches uniform": 300.0,
}
"""What `main` compares with, by name."""
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


@dataclass(frozen=True, kw_only=True, slots=True)
class CheckSizes:
    """How much a check measures."""

    #: So many that the start of a thread does not count.
    speed_photons: int = 10_000_000
    speed_turns: int = 7
    error_photons: int = 1_000_000
    error_replicates: int = 64
    #: Of the short and of the long streamed run.
    memory_photons: tuple[int, int] = (1_000_000, 1_000_000_000)


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


def speed_bars(run: SpeedRun) -> list[Bar]:
    """Bars of a speed run; one that lacks a contender is left out."""
    ratios = (
        ("patch order against numpy multinomial + repeat", MULTINOMIAL, "patch-order"),
        ("default against numpy choice", CHOICE, "default"),
        ("default against Mitsuba 3", MITSUBA, "default"),
        ("two threads against one", "default", TWO_THREADS),
        ("one photon per call of a numba host against the default", HOST, "default"),
    )
    bars = []
    for name, slow, fast in ratios:
        found = run.ratio(slow, fast)
        if found is not None:
            detail = f"{run.ns_per_photon(slow):.2f} / {run.ns_per_photon(fast):.2f} ns"
            bars.append(Bar(name=name, value=found, detail=detail))
    return bars


def _gain(rows: list[Row], better: str, quantity: str) -> tuple[float, str]:
    """How many times larger the error of independent photons is."""
    by_method = {row.method: row.error[quantity] for row in rows}
    return by_method["iid"] / by_method[better], f"{by_method['iid']:.2g} / {by_method[better]:.2g}"


def error_bars(sizes: CheckSizes, seed: int = 1) -> list[Bar]:
    """Bars of the errors on the Perez clear sky."""

    def rows(sky: str) -> list[Row]:
        chosen = [METHODS[name] for name in ("default", "iid")]
        common = {"replicates": sizes.error_replicates, "seed": seed}
        return measure_errors(bench_sky(sky), chosen, sizes.error_photons, **common)

    exact = rows("clear")
    bars = []
    for quantity, title in (("planar", "planar irradiance"), ("cone", "cone"), ("histogram", "histogram")):
        value, detail = _gain(exact, "default", quantity)
        bars.append(Bar(name=f"{title}, independent photons against default", value=value, detail=detail))
    value, detail = _gain(rows("clear-uniform"), "default", "planar")
    bars.append(Bar(name="planar irradiance, within patches uniform", value=value, detail=detail))
    return bars


def shown_biases() -> list[str]:
    """Lines on allocations that round without chance: their bias stays whatever the seed."""
    lines = []
    for name in ("largest-remainder", "aomc"):
        for n in (10_000, 1_000_000):
            (row,) = measure_errors(bench_sky("clear"), [METHODS[name]], n, replicates=8)
            parts = ", ".join(f"{q} {100 * row.bias[q]:+.3g} %" for q in ("planar", "scalar", "cone", "ring"))
            lines.append(f"bias of {METHODS[name].title}, {n} photons: {parts}")
    return lines


_STREAM = """
import sys
sys.path.insert(0, sys.argv[2])
from aomc_sky.kernels.backend import announce_photons
from bench.samplers import buffer_of, drain
from bench.skies import bench_sky
announce_photons(10**12)  # the same code for few photons and for many
source = bench_sky("clear-uniform").scene(int(sys.argv[1])).source(seed=1)
drain(source, buffer_of(source))
lines = open("/proc/self/status").read().splitlines()
print(next(1024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM:")))
"""


def streamed_peak(n_photons: int) -> int:
    """Peak memory of a process of its own that emits photons of the clear sky's table into reused buffers. [bytes]"""
    command = [sys.executable, "-c", _STREAM, str(n_photons), str(ROOT)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise OutputError(f"a streamed run of {n_photons} photons ended with {done.returncode}: {last}")
    return int(done.stdout)


def _memory_bar(few: int, many: int) -> Bar:
    """Growth of the peak memory of a process that streams photons; a first one fills the cache of compiled kernels."""
    streamed_peak(1)
    small, large = streamed_peak(few) / 1e6, streamed_peak(many) / 1e6
    detail = f"{small:.0f} MB at {few:.0e}, {large:.0f} MB at {many:.0e} photons"
    return Bar(name="growth of a streamed run's memory [MB]", value=large - small, detail=detail)


def run_check(sizes: CheckSizes) -> Check:
    """Measure every bar: times in one run with contenders in turns, errors from replicates."""
    announce_photons(10**12)  # compiled kernels from the first photon on
    run = measure_peers(bench_sky(PEER_SKY), sizes.speed_photons, sizes.speed_turns)
    bars = [*speed_bars(run), _memory_bar(*sizes.memory_photons), *error_bars(sizes)]
    return Check(bars=tuple(bars), left_out=run.left_out, shown=tuple(shown_biases()))


def bar_table(check: Check) -> str:
    """Every bar with its value and whether it is kept."""
    rows = [
        (
            bar.name,
            f"{bar.value:.2f}",
            f"{'<=' if bar.name in AT_MOST else '>='} {bar.limit:g}",
            "kept" if bar.is_kept else "MISSED",
            bar.detail,
        )
        for bar in check.bars
    ]
    return markdown_table(rows, ("bar", "measured", "limit", "", "behind it"))


def sizes_of(photons: int | None, turns: int | None, replicates: int | None) -> CheckSizes:
    """The usual sizes of a check, or smaller ones for a machine or a test in a hurry."""
    sizes = CheckSizes()
    if photons:
        sizes = CheckSizes(speed_photons=photons, error_photons=photons, memory_photons=(photons, 10 * photons))
    changed = {"speed_turns": turns, "error_replicates": replicates}
    return dataclasses.replace(sizes, **{name: value for name, value in changed.items() if value is not None})


@guarded
def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--photons", type=count, metavar="N", help="of every measurement, also as 1e5")
    parser.add_argument("--turns", type=count, metavar="T", help="turns behind every time")
    parser.add_argument("--replicates", type=count, metavar="R", help="runs behind every error")
    options = parser.parse_args(argv)
    print(machine())
    check = run_check(sizes_of(options.photons, options.turns, options.replicates))
    print("\n".join([bar_table(check), *check.left_out, *check.shown]))
    missed = [bar.name for bar in check.bars if not bar.is_kept]
    if missed:
        print(f"{len(missed)} of {len(check.bars)} bars are missed: {'; '.join(missed)}", file=sys.stderr)
    return 0 if check.is_kept else 1


if __name__ == "__main__":
    raise SystemExit(main())
