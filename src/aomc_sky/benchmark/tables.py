"""The tables of a run; the writer decides whether they are for a terminal or in Markdown."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from aomc_sky.benchmark.methods import METHODS
from aomc_sky.benchmark.quantities import QUANTITIES, TITLES
from aomc_sky.benchmark.run import BenchResults
from aomc_sky.benchmark.speed import SpeedRun
from aomc_sky.benchmark.trends import TARGETS, Found, Reach

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
        parts += [f"\n{run.n_photons} photons of a table, float32 unless told, median of {run.turns} turns"]
        parts += [speed_table(run, write), *run.left_out]
    return "\n".join(parts)
