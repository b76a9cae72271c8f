"""A run of the benchmark: what is measured, the results, their tables, and how they are stored."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from aomc_sky.benchmark.accuracy import TARGETS, Found, Reach, Row, Trend, measure_errors, measure_times, trends
from aomc_sky.benchmark.quantities import QUANTITIES, TITLES
from aomc_sky.benchmark.samplers import METHODS, SpeedRun, chosen_methods, measure_speed
from aomc_sky.benchmark.skies import SKIES, BenchSky, bench_sky
from aomc_sky.benchmark.timing import machine_now, versions
from aomc_sky.errors import UsageError
from aomc_sky.kernels.backend import announce_photons
from aomc_sky.sampling.allocation import MAX_PHOTONS

FEWEST_REPLICATES = 4
PEER_SKY = "clear-uniform"
EVERYTHING = 10**12
"""Photons that a benchmark announces, so that compiled kernels make the first ones too."""

CSV_COLUMNS = (
    *("sky", "method", "n_photons", "replicates", "plan_s", "emit_s", "ns_per_photon"),
    *(f"error_{quantity}" for quantity in QUANTITIES),
    *(f"bias_{quantity}" for quantity in QUANTITIES if quantity != "histogram"),
)


@dataclass(frozen=True, kw_only=True, slots=True)
class BenchOptions:
    """What a run measures."""

    #: skies, methods: Names; none: all.
    skies: tuple[str, ...] = ()
    methods: tuple[str, ...] = ()
    photons: tuple[int, ...] = (10**3, 10**4, 10**5, 10**6)
    #: Independent runs behind an error, at most.
    replicates: int = 64
    #: Photons of all replicates of one error: fewer replicates, never below 4, where photons are many.
    total_photons: float = 1.6e7
    #: Turns of every time.
    turns: int = 5
    #: Numbers of photons for the table of peers; none: no such table.
    speed_photons: tuple[int, ...] = (10**6,)
    seed: int = 1
    #: Of the directions. One of "float32", "float64".
    precision: str = "float32"

    def __post_init__(self) -> None:
        if not self.photons or not all(1 <= n <= MAX_PHOTONS for n in (*self.photons, *self.speed_photons)):
            raise UsageError("the numbers of photons must be whole numbers from 1 to 2^62")
        if self.replicates < 1 or self.turns < 1:
            raise UsageError("replicates and turns must be at least 1")
        chosen_methods(self.methods)
        unknown = [name for name in self.skies if name not in SKIES]
        if unknown:
            raise UsageError(f"there is no sky {unknown[0]!r}; skies are {', '.join(SKIES)}")

    def replicates_of(self, n_photons: int) -> int:
        """Replicates at one number of photons."""
        affordable = max(FEWEST_REPLICATES, self.total_photons / n_photons)
        return int(min(self.replicates, affordable))

    def turns_of(self, n_photons: int) -> int:
        """Turns of a time at one number of photons: from a million on three are enough."""
        return min(self.turns, 3) if n_photons >= 10**6 else self.turns


PRESETS = {
    "quick": BenchOptions(
        skies=("uniform", "clear"), photons=(10**3, 10**4, 10**5), replicates=16, turns=3, speed_photons=(10**6,)
    ),
    "default": BenchOptions(photons=(10**3, 10**4, 10**5, 10**6, 10**7)),
    "full": BenchOptions(
        photons=(10**3, 10**4, 10**5, 10**6, 10**7), total_photons=1.6e8, turns=9, speed_photons=(10**6, 10**7)
    ),
}


@dataclass(frozen=True, kw_only=True, slots=True)
class BenchResults:
    """What a run found."""

    options: BenchOptions
    #: Processor, cores, versions, and the load before the run.
    machine: str
    #: Every method on every sky at every number of photons.
    rows: tuple[Row, ...]
    #: Relative error of the exact values, by sky and quantity.
    truth_error: dict[str, dict[str, float]]
    #: Slopes and times to reach an error.
    trends: tuple[Trend, ...]
    #: Peers and methods on one table.
    speed: tuple[SpeedRun, ...]


def run_bench(
    options: BenchOptions,
    progress: Callable[[int, int], None] | None = None,
    speed_of: Callable[[BenchSky, int, int], SpeedRun] = measure_speed,
) -> BenchResults:
    """Measure errors and times; `progress` is called with (steps done, steps in all), `speed_of` times the samplers."""
    methods = chosen_methods(options.methods)
    before = machine_now()
    announce_photons(EVERYTHING)
    names = [name for name in SKIES if not options.skies or name in options.skies]
    n_steps = len(names) * len(options.photons) + len(options.speed_photons)
    report = progress or (lambda done, total: None)
    rows: list[Row] = []
    truth_error = {}
    done = 0
    for name in names:
        sky = bench_sky(name)
        truth_error[name] = dict(sky.truth.error)
        for n in options.photons:
            report(done, n_steps)
            common: dict[str, Any] = {"seed": options.seed, "precision": options.precision}
            found = measure_errors(sky, methods, n, replicates=options.replicates_of(n), **common)
            rows += measure_times(sky, found, methods, turns=options.turns_of(n), **common)
            done += 1
    speed = []
    for n in options.speed_photons:
        report(done, n_steps)
        speed.append(speed_of(bench_sky(PEER_SKY), n, options.turns))
        done += 1
    report(done, n_steps)
    return BenchResults(
        options=options,
        machine=before,
        rows=tuple(rows),
        truth_error=truth_error,
        trends=tuple(trends(rows)),
        speed=tuple(speed),
    )


def csv_text(results: BenchResults) -> str:
    """One line per row, columns as `CSV_COLUMNS`; an unknown number is empty."""
    lines = [",".join(CSV_COLUMNS)]
    for row in results.rows:
        values: dict[str, Any] = {
            **{name: getattr(row, name) for name in CSV_COLUMNS[:7]},
            **{f"error_{quantity}": value for quantity, value in row.error.items()},
            **{f"bias_{quantity}": value for quantity, value in row.bias.items()},
        }
        lines.append(",".join(_cell(values[name]) for name in CSV_COLUMNS))
    return "\n".join(lines) + "\n"


def _cell(value: object) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.6g}"
    return str(value)


def results_json(results: BenchResults) -> dict[str, Any]:
    """The results as JSON values; infinities and NaN are null."""
    speed = [
        {
            "n_photons": run.n_photons,
            "turns": run.turns,
            "ns_per_photon": {name: run.ns_per_photon(name) for name in run.times},
            "left_out": list(run.left_out),
        }
        for run in results.speed
    ]
    whole = {
        "machine": results.machine,
        "versions": versions(),
        "options": dataclasses.asdict(results.options),
        "truth_error": results.truth_error,
        "rows": [dataclasses.asdict(row) for row in results.rows],
        "trends": [
            {**dataclasses.asdict(t), "reach": [{**dataclasses.asdict(r), "found": r.found.value} for r in t.reach]}
            for t in results.trends
        ],
        "speed": speed,
    }
    return _finite(whole)


def _finite(value: Any) -> Any:
    """The same values with null for numbers that JSON does not have."""
    if isinstance(value, dict):
        return {key: _finite(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


Writer = Callable[[Sequence[Sequence[str]], Sequence[str]], str]
"""Takes the rows and the heads of a table, returns its text."""


def _short(value: float) -> str:
    """Two digits."""
    return "-" if math.isnan(value) else f"{value:.1e}"


def short_count(n: float) -> str:
    """A number of photons: 1e6, 1048576, 3.2e7."""
    power = f"{n:.0e}".replace("e+0", "e").replace("e+", "e")
    if float(power) == n:
        return power
    return str(int(n)) if n < 1e7 else f"{n:.1e}".replace("e+0", "e").replace("e+", "e")


def _time(seconds: float) -> str:
    """A time in the unit that suits it."""
    for limit, factor, unit in ((1e-3, 1e6, "us"), (1.0, 1e3, "ms"), (600.0, 1.0, "s"), (36e3, 1 / 60, "min")):
        if seconds < limit:
            return f"{seconds * factor:.3g} {unit}"
    hours = seconds / 3600
    return f"{hours:.3g} h" if hours < 1e3 else f"{hours / 8766:.2g} years"


def error_table(results: BenchResults, sky: str, write: Writer, only: int | None = None) -> str:
    """Errors, times and speed of all methods on one sky, at all numbers of photons or at one."""
    order = list(METHODS)
    own = [row for row in results.rows if row.sky == sky and only in (None, row.n_photons)]
    rows = [
        (
            row.method,
            short_count(row.n_photons),
            str(row.replicates),
            *(_short(row.error[quantity]) for quantity in QUANTITIES),
            _time(row.plan_s),
            _time(row.emit_s),
            f"{row.ns_per_photon:.2f}",
            f"{1e3 / row.ns_per_photon:.0f}",
        )
        for row in sorted(own, key=lambda row: (order.index(row.method), row.n_photons))
    ]
    head = ("method", "photons", "runs", *QUANTITIES, "plan", "emit", "ns", "million/s")
    return write(rows, head)


def _reached(reach: Reach) -> str:
    """How long an error takes."""
    if reach.found is Found.NEVER:
        return "never"
    mark = {Found.BETWEEN: "", Found.AT_MOST: "< ", Found.BEYOND: "~ "}[reach.found]
    return f"{mark}{_time(reach.seconds)}"


def trend_table(results: BenchResults, sky: str, write: Writer) -> str:
    """Slopes and times to reach 1 % and 0.01 % on one sky."""
    own = [trend for trend in results.trends if trend.sky == sky]
    quantities = [quantity for quantity in QUANTITIES if any(t.quantity == quantity for t in own)]
    rows = []
    for method in dict.fromkeys(trend.method for trend in own):
        by_quantity = {trend.quantity: trend for trend in own if trend.method == method}
        slopes = [f"{by_quantity[q].slope:.2f}" for q in quantities]
        times = [_reached(by_quantity[q].reach[k]) for k in range(len(TARGETS)) for q in quantities]
        rows.append((method, *slopes, *times))
    names = [f"{q} {100 * target:g} %" for target in TARGETS for q in quantities]
    return write(rows, ("method", *(f"slope {q}" for q in quantities), *names))


def speed_table(run: SpeedRun, write: Writer) -> str:
    """Everybody's time per photon, and how many times that of the default."""
    rows = [
        (
            name,
            f"{run.ns_per_photon(name):.2f}",
            f"{1e3 / run.ns_per_photon(name):.1f}",
            f"{run.ratio(name, 'default') or math.nan:.2f}",
        )
        for name in sorted(run.times, key=run.ns_per_photon)
    ]
    return write(rows, ("sampler", "ns per photon", "million/s", "times the default"))


def results_text(results: BenchResults, write: Writer) -> str:
    """A whole run for a terminal."""
    parts = [results.machine, "", *(f"{name}: {title}" for name, title in TITLES.items())]
    for sky in dict.fromkeys(row.sky for row in results.rows):
        truth = ", ".join(f"{q} {e:.0e}" for q, e in results.truth_error[sky].items())
        parts += [f"\n{sky}: relative errors (exact values known to {truth})", error_table(results, sky, write)]
        if any(trend.sky == sky for trend in results.trends):
            parts += ["", trend_table(results, sky, write)]
    if results.trends:
        parts.append("\n~ extrapolated by the slope of the largest runs; < the smallest run is better already")
    for run in results.speed:
        parts += [
            f"\n{run.n_photons} photons of a table, float32 unless the name says otherwise, median of {run.turns} turns"
        ]
        parts += [speed_table(run, write), *run.left_out]
    return "\n".join(parts)
