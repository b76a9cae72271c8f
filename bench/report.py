"""The page on performance: a whole run and the bars in Markdown, its picture and its numbers beside it.

    python bench/report.py docs/performance.md [--preset default] [--photons 1e3 1e5] [--replicates 4] [--turns 1]

Writes FILE, and the same name with .png and .csv; takes minutes. Exits with 1 when a bar is missed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from aomc_sky.benchmark.figure import PEER_STYLES, plot_bench, plot_first
from aomc_sky.benchmark.quantities import TITLES
from aomc_sky.benchmark.run import (
    CSV_COLUMNS,
    PEER_SKY,
    BenchResults,
    csv_text,
    error_table,
    run_bench,
    short_count,
    speed_table,
    trend_table,
)
from aomc_sky.benchmark.samplers import BATCH, METHODS
from aomc_sky.benchmark.skies import bench_sky
from aomc_sky.cli.commands import bench as bench_command
from aomc_sky.errors import UsageError
from aomc_sky.extras import optional_module
from aomc_sky.formats.text_file import write_atomically
from aomc_sky.outputs.folder.target_file import check_target
from bench.check import Check, bar_table, run_check, sizes_of
from bench.harness import guarded
from bench.peers import MITSUBA, measure_peers

PEERS = {**PEER_STYLES, MITSUBA: ("Mitsuba 3", ("#999999", "--", "P"))}
"""Two peers that stand for all in the picture: what one writes first, and the best one."""
TITLE = "# Speed against error\n"
_SHOWN_PHOTONS = 10**6

_HEAD = f"""\
{TITLE}
This page is one run of one program. In the repository `python bench/report.py docs/performance.md` makes it again, with
the picture and the numbers beside it ({{csv}}); `python bench/check.py` measures the bars alone and exits with 1 when
one is missed. `aomc-sky bench` prints the tables of errors and times on any machine, with numpy's `choice` beside
every method.

Machine: {{machine}}.

Times depend on the machine, ratios much less. Contenders take turns, so that all see the same machine; a time is the
median of the turns, a ratio the median of the ratios inside a turn. One turn more comes first and does not count.
Everything runs on one thread unless stated otherwise, kernels are compiled and loaded beforehand.
"""

_CAPTION = """\
A clear sky, uniform within its patches: one line per method, one point per number of photons, 1e3 to 1e7; lower and
further left is better. The time of the first points is that of the plan. numpy's `choice` has the error of independent
photons at the time that its measured rate gives.
"""

_SKIES_CAPTION = """\
Rows are skies, columns quantities, and all panels have the same axes. Beside the table of the clear sky stand numpy's
`choice` and Mitsuba 3, as above.
"""

_GROWTH = """\
## How cost grows

![Time for each and peak memory against photons, patches, wavebands, shards and threads](growth.png)

`python bench/growth.py` measures this figure (`growth.csv`) in whole processes, start-up included, and draws it.
Above is processor time for one photon, patch, waveband or shard: it falls while start-up is shared, and the dashed
line is linear growth, the cheapest point for ever. Of threads it is the time by the clock times their number, which
would stay level if they never waited. Below is the peak memory of the process, with linear growth dashed.

- **Photons** cost some ten nanoseconds each at 1e9, and none is held: memory is that of the compiled kernels,
  which come with larger runs, and of blocks that wait for their turn. Beyond 2^32 photons in a waveband their ranks
  take 64 bits in place of 32: 1e10 cost 17 ns each, and the kernels for them 90 MB while they are compiled.
- **Patches** and **wavebands** grow linearly, to a million patches and to 2000 wavebands with a table each: some
  2.4 microseconds and 400 bytes a patch, files read and written; some two milliseconds and 90 kB a waveband.
- **Shards** read the scene and the plan each, some 46 ms beside the start of their process. They share a folder:
  when each asked for every file of all others, shards cost 40 ms in an empty folder and 69 ms among 700 others.
- **Threads** wait for each other as the bars above say; each takes about 6 MB.
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

_WHY = {
    "patch order against numpy multinomial + repeat": (
        "patch order spends its time on arithmetic in the vector units and on stores, numpy's on the sine and cosine "
        "of its library and on memory; the ratio falls where vectors are narrow or the memory is shared"
    ),
    "default against numpy choice": (
        "the default looks every photon's patch up where its shuffled rank points; the difference to patch order in "
        "the table of peers is the price of the shuffle and of these loads"
    ),
    "default against Mitsuba 3": (
        "both search a table for every photon; the difference to patch order in the table of peers is what the default "
        "pays for its shuffled order"
    ),
    "two threads against one": (
        "the threads share nothing but a counter of chunks, so what two processes miss as well was taken by other "
        "processes, by shared memory, or because the two logical processors are halves of one core"
    ),
    "two threads against two processes that share nothing": (
        "between two chunks of 65 536 photons a thread needs Python's lock for some 30 us"
    ),
    "one photon per call of a numba host against the default": (
        "one photon per call has no block to vectorise over: its shuffle and its look-up wait for each other"
    ),
}
"""What limits a bar, said where it is missed."""


def markdown_table(rows: Sequence[Sequence[str]], head: Sequence[str]) -> str:
    """A table in Markdown: the first column to the left, the others to the right."""
    ruler = ["---", *["---:"] * (len(head) - 1)]
    return "\n".join("| " + " | ".join(row) + " |" for row in (head, ruler, *rows))


def write_page(results: BenchResults, check: Check, path: Path) -> list[Path]:
    """Write the page, its picture and its numbers; all three are returned."""
    first, every, numbers = _beside(path)
    plot_first(results, first, dpi=130, peers=PEERS)
    plot_bench(results, every, dpi=100, peers=PEERS)
    write_atomically(numbers, csv_text(results))
    write_atomically(path, page_text(results, check, first.name, every.name, numbers.name))
    return [path, first, every, numbers]


def _beside(path: Path) -> tuple[Path, Path, Path]:
    """The first picture of a page, the one with every sky, and the numbers."""
    return path.with_suffix(".png"), path.with_name(f"{path.stem}_skies.png"), path.with_suffix(".csv")


def page_text(results: BenchResults, check: Check, first: str, every: str, numbers: str) -> str:
    """The page as Markdown."""
    quantities = "\n".join(f"- **{name}**: {title}." for name, title in TITLES.items())
    methods = "; ".join(f"`{method.name}` is {method.title}" for method in METHODS.values())
    parts = [
        _HEAD.format(machine=results.machine, csv=f"`{numbers}`"),
        f"![Error against time of three quantities of a clear sky]({first})\n\n{_CAPTION}",
        _bars(check),
        _GROWTH,
        f"## Every sky and quantity\n\n![Error against time, a row for each sky]({every})\n\n{_SKIES_CAPTION}",
        _COLUMNS.format(quantities=quantities, methods=methods, batch=BATCH),
    ]
    parts += [_sky(results, sky) for sky in dict.fromkeys(row.sky for row in results.rows)]
    if results.speed:
        parts.append(_speed(results))
    return "\n".join(parts)


def _bars(check: Check) -> str:
    """The bars, why those that are missed are, and what is shown without a bar."""
    lines = ["## The bars", "", bar_table(check, markdown_table), ""]
    lines += [f"- {line}" for line in check.left_out]
    missed = [bar.name for bar in check.bars if not bar.is_kept]
    lines += [f"- Missed, {name}: {_WHY.get(name, 'the cause is not known')}." for name in missed]
    lines += [f"- Shown, no bar: {line}." for line in check.shown]
    return "\n".join([*lines, ""])


def _sky(results: BenchResults, sky: str) -> str:
    measured = sorted({row.n_photons for row in results.rows if row.sky == sky})
    n = max((m for m in measured if m <= _SHOWN_PHOTONS), default=measured[0])
    truth = ", ".join(f"{quantity} {error:.0e}" for quantity, error in results.truth_error[sky].items())
    lines = [
        f"## Sky: {bench_sky(sky).title}",
        "",
        f"`{sky}`, {short_count(n)} photons; exact values are known to {truth}.",
        "",
        error_table(results, sky, markdown_table, only=n),
        "",
    ]
    if any(trend.sky == sky for trend in results.trends):
        lines += ["Slopes over all numbers of photons, and time to reach an error:", ""]
        lines += [trend_table(results, sky, markdown_table), ""]
    return "\n".join(lines)


def _speed(results: BenchResults) -> str:
    lines = [
        "## Beside the peers",
        "",
        f"The table of the sky `{PEER_SKY}`, float32 unless the name says otherwise.",
        "",
        _PEERS,
    ]
    for run in results.speed:
        lines += [f"### {short_count(run.n_photons)} photons, median of {run.turns} turns", ""]
        lines += [speed_table(run, markdown_table), "", *(f"- {line}" for line in run.left_out), ""]
    return "\n".join(lines)


def _refuse_unwritable(path: Path, *, force: bool) -> None:
    """What would fail after minutes fails at once."""
    for target, head in (
        (path, TITLE),
        *zip(_beside(path), ("", "", ",".join(CSV_COLUMNS)), strict=True),
    ):
        check_target(target, "the report", force=force, head=head)
    if not path.absolute().parent.is_dir():
        raise UsageError(f"the folder of {path} does not exist")
    optional_module("matplotlib", extra="plot")


@guarded
def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, metavar="FILE", help="the page; picture and numbers get its name")
    bench_command.add_sizes(parser)
    parser.add_argument("--force", action="store_true", help="replace files that aomc-sky did not write")
    arguments = parser.parse_args(argv)
    options = bench_command.options_of(arguments)
    _refuse_unwritable(arguments.file, force=arguments.force)
    results = run_bench(options, speed_of=measure_peers)
    n_photons = arguments.photons and max(arguments.photons)
    check = run_check(sizes_of(n_photons, arguments.turns, arguments.replicates), seed=options.seed)
    for path in write_page(results, check, arguments.file):
        print(path)
    return 0 if check.is_kept else 1


if __name__ == "__main__":
    raise SystemExit(main())
