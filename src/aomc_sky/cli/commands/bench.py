"""``aomc-sky bench``: speed against error of our samplers and of the best peers, and the bars they must keep."""

from __future__ import annotations

import argparse
import dataclasses
import functools
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.table import table
from aomc_sky.errors import UsageError

if TYPE_CHECKING:
    from bench.check import CheckSizes
    from aomc_sky.benchmark.run import BenchOptions, BenchResults

_SKIES = "uniform|clear|clear-uniform|overcast|sparse|spike"
_METHODS = "default|patch-order|iid|largest-remainder|aomc"
"""Names as the benchmark has them, written out: its tables are not loaded for a word of help."""

_table = functools.partial(table, n_left=1)

_EPILOG = """\
examples:
  aomc-sky bench                                             all skies, methods and peers: minutes
  aomc-sky bench --preset quick --skies clear --no-peers     seconds
  aomc-sky bench --csv bench.csv --plot bench.png
  aomc-sky bench --check                                     exit code 1 when a bar falls short
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """What the sub-command takes."""
    parser.description = "Measure what each sampler costs and what accuracy it buys, beside the best peers, in one run."
    parser.epilog = _EPILOG
    what = parser.add_argument_group("what is measured")
    what.add_argument(
        "--preset", choices=("quick", "default", "full"), default="default", help="how much (default: some minutes)"
    )
    what.add_argument("--skies", nargs="+", metavar=(_SKIES, "SKY"), help="only these skies")
    what.add_argument("--methods", nargs="+", metavar=(_METHODS, "METHOD"), help="only these methods")
    what.add_argument(
        "--photons", nargs="+", type=cli_options.photon_total, metavar="N", help="numbers of photons, also as 1e6"
    )
    what.add_argument("--replicates", type=cli_options.whole_number, metavar="R", help="runs behind every error")
    what.add_argument("--turns", type=cli_options.whole_number, metavar="T", help="turns behind every time")
    what.add_argument("--precision", choices=("float32", "float64"), help="of directions (default float32)")
    what.add_argument("--seed", type=cli_options.seed, metavar="INT", help="first seed (default 1)")
    what.add_argument("--no-peers", action="store_true", help="leave out the table of peers")
    what.add_argument(
        "--check", action="store_true", help="measure the bars of docs/performance.md; exit code 1 when one is missed"
    )
    out = parser.add_argument_group("what is written and printed")
    out.add_argument("--csv", metavar="FILE", help="errors and times, a line per sky, method and number of photons")
    out.add_argument("--plot", metavar="FILE", help="error against time as .png, .svg or .pdf (needs the extra 'plot')")
    out.add_argument("--report", metavar="FILE", help="run and check as a page in Markdown, its plot beside it")
    out.add_argument("--force", action="store_true", help="replace files that aomc-sky did not write")
    cli_options.add_print_options(out)
    parser.set_defaults(handler=bench)


def bench(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    _refuse_contradictions(arguments)
    options = _options(arguments)
    _refuse_unwritable(arguments)
    if arguments.report:
        return _report(arguments, options)
    if arguments.check:
        return _check(arguments)
    results = _measured(arguments, options)
    if arguments.csv:
        from aomc_sky.benchmark.run import csv_text
        from aomc_sky.formats.text_file import write_atomically

        write_atomically(arguments.csv, csv_text(results))
    if arguments.plot:
        from aomc_sky.benchmark.figure import plot_bench

        plot_bench(results, arguments.plot)
    if arguments.json:
        from aomc_sky.benchmark.run import results_json

        print(json.dumps(results_json(results)))
    elif not arguments.quiet:
        from aomc_sky.benchmark.tables import results_text

        print(results_text(results, _table))
    return 0


def _refuse_contradictions(arguments: argparse.Namespace) -> None:
    """Options of one task do not go with another one."""
    if arguments.check and (arguments.csv or arguments.plot or arguments.report):
        raise UsageError("--check measures the bars alone; give --csv, --plot and --report without it")
    if arguments.check and (arguments.skies or arguments.methods or arguments.precision or arguments.no_peers):
        raise UsageError("--check measures fixed skies, methods and peers; only --photons, --replicates and --turns go")
    if arguments.check and arguments.photons and len(arguments.photons) > 1:
        raise UsageError("--check takes one number of photons")
    if arguments.report and arguments.json:
        raise UsageError("--report writes a page; --json goes without it")


def _refuse_unwritable(arguments: argparse.Namespace) -> None:
    """What would fail after minutes fails at once."""
    from aomc_sky.benchmark.run import CSV_COLUMNS
    from aomc_sky.outputs.folder.target_file import check_target

    heads = {"--csv": ",".join(CSV_COLUMNS), "--plot": "", "--report": "# Speed against error\n"}
    for option, path in zip(heads, (arguments.csv, arguments.plot, arguments.report), strict=True):
        if path is not None:
            check_target(path, option, force=arguments.force, head=heads[option])
    for path, head in ((".png", ""), (".csv", heads["--csv"])) if arguments.report else ():
        check_target(Path(arguments.report).with_suffix(path), "--report", force=arguments.force, head=head)
    for path in (arguments.csv, arguments.plot, arguments.report):
        if path is not None and not Path(path).absolute().parent.is_dir():
            raise UsageError(f"the folder of {path} does not exist")
    if arguments.plot or arguments.report:
        from aomc_sky.extras import optional_module

        optional_module("matplotlib", extra="plot")
    if arguments.plot:
        from aomc_sky.outputs.picture import picture_path

        picture_path(arguments.plot)


def _options(arguments: argparse.Namespace) -> BenchOptions:
    """The preset with what the caller changed."""
    from aomc_sky.benchmark.run import PRESETS

    given: dict[str, Any] = {
        "skies": arguments.skies and tuple(arguments.skies),
        "methods": arguments.methods and tuple(arguments.methods),
        "photons": arguments.photons and tuple(sorted(set(arguments.photons))),
        "replicates": arguments.replicates,
        "turns": arguments.turns,
        "precision": arguments.precision,
        "seed": arguments.seed,
        "total_photons": None if arguments.replicates is None else float("inf"),
        "speed_photons": () if arguments.no_peers else arguments.photons and (max(arguments.photons),),
    }
    changed = {name: value for name, value in given.items() if value is not None}
    return dataclasses.replace(PRESETS[arguments.preset], **changed)


def _measured(arguments: argparse.Namespace, options: BenchOptions) -> BenchResults:
    from aomc_sky.benchmark.run import run_bench
    from aomc_sky.cli.progress import progress_bar

    with progress_bar(enabled=not arguments.quiet, unit="steps", per_unit=1.0) as progress:
        return run_bench(options, progress)


def _check_sizes(arguments: argparse.Namespace) -> CheckSizes:
    """The sizes of a check: the usual ones, or smaller ones for a machine or a test in a hurry."""
    from bench.check import CheckSizes

    sizes = CheckSizes()
    if arguments.photons:
        n = max(arguments.photons)
        sizes = CheckSizes(
            speed_photons=n,
            thread_photons=n,
            error_photons=n,
            mcpl_photons=n,
            memory_photons=(n, 10 * n),
        )
    changed = {
        "speed_turns": arguments.turns,
        "thread_turns": arguments.turns,
        "error_replicates": arguments.replicates,
    }
    return dataclasses.replace(sizes, **{name: value for name, value in changed.items() if value is not None})


def _check(arguments: argparse.Namespace) -> int:
    from bench.check import run_check
    from aomc_sky.benchmark.tables import check_text
    from aomc_sky.benchmark.timing import machine_now

    before = machine_now()
    check = run_check(_check_sizes(arguments), seed=1 if arguments.seed is None else arguments.seed)
    if arguments.json:
        bars = [
            {"name": b.name, "value": b.value, "limit": b.limit, "relation": b.relation, "kept": b.is_kept}
            for b in check.bars
        ]
        print(json.dumps({"machine": before, "bars": bars, "left_out": check.left_out, "kept": check.is_kept}))
    elif not arguments.quiet:
        print(f"{before}\n{check_text(check, _table)}")
    missed = [bar.name for bar in check.bars if not bar.is_kept]
    if missed:
        print(f"aomc-sky: {len(missed)} of {len(check.bars)} bars are missed: {'; '.join(missed)}", file=sys.stderr)
    return 0 if check.is_kept else 1


def _report(arguments: argparse.Namespace, options: BenchOptions) -> int:
    from bench.check import run_check
    from bench.report import write_page

    results = _measured(arguments, options)
    check = run_check(_check_sizes(arguments), seed=options.seed)
    for path in write_page(results, check, Path(arguments.report)):
        if not arguments.quiet:
            print(path)
    return 0 if check.is_kept else 1
