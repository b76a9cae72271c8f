"""``aomc-sky bench``: speed against error of our samplers, with numpy's beside them."""

from __future__ import annotations

import argparse
import dataclasses
import functools
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.terminal import table
from aomc_sky.errors import UsageError

if TYPE_CHECKING:
    from aomc_sky.benchmark.run import BenchOptions, BenchResults
    from aomc_sky.cli.usage import Parser

_SKIES = "uniform|clear|clear-uniform|overcast|sparse|spike"
_METHODS = "default|patch-order|iid|largest-remainder|aomc"
"""Names as the benchmark has them, written out: its tables are not loaded for a word of help."""

_table = functools.partial(table, n_left=1)

_EPILOG = """\
examples:
  aomc-sky bench                                             all skies and methods, and numpy: minutes
  aomc-sky bench --preset quick --skies clear --no-peers     seconds
  aomc-sky bench --csv bench.csv --plot bench.png
"""

_MOVED = {"check": "python bench/check.py", "report": "python bench/report.py FILE"}
"""Options that are scripts of the repository now."""


def add_options(parser: Parser) -> None:
    """What the sub-command takes."""
    parser.description = "Measure the time and the accuracy of each sampler, and of the samplers of numpy, in one run."
    parser.epilog = _EPILOG
    what = parser.add_argument_group("what is measured")
    add_sizes(what)
    what.add_argument("--no-peers", action="store_true", help="leave out the table that compares speeds with numpy")
    for option in _MOVED:
        what.add_argument(f"--{option}", nargs="?", const="", help=argparse.SUPPRESS)
    out = parser.add_argument_group("what is written and printed")
    out.add_argument("--csv", metavar="FILE", help="errors and times, a line per sky, method and number of photons")
    out.add_argument("--plot", metavar="FILE", help="error against time as .png, .svg or .pdf (needs the extra 'plot')")
    out.add_argument("--force", action="store_true", help="replace files that aomc-sky did not write")
    cli_options.add_shared(out, "json quiet")
    parser.set_defaults(handler=bench)


def add_sizes(what: Any) -> None:
    """Options that say how much a run measures; `bench/report.py` takes them too."""
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


def bench(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    for option, script in _MOVED.items():
        if getattr(arguments, option) is not None:
            raise UsageError(f"--{option} moved to a script of the repository: {script}")
    options = options_of(arguments, has_peers=not arguments.no_peers)
    _refuse_unwritable(arguments)
    from aomc_sky.benchmark.run import results_json, results_text

    results = _measured(arguments, options)
    if arguments.csv:
        from aomc_sky.benchmark.run import csv_text
        from aomc_sky.formats.text_file import write_atomically

        write_atomically(arguments.csv, csv_text(results))
    if arguments.plot:
        from aomc_sky.benchmark.figure import plot_bench

        plot_bench(results, arguments.plot)
    cli_options.answer(arguments, lambda: results_json(results), lambda: results_text(results, _table))
    return 0


def _refuse_unwritable(arguments: argparse.Namespace) -> None:
    """What would fail after minutes fails at once."""
    from aomc_sky.benchmark.run import CSV_COLUMNS
    from aomc_sky.outputs.folder.target_file import check_target

    for option, path, head in (("--csv", arguments.csv, ",".join(CSV_COLUMNS)), ("--plot", arguments.plot, "")):
        if path is not None:
            check_target(path, option, force=arguments.force, head=head)
            if not Path(path).absolute().parent.is_dir():
                raise UsageError(f"the folder of {path} does not exist")
    if arguments.plot:
        from aomc_sky.extras import optional_module
        from aomc_sky.outputs.picture import picture_path

        optional_module("matplotlib", extra="plot")
        picture_path(arguments.plot)


def options_of(arguments: argparse.Namespace, *, has_peers: bool = True) -> BenchOptions:
    """The preset with what the caller changed."""
    from aomc_sky.benchmark.run import PRESETS

    changes: dict[str, Any] = {
        "skies": arguments.skies and tuple(arguments.skies),
        "methods": arguments.methods and tuple(arguments.methods),
        "photons": arguments.photons and tuple(sorted(set(arguments.photons))),
        "replicates": arguments.replicates,
        "turns": arguments.turns,
        "precision": arguments.precision,
        "seed": arguments.seed,
        "total_photons": None if arguments.replicates is None else float("inf"),
        "speed_photons": (arguments.photons and (max(arguments.photons),)) if has_peers else (),
    }
    changed = {name: value for name, value in changes.items() if value is not None}
    return dataclasses.replace(PRESETS[arguments.preset], **changed)


def _measured(arguments: argparse.Namespace, options: BenchOptions) -> BenchResults:
    from aomc_sky.benchmark.run import run_bench
    from aomc_sky.cli.progress import progress_bar

    with progress_bar(enabled=not arguments.quiet, unit="steps", per_unit=1.0) as progress:
        return run_bench(options, progress)
