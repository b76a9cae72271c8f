"""``aomc-sky``: its sub-commands, the streams, warnings and Ctrl-C of every one, and what is said of one that fails."""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import signal
import sys
import traceback
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from types import FrameType
from typing import Any

from aomc_sky import __version__
from aomc_sky.cli.terminal import error_text, visible_streams, warnings_at_end
from aomc_sky.cli.usage import Parser, WrongWordsError
from aomc_sky.errors import AomcSkyError, InputFileError, InputWarning, ModelLimitWarning, PluginError
from aomc_sky.float_mode import default_mode


def main(argv: Sequence[str] | None = None) -> int:
    """Run one sub-command and return its exit code; usage errors leave through `SystemExit(2)`, as argparse does."""
    _open_missing_streams()
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # file names need not be text
    with visible_streams():
        return _main(argv)


def _main(argv: Sequence[str] | None) -> int:
    arguments = argparse.Namespace()
    words = sys.argv[1:] if argv is None else list(argv)
    try:
        with _interrupts_remembered(), default_mode():
            _parse(words, arguments)
            code = _run(arguments)
            sys.stdout.flush()
            return code
    except (Exception, KeyboardInterrupt) as error:
        is_for_text = _settle_stdout(error) and getattr(arguments, "out", None) != "-"  # which is a stream of photons
        failed = _report_failure(error, arguments, as_json="--json" in words and is_for_text)
        if failed is None:
            raise
        if isinstance(error, WrongWordsError):
            raise SystemExit(failed) from None
        return failed


def _parse(argv: Sequence[str], arguments: argparse.Namespace) -> None:
    if argv and argv[0] in WITHDRAWN:
        raise WrongWordsError(f"{argv[0]} ended with version 0.3; {WITHDRAWN[argv[0]]}")
    parser = build_parser()
    if argv and argv[0].startswith("-") and not any(flag.startswith(argv[0]) for flag in parser._option_string_actions):
        raise WrongWordsError(f"{argv[0]} stands before the command; write aomc-sky COMMAND ... {argv[0]}")
    try:
        parser.parse_args(argv, arguments)
    finally:  # help and the version leave through SystemExit
        sys.stdout.flush()


@contextlib.contextmanager
def _interrupts_remembered() -> Iterator[None]:
    """Raise KeyboardInterrupt for whatever exception ends the block after Ctrl-C.

    The import of numpy, for one, turns an interrupt into an ImportError. Where SIGINT is handled or ignored already, or
    outside the main thread, nothing is changed.
    """
    was_pressed = False

    def remember(number: int, frame: FrameType | None) -> None:
        nonlocal was_pressed
        was_pressed = True
        raise KeyboardInterrupt

    try:
        is_ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler
        if is_ours:
            signal.signal(signal.SIGINT, remember)
    except ValueError:  # another thread than the main one
        is_ours = False
    try:
        yield
    except Exception as error:
        if was_pressed:
            raise KeyboardInterrupt from error
        raise
    finally:
        if is_ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)


def _run(arguments: argparse.Namespace) -> int:
    with warnings_at_end():
        if getattr(arguments, "strict", False):
            warnings.simplefilter("error", InputWarning)
            warnings.simplefilter("error", ModelLimitWarning)
        return int(arguments.handler(arguments))


def _open_missing_streams() -> None:
    """Open standard streams that were closed (`>&-`) on nothing: their numbers must not go to the files of a run."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115 - until the process ends


def _settle_stdout(error: BaseException) -> bool:
    """Flush standard output; where that or a print failed, send the rest nowhere, or Python complains again at exit."""
    try:
        if isinstance(error, OSError) and error.filename is None:
            raise error
        sys.stdout.flush()
        return True
    except (OSError, ValueError):
        with contextlib.suppress(OSError, ValueError):
            descriptor = sys.stdout.fileno()
            os.dup2(os.open(os.devnull, os.O_WRONLY), descriptor)
        return False


INTERRUPTED = 130

_NO_MEMORY = ("failed to map segment", "cannot allocate memory", "Cannot allocate memory", "can't start new thread")
"""What the loader of libraries and Python's threads say without memory, in errors of other kinds."""

_LEAST_DEPTH = 200
"""Recursion limit below which libraries in C only say that a module of theirs cannot be imported."""


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a command ended."""

    exit_code: int
    code: str  #: A word for programs; problems of files have codes of their own
    message: str
    advice: str = ""  #: What to do
    text: str = ""  #: For a person, where that is not message and advice


def _report_failure(error: BaseException, arguments: argparse.Namespace, *, as_json: bool) -> int | None:
    """Say what happened and return the exit code; None, and nothing said, of a fault of ours."""
    failure = _failure_of(error, arguments)
    if failure is None or isinstance(error, BrokenPipeError):
        return None if failure is None else failure.exit_code
    if as_json:
        import json

        print(json.dumps({"error": _as_json(error, failure)}))
        return failure.exit_code
    cause = error.__cause__ if isinstance(error, PluginError) and "verbose" in arguments else None
    if cause is not None and arguments.verbose:
        traceback.print_exception(cause)  # whoever writes the model looks for the line
    advice = f"\n      = {failure.advice}" if failure.advice else ""
    print(failure.text or f"aomc-sky: error: {failure.message}{advice}", file=sys.stderr)
    if cause is not None and not arguments.verbose:
        print("      = -v shows where in that package", file=sys.stderr)
    return failure.exit_code


def _as_json(error: BaseException, failure: Failure) -> dict[str, Any]:
    """Members as `error.schema.json` has them."""
    nowhere = dict.fromkeys(("file", "line", "column", "field"))
    problems: list[dict[str, Any]] = [
        {"code": failure.code, "message": failure.message, **nowhere, "advice": failure.advice or None}
    ]
    if isinstance(error, InputFileError):
        problems = [
            {
                "code": problem.code,
                "message": problem.message,
                "file": problem.path,
                "line": problem.line or None,
                "column": problem.column if problem.line else None,
                "field": problem.field or None,
                "advice": problem.advice or None,
            }
            for problem in error.problems
        ]
    return {"schema": 1, "exit_status": failure.exit_code, "problems": problems}


def _failure_of(error: BaseException, arguments: argparse.Namespace) -> Failure | None:
    if isinstance(error, AomcSkyError):
        if isinstance(error, WrongWordsError):
            command = getattr(arguments, "command", None)
            how = f"help: aomc-sky {command + ' ' if command else ''}--help"
            return Failure(error.exit_code, error.code, str(error), how)
        return Failure(error.exit_code, error.code, str(error), text=error_text(error))
    if isinstance(error, InputWarning | ModelLimitWarning):
        text = f"{error}\naomc-sky: error: --strict turns warnings into errors"
        return Failure(3, "warning", str(error), "--strict turns warnings into errors", text)
    if isinstance(error, KeyboardInterrupt):
        goes_on = getattr(arguments, "resumes", False) and arguments.out != "-"
        advice = "run the same command to continue" if goes_on else ""
        return Failure(
            INTERRUPTED, "interrupted", "interrupted", advice, f"aomc-sky: interrupted{advice and '; '}{advice}"
        )
    if isinstance(error, OSError):
        return Failure(6, "system", f"{error.filename or 'standard output'}: {error.strerror}")
    return _fault_of_machine(error)


def _fault_of_machine(error: BaseException) -> Failure | None:
    """A limit of this process or of its numbers; None for any other error."""
    is_shallow = isinstance(error, ImportError) and sys.getrecursionlimit() < _LEAST_DEPTH
    if isinstance(error, RecursionError) or is_shallow:
        limit = f"the recursion limit of this Python, {sys.getrecursionlimit()}, is too low; 1000 is usual"
        return Failure(6, "machine", limit)
    if isinstance(error, OverflowError):
        return Failure(3, "number", f"a number is too large to be computed with ({error})")
    reason = str(error).partition("\n")[0]
    is_of_memory = isinstance(error, RuntimeError | ImportError) and any(words in reason for words in _NO_MEMORY)
    if isinstance(error, MemoryError) or is_of_memory:
        why = f" ({reason})" if reason else ""
        advice = "see `ulimit -v`, or --threads 1"
        return Failure(6, "machine", f"there is not enough memory for this process{why}; {advice}")
    return None


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
"""Sub-command -> its line of help. `commands/` has a module of each name."""

WITHDRAWN = {
    "bench": "write python bench/report.py in the repository",
    "lobes": "write aomc-sky info or plot FILE.h5 --time TIME; [[background]] in sky.toml gives photons",
    "merge": "shards write in place: run the missing shards",
    "completion": "write aomc-sky --print-completion bash|zsh|tcsh",
}
"""Sub-commands of earlier versions -> what to use."""

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
    about = "The photon source for Monte Carlo light transport in ocean and atmosphere."
    parser = Parser(prog="aomc-sky", description=about, epilog=_EPILOG)
    parser.add_argument("--version", action="version", version=f"aomc-sky {__version__}")
    parser.add_argument(
        "--print-completion", action=_PrintCompletion, choices=("bash", "zsh", "tcsh"), metavar="bash|zsh|tcsh",
        help="print a completion script for a shell (needs the extra 'completion')",
    )  # fmt: skip
    commands = parser.add_subparsers(action=_Commands, dest="command", metavar="COMMAND", required=True)
    for name, text in COMMANDS.items():
        commands.add_parser(name, help=text)
        if is_complete:
            _add_options(commands, name)
    return parser


def _add_options(commands: argparse._SubParsersAction[Any], name: str) -> None:
    parser = commands.choices.get(name)
    if parser is not None and parser.description is None:  # it comes with the options
        import_module(f"aomc_sky.cli.commands.{name}").add_options(parser)


class _PrintCompletion(argparse.Action):
    """Print a completion script of all sub-commands, and leave."""

    def __call__(self, parser: argparse.ArgumentParser, namespace: object, shell: Any, option: object = None) -> None:
        from aomc_sky.extras import optional_module

        shtab = optional_module("shtab", extra="completion")
        whole = build_parser(is_complete=True)
        commands = next(action.choices for action in whole._actions if isinstance(action, _Commands))
        for action in (action for one in commands.values() for action in one._actions):
            if action.metavar in ("DIR", "FILE", "PATH", "AMC_INP", "RUN", "MODEL"):
                action.complete = shtab.DIRECTORY if action.metavar == "DIR" else shtab.FILE
        sys.stdout.write(shtab.complete(whole, shell))
        parser.exit()
