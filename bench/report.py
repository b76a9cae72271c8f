"""Speed against error of this version beside its peers, and the bars: a page in Markdown, a picture and numbers.

    python bench/report.py [FILE] [--photons 1e3 1e5] [--replicates 4] [--turns 1]

Writes FILE (default performance.md) and the same name with .png and .csv; takes a few minutes. Exits with 1 when
a bar is missed; `python bench/check.py` measures the bars alone. The table under "Peers" is that of docs/accuracy.md;
docs/figures/draw_readme.py draws the numbers.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from aomc_sky.errors import UsageError
from aomc_sky.extras import optional_module
from aomc_sky.formats.text_file import write_atomically
from aomc_sky.kernels.backend import announce_photons
from bench.accuracy import TARGETS, Found, Reach, Row, Trend, measure_errors, measure_times, trends
from bench.check import Check, bar_table, run_check, sizes_of
from bench.figure import plot
from bench.harness import count, guarded, machine, markdown_table, ratio
from bench.peers import measure_peers
from bench.quantities import QUANTITIES, TITLES
from bench.samplers import BATCH, METHODS, SpeedRun
from bench.skies import PEER_SKY, SKIES, bench_sky

ROOT = Path(__file__).resolve().parents[1]
SPEED_PHOTONS = 10**6
_SHOWN_PHOTONS = 10**6
CSV_COLUMNS = (
    *("sky", "method", "n_photons", "replicates", "plan_s", "emit_s", "ns_per_photon"),
    *(f"error_{quantity}" for quantity in QUANTITIES),
    *(f"bias_{quantity}" for quantity in QUANTITIES if quantity != "histogram"),
)
SPEED_COLUMNS = ("sampler", "times the default", *QUANTITIES)
"""The head of the one table of docs/accuracy.md."""

_HEAD = """\
# Speed against error

This page is one run of one program. In the repository `python bench/report.py` makes it again, with the picture and the
numbers beside it ({csv}); `python bench/check.py` measures the bars alone and exits with 1 when one is missed.

Machine: {machine}.

Times depend on the machine, ratios much less. Contenders take turns, so that all see the same machine; a time is the
median of the turns, a ratio the median of the ratios inside a turn. One turn more comes first and does not count.
Everything runs on one thread unless stated otherwise, kernels are compiled and loaded beforehand.
"""

_SKIES_CAPTION = """\
Rows are skies, columns quantities, and all panels have the same axes. One line per method, one point per number of
photons; lower and further left is better. The time of the first points is that of the plan. numpy's `choice` and
Mitsuba 3 have the error of independent photons at the time that their measured rate gives.
"""

_COLUMNS = """\
## What the columns mean

Photons follow the flux law, so a share of the photons is a share of the planar irradiance.

{quantities}

- An error is the relative root mean square error over independent runs (*runs*), each with a seed of its own. For the
  bins it is the Euclidean norm of the error over that of the truth. For scalar irradiance it is the median of the
  absolute error: the mean of 1/mu has no variance, so a mean square means nothing there, and no slope is given.
- The cone, the ring and the bins do not coincide with edges of patches, on which stratified photons are exact.
- A launch without any photon has the error 1. AOMC's rounding does that where photons are few.
- Exact values are sums over patches, or quadratures at two orders whose difference is their stated error.
- *plan* is the time to settle the counts, *emit* the time to emit all photons into reused buffers of {batch} photons,
  *ns* the second per photon.
- The time to reach 1 % or 0.01 % holds plan and photons, between the runs that were measured. `~`: beyond the largest
  run, along the slope of the last three. `<`: the smallest run is better already. `never`: the error has met a floor,
  for that slope is above -0.2, or the error is all bias and its last step is that flat.

Methods: {methods}. AOMC's rounding and the peers know patches alone; they get a continuous sky as masses of 90 x 360
patches. Patch order emits the photons of the default in another order, so its errors are the same.
"""

_PEERS = """\
Ours settle the counts beforehand, as scipy and Mitsuba set up their tables; numpy's functions have no such step. Ours
and the stores fill reused buffers; numpy and scipy return new arrays, as they always do; Mitsuba reuses its own memory.
numpy runs as one writes it first, in float64, and tuned to float32 throughout. Every peer places its photons uniformly
in their patches and turns them into unit vectors. Patch and place are drawn independently, so a peer's error is that of
`iid`. Ours write the number of the patch too, 16 bytes per photon in float32; the limit by stores is plain writing of
12 or 24 bytes.
"""


@dataclass(frozen=True, kw_only=True, slots=True)
class Sizes:
    """How much a report measures."""

    skies: tuple[str, ...] = SKIES
    photons: tuple[int, ...] = (10**3, 10**4, 10**5, 10**6, 10**7)
    #: Independent runs behind an error, at most: fewer, never below 4, where photons are many; None: 64 at most.
    replicates: int | None = None
    #: Turns of every time; from a million photons on three are enough.
    turns: int = 5

    def replicates_of(self, n_photons: int) -> int:
        """Replicates at one number of photons."""
        return self.replicates or int(min(64, max(4, 1.6e7 / n_photons)))


@dataclass(frozen=True, kw_only=True, slots=True)
class Results:
    """What was measured."""

    machine: str
    #: Every method on every sky at every number of photons.
    rows: list[Row]
    #: Relative error of the exact values, by sky and quantity.
    truth_error: dict[str, dict[str, float]]
    #: Slopes and times to reach an error.
    trends: list[Trend]
    #: Peers and methods on one table; None: not measured.
    speed: SpeedRun | None


def measure(sizes: Sizes) -> Results:
    """Measure errors, times and peers, compiled from the first photon on."""
    before, methods = machine(), list(METHODS.values())
    announce_photons(10**12)
    rows: list[Row] = []
    truth_error = {}
    for name in sizes.skies:
        sky = bench_sky(name)
        truth_error[name] = dict(sky.truth.error)
        for n in sizes.photons:
            found = measure_errors(sky, methods, n, replicates=sizes.replicates_of(n))
            turns = min(sizes.turns, 3) if n >= 10**6 else sizes.turns
            rows += measure_times(sky, found, methods, turns=turns)
    speed = measure_peers(bench_sky(PEER_SKY), min(SPEED_PHOTONS, max(sizes.photons)), sizes.turns)
    return Results(machine=before, rows=rows, truth_error=truth_error, trends=trends(rows), speed=speed)


def csv_text(rows: Sequence[Row]) -> str:
    """One line per row, columns as `CSV_COLUMNS`; an unknown number is empty."""
    lines = [",".join(CSV_COLUMNS)]
    for row in rows:
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


def error_table(rows: Sequence[Row]) -> str:
    """Errors, times and speed of all methods on one sky at one number of photons."""
    texts = [
        (
            row.method,
            short_count(row.n_photons),
            str(row.replicates),
            *("-" if math.isnan(row.error[q]) else f"{row.error[q]:.1e}" for q in QUANTITIES),
            _time(row.plan_s),
            _time(row.emit_s),
            f"{row.ns_per_photon:.2f}",
            f"{1e3 / row.ns_per_photon:.0f}",
        )
        for row in rows
    ]
    return markdown_table(texts, ("method", "photons", "runs", *QUANTITIES, "plan", "emit", "ns", "million/s"))


def _reached(reach: Reach) -> str:
    """How long an error takes."""
    if reach.found is Found.NEVER:
        return "never"
    mark = {Found.BETWEEN: "", Found.AT_MOST: "< ", Found.BEYOND: "~ "}[reach.found]
    return f"{mark}{_time(reach.seconds)}"


def trend_table(own: Sequence[Trend]) -> str:
    """Slopes and times to reach 1 % and 0.01 % on one sky."""
    quantities = [quantity for quantity in QUANTITIES if any(t.quantity == quantity for t in own)]
    rows = []
    for method in dict.fromkeys(trend.method for trend in own):
        by_quantity = {trend.quantity: trend for trend in own if trend.method == method}
        slopes = [f"{by_quantity[q].slope:.2f}" for q in quantities]
        times = [_reached(by_quantity[q].reach[k]) for k in range(len(TARGETS)) for q in quantities]
        rows.append((method, *slopes, *times))
    names = [f"{q} {100 * target:g} %" for target in TARGETS for q in quantities]
    return markdown_table(rows, ("method", *(f"slope {q}" for q in quantities), *names))


def speed_table(run: SpeedRun, rows: Sequence[Row]) -> str:
    """Everybody's time over the default's, and the errors on the peers' sky, where the peers have those of `iid`."""
    sky_rows = [row for row in rows if row.sky == PEER_SKY and row.n_photons == run.n_photons]
    errors = {row.method: tuple(f"{row.error[q]:.1e}" for q in QUANTITIES) for row in sky_rows}
    nothing = ("-",) * len(QUANTITIES)
    texts = []
    times = {name: ratio(own, run.times["default"]) for name, own in run.times.items()}
    for name, times_default in sorted(times.items(), key=lambda one: one[1]):
        drawn = nothing if name.startswith("stores") else errors.get("iid", nothing)
        texts.append((name, f"{times_default:.2f}", *errors.get(name.partition(",")[0], drawn)))
    return markdown_table(texts, SPEED_COLUMNS)


def page_text(results: Results, check: Check, picture: str, numbers: str) -> str:
    """The page as Markdown."""
    quantities = "\n".join(f"- **{name}**: {title}." for name, title in TITLES.items())
    methods = "; ".join(f"`{method.name}` is {method.title}" for method in METHODS.values())
    bars = ["## The bars", "", bar_table(check), "", *(f"- {line}" for line in check.left_out)]
    bars += [*(f"- Shown, no bar: {line}." for line in check.shown), ""]
    parts = [
        _HEAD.format(machine=results.machine, csv=f"`{numbers}`"),
        "\n".join(bars),
        f"## Every sky and quantity\n\n![Error against time, a row for each sky]({picture})\n\n{_SKIES_CAPTION}",
        _COLUMNS.format(quantities=quantities, methods=methods, batch=BATCH),
        *(_sky(results, sky) for sky in dict.fromkeys(row.sky for row in results.rows)),
    ]
    run = results.speed
    if run is not None:
        parts.append(
            f"## Peers, {short_count(run.n_photons)} photons of a table\n\n"
            f"Median of the ratios of {run.turns} turns, float32 unless the name says otherwise. The default takes "
            f"{run.ns_per_photon('default'):.2f} ns per photon.\n\n"
            f"{speed_table(run, results.rows)}\n\n{_PEERS}"
        )
        parts += [f"{line}\n" for line in run.left_out]
    return "\n".join(parts)


def _sky(results: Results, sky: str) -> str:
    own = [row for row in results.rows if row.sky == sky]
    n = max((row.n_photons for row in own if row.n_photons <= _SHOWN_PHOTONS), default=own[0].n_photons)
    truth = ", ".join(f"{quantity} {error:.0e}" for quantity, error in results.truth_error[sky].items())
    lines = [
        f"## Sky: {bench_sky(sky).title}",
        "",
        f"`{sky}`, {short_count(n)} photons; exact values are known to {truth}.",
        "",
        error_table([row for row in own if row.n_photons == n]),
        "",
    ]
    sky_rows = [trend for trend in results.trends if trend.sky == sky]
    if sky_rows:
        lines += ["Slopes over all numbers of photons, and time to reach an error:", "", trend_table(sky_rows), ""]
    return "\n".join(lines)


def write_page(results: Results, check: Check, path: Path) -> list[Path]:
    """Write the page, its picture and its numbers; all three are returned."""
    picture, numbers = path.with_suffix(".png"), path.with_suffix(".csv")
    plot(results.rows, results.speed, picture)
    write_atomically(numbers, csv_text(results.rows))
    write_atomically(path, page_text(results, check, picture.name, numbers.name))
    return [path, picture, numbers]


@guarded
def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, nargs="?", default=Path("performance.md"), metavar="FILE", help="the page")
    parser.add_argument("--skies", nargs="+", choices=SKIES, default=SKIES, help="only these skies")
    parser.add_argument("--photons", nargs="+", type=count, metavar="N", help="numbers of photons, also as 1e6")
    parser.add_argument("--replicates", type=count, metavar="R", help="runs behind every error")
    parser.add_argument("--turns", type=count, metavar="T", help="turns behind every time")
    options = parser.parse_args(argv)
    if not options.file.absolute().parent.is_dir():
        raise UsageError(f"the folder of {options.file} does not exist")
    optional_module("matplotlib", extra="plot")  # not after all the measurements
    sizes = Sizes(
        skies=tuple(options.skies),
        photons=tuple(sorted(options.photons or Sizes().photons)),
        replicates=options.replicates,
        turns=options.turns or Sizes().turns,
    )
    results = measure(sizes)
    check = run_check(sizes_of(options.photons and max(options.photons), options.turns, options.replicates))
    for path in write_page(results, check, options.file):
        print(path)
    return 0 if check.is_kept else 1


if __name__ == "__main__":
    raise SystemExit(main())
