"""The parser: all sub-commands, help in two lengths, and usage errors that suggest the most similar word."""

from __future__ import annotations

import argparse
import re
import sys
import textwrap
from collections.abc import Iterable
from importlib import import_module
from typing import Any, NoReturn

from aomc_sky import __version__
from aomc_sky.errors import UsageError
from aomc_sky.options import SECTIONS


class WrongWordsError(UsageError):
    """Words on the command line that the parser refuses."""


class _HelpAll(argparse.Action):
    """Print all options, and exit."""

    def __call__(self, parser: argparse.ArgumentParser, *rest: object, **named: object) -> None:
        assert isinstance(parser, Parser)
        parser._print_message(parser.format_help(is_long=True), sys.stdout)
        parser.exit()


class _Formatter(argparse.RawDescriptionHelpFormatter):
    """Wraps sentences but not examples, and gives options more columns than argparse does."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=28)

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return super()._fill_text(text if "\n" in text else textwrap.fill(text, width), width, indent)


class _One(argparse.Action):
    """An option of one value: given again with another value it is an error, where argparse takes the last."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option: str | None = None
    ) -> None:
        if option is not None:
            assert isinstance(parser, Parser)
            before = parser.given.setdefault(self.dest, values)
            if before != values:
                one, other = (
                    " ".join(map(str, value if isinstance(value, list) else [value])) for value in (before, values)
                )
                raise WrongWordsError(f"{option} is given twice, as {one} and as {other}", "leave one out")
        setattr(namespace, self.dest, values)


class _OneSwitch(argparse.BooleanOptionalAction):
    """--name and --no-name, which contradict each other."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option: str | None = None
    ) -> None:
        before, first = getattr(namespace, self.dest, None), self.option_strings[0]
        super().__call__(parser, namespace, values, option)
        if before not in (None, getattr(namespace, self.dest)):
            raise WrongWordsError(f"{first} and --no-{first[2:]} contradict each other", "leave one out")


class Parser(argparse.ArgumentParser):
    """A parser of the program or of a sub-command."""

    def __init__(self, **named: Any) -> None:
        super().__init__(formatter_class=_Formatter, **named)
        self.color = False  # the streams of a command would escape the colours of Python 3.14
        self._positionals.title = "arguments"
        self._first: tuple[str, ...] = ()
        self.given: dict[str, Any] = {}  #: the options of one value on this command line
        self.register("action", None, _One)
        self.register("action", argparse.BooleanOptionalAction, _OneSwitch)
        # argparse of Python 3.11 takes -3. and -1e-3 for options
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def show_first(self, names: str) -> None:
        """``--help`` shows only these options, in this order; ``--help-all`` shows all of them in groups."""
        self._first = tuple(f"--{name}" for name in names.split())
        self.add_argument("--help-all", action=_HelpAll, nargs=0, help="show all options, in groups, and exit")

    def format_help(self, *, is_long: bool = False) -> str:
        """The text of ``--help``; `is_long`: with all options."""
        formatter = self._get_formatter()
        needed = [action for action in self._actions if action.required]
        formatter.add_usage(f"{self.prog} {_usage_of(needed)}[options]", [], [])
        formatter.add_text(self.description)
        sections = [(group.title, group._group_actions) for group in self._action_groups]
        rest = None
        if self._first and not is_long:
            shown = [self._option_string_actions[flag] for flag in ("-h", "--help-all", *self._first)]
            sections = [(self._positionals.title, self._positionals._group_actions), (self._optionals.title, shown)]
            n_options = sum(bool(one.option_strings) and one.help != argparse.SUPPRESS for one in self._actions)
            rest = f"{n_options - len(shown)} more options with --help-all."
        for title, actions in sections:
            formatter.start_section(title)
            formatter.add_arguments(actions)
            formatter.end_section()
        formatter.add_text(rest)
        formatter.add_text(self.epilog)
        return formatter.format_help()

    def _print_message(self, message: str, file: Any = None) -> None:
        if file is sys.stdout:  # argparse would hide that standard output failed
            file.write(message)
        else:
            super()._print_message(message, file)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse does, and refuse words that are left over."""
        self.given.clear()
        found, rest = super().parse_known_args(args, namespace)
        if rest and rest[0].startswith("-"):
            word, name = rest[0].partition("=")[0], self.prog.rpartition(" ")[2]
            advice = _elsewhere(word, reads_scenes="--sky" in self._option_string_actions)
            near = did_you_mean(word, self._option_string_actions).removeprefix("; ")
            raise WrongWordsError(f"{name} has no option {word}", advice or near)
        if rest:
            self.error(f"{rest[0]!r} is one word too many; a path with blanks stands in quotes")
        return found, rest

    def error(self, message: str) -> NoReturn:
        """Raise the message of argparse with the most similar word."""
        message = re.sub(r"\A(--[a-z-]+)/--[a-z-]+", r"\1", message.removeprefix("argument "))
        choice = re.search(r" \(choose from (.*)\)", message)
        if choice:  # versions of Python write this list differently
            known = re.findall(r"[\w.+-]+", choice[1])
            near = did_you_mean(message.split("'")[1], known)
            message = message[: choice.start()] + (near or f"; choose from {', '.join(known)}")
        raise WrongWordsError(message)


def _usage_of(needed: Iterable[argparse.Action]) -> str:
    """The arguments and options that a command needs, as a person writes them."""
    words = []
    for action in needed:
        name = action.metavar or "|".join(map(str, action.choices or (action.dest,)))
        words += [*action.option_strings[:1], f"{name}{' ...' if action.nargs == '+' else ''}"]
    return "".join(f"{word} " for word in words)


def _elsewhere(word: str, *, reads_scenes: bool) -> str:
    """What to write for an option that stands in sky.toml or does nothing here; empty for another word."""
    if word in OF_HOSTS:
        return "leave it out: surface, wind and waves are the transport code's, and photons arrive above the surface"
    if word in IDLE:
        return f"leave it out: {IDLE[word]}"
    for section, rows in SECTIONS.items() if reads_scenes else ():
        for key, row in rows.items():
            if word in (row.flag, f"--{key.replace('_', '-')}"):
                shown = "a to e" if key == "coefficients" else key
                return f"write {shown} below [{section}] of sky.toml, or give it in Python"
    return ""


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """The most similar known word, as a question; empty if none is alike."""
    from aomc_sky.formats.report import LIKELY, nearest

    by_name = {name.strip("-"): name for name in known if len(name.strip("-")) > 1}
    best = nearest(word.strip("-"), by_name, at_least=LIKELY)
    return f"; did you mean {by_name[best]}?" if best else ""


COMMANDS = {
    "run": "read amc.inp, sample, write a run folder",
    "validate": "read files and report every problem",
    "info": "show what a scene, a run folder, an MCPL file, a background-sky file or an atmosphere contains",
    "plot": "draw the sky dome of a scene, a run or a file",
    "export": "write a run in another format",
    "verify": "check a run, or photons of any code against a scene",
    "perez": "look at a Perez sky",
    "atmosphere": "the clear sky of an atmosphere description (.atmo) as tables",
}
"""Sub-command -> its line of help; `commands/` holds a module of that name."""

WITHDRAWN = {
    "bench": "write python bench/report.py in the repository",
    "lobes": "write aomc-sky info or plot FILE.h5 --time TIME; [[background]] in sky.toml gives photons",
    "merge": "shards write in place: run the missing shards",
    "completion": "write aomc-sky --print-completion bash|zsh|tcsh",
}
"""Sub-commands of earlier versions -> what to use."""

IDLE = {
    "--radiance": "spectral radiances are written in any case",
    "--save-delta-scattering": "radiance_by_order is written in any case",
    "--no-eds-tex": "there is no texture of eclipsed double scattering",
    **dict.fromkeys(("--opengl-info", "--opengl-debug", "--opengl-debug-full"), "OpenGL is not used"),
}
"""Options of calcmysky that would change nothing -> why."""

OF_HOSTS = ("--wind", "--wind-speed", "--waves", "--surface")
"""What users of ocean models look for here, and transport codes do."""

_EPILOG = """\
`aomc-sky COMMAND --help` shows what a command takes.

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


def build_parser(names: Iterable[str] = COMMANDS) -> argparse.ArgumentParser:
    """The parser of the program, with the options of these sub-commands."""
    about = "The photon source for Monte Carlo light transport in ocean and atmosphere."
    parser = Parser(prog="aomc-sky", description=about, epilog=_EPILOG)
    parser.add_argument("--version", action="version", version=f"aomc-sky {__version__}")
    parser.add_argument(
        "--print-completion", action=_PrintCompletion, choices=("bash", "zsh", "tcsh"), metavar="bash|zsh|tcsh",
        help="print a completion script for a shell (needs the extra 'completion')",
    )  # fmt: skip
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, text in COMMANDS.items():
        command = commands.add_parser(name, help=text)
        if name in names:
            import_module(f"aomc_sky.cli.commands.{name}").add_options(command)
    return parser


class _PrintCompletion(argparse.Action):
    """Print a completion script with all sub-commands, and exit."""

    def __call__(self, parser: argparse.ArgumentParser, namespace: object, shell: Any, option: object = None) -> None:
        from aomc_sky.extras import optional_module
        from aomc_sky.formats.sky_models import installed_skies

        shtab = optional_module("shtab", extra="completion")
        complete = build_parser()
        actions = (action for action in complete._actions if isinstance(action, argparse._SubParsersAction))
        commands = next(actions).choices
        skies = ("perez", "uniform", "none", *installed_skies().plugins)
        for action in (action for one in commands.values() for action in one._actions):
            if action.dest == "sky":
                action.choices = skies
            if action.metavar in ("DIR", "FILE", "PATH", "AMC_INP", "RUN", "MODEL"):
                action.complete = shtab.DIRECTORY if action.metavar == "DIR" else shtab.FILE
        sys.stdout.write(shtab.complete(complete, shell))
        parser.exit()
