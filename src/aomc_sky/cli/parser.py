"""The parser: every sub-command by name, and the options of the one that was asked for."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from importlib import import_module
from typing import Any

from aomc_sky import __version__

COMMANDS = {
    "run": "read amc.inp, sample, write a run folder",
    "merge": "join the shards of a run",
    "validate": "read files and report every problem",
    "info": "show what a scene, a run folder, an MCPL file, a background-sky file or an atmosphere contains",
    "plot": "draw the sky dome of a scene, a run or a file",
    "export": "write a run in another format",
    "verify": "check a run, or photons of any code against a scene",
    "perez": "look at a Perez sky, or make a year of them from a weather file",
    "lobes": "look at background-sky files at one time, or make photons of them",
    "atmosphere": "the clear sky of an atmosphere description (.atmo) as tables",
    "bench": "measure speed against error, beside numpy",
    "completion": "print a completion script for a shell",
}
"""Sub-command -> its line of help. `commands/` has a module or a room of each name."""

_ROOMS = ("atmosphere", "info", "perez", "plot")
"""Sub-commands too long for one file: their module is called `command`."""

_EPILOG = """\
exit codes:
  0 ok   1 a check failed   2 usage   3 bad input   4 the scene cannot be sampled
  5 the output folder belongs to another run   6 input/output error   130 interrupted, resumable

examples:
  aomc-sky run inputs/clear_day/amc.inp --seed 1 --out out
  aomc-sky run amc.inp --compat aomc --format none
  aomc-sky validate inputs/clear_day
  aomc-sky plot inputs/clear_day
  aomc-sky info out
  aomc-sky verify out
"""


class _Commands(argparse._SubParsersAction):  # type: ignore[type-arg]
    """Sub-commands of which only the one that is asked for gets its options."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        assert values is not None, "the name of a sub-command is required"
        _add_options(self, str(values[0]))
        super().__call__(parser, namespace, values, option_string)


def build_parser(*, is_complete: bool = False) -> argparse.ArgumentParser:
    """The parser of the program; `is_complete`: with the options of every sub-command, for those who list them."""
    parser = argparse.ArgumentParser(
        prog="aomc-sky",
        description="The photon source for Monte Carlo light transport in ocean and atmosphere.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"aomc-sky {__version__}")
    commands = parser.add_subparsers(action=_Commands, dest="command", metavar="COMMAND", required=True)
    for name, text in COMMANDS.items():
        commands.add_parser(name, help=text, formatter_class=argparse.RawDescriptionHelpFormatter)
        if is_complete:
            _add_options(commands, name)
    return parser


def _add_options(commands: argparse._SubParsersAction[Any], name: str) -> None:
    parser = commands.choices[name]
    if parser.description is None:  # it comes with the options
        module = f"aomc_sky.cli.commands.{name}{'.command' if name in _ROOMS else ''}"
        import_module(module).add_options(parser)
