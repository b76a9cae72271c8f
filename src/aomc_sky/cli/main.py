"""``aomc-sky``: runs one sub-command, with its streams, warnings and Ctrl-C, and reports why it failed.

All output passes through a `VisibleStream`, so texts of files cannot move the cursor or hide letters.
"""

from __future__ import annotations

import argparse
import contextlib
import errno
import io
import os
import re
import sys
import traceback
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, TextIO

from aomc_sky.cli.interrupts import interrupts_heard, interrupts_remembered
from aomc_sky.cli.terminal import error_text
from aomc_sky.cli.usage import WITHDRAWN, WrongWordsError, build_parser
from aomc_sky.errors import AomcSkyError, InputWarning, ModelLimitWarning, PluginError, Problem, visible
from aomc_sky.float_mode import default_mode


def main(argv: Sequence[str] | None = None) -> int:
    """Run one sub-command and return its exit code; usage errors leave through `SystemExit(2)`, as argparse does."""
    _open_missing_streams()
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # file names need not be text
    with visible_streams():
        try:
            return _main(argv)
        except SystemError as error:  # Python's own, where the memory is too short even for its report of an error
            code = _report_failure(error, argparse.Namespace(), as_json=False)
            if code is None:
                raise
            return code


def _main(argv: Sequence[str] | None) -> int:
    arguments = argparse.Namespace()
    words = sys.argv[1:] if argv is None else list(argv)
    try:
        with interrupts_heard(partial(_end, arguments)), interrupts_remembered(), default_mode():
            _parse(words, arguments)
            with warnings_at_end(is_strict=getattr(arguments, "strict", False)):
                code = int(arguments.handler(arguments))
            sys.stdout.flush()
            return code
    except (Exception, KeyboardInterrupt) as error:
        is_for_text = _settle_stdout(error) and getattr(arguments, "out", None) != "-"  # "-" is a stream of photons
        failed = _report_failure(error, arguments, as_json="--json" in words and is_for_text)
        if failed is None:
            raise
        if isinstance(error, WrongWordsError):
            raise SystemExit(failed) from None
        return failed


def _parse(argv: Sequence[str], arguments: argparse.Namespace) -> None:
    if argv and argv[0] in WITHDRAWN:
        raise WrongWordsError(f"{argv[0]} ended with version 0.3", WITHDRAWN[argv[0]])
    parser = build_parser([word for word in argv if word != "--"][:1])
    if argv and argv[0].startswith("-") and not any(flag.startswith(argv[0]) for flag in parser._option_string_actions):
        raise WrongWordsError(f"{argv[0]} stands before the command", f"write aomc-sky COMMAND ... {argv[0]}")
    try:
        parser.parse_args(argv, arguments)
    finally:  # --help and --version leave through SystemExit
        sys.stdout.flush()


class VisibleStream:
    """A standard stream that escapes control characters, apart from line ends and tabs."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream

    def write(self, text: str) -> int:
        """Write a text, escaped."""
        self.stream.write(visible(text, keep_lines=True))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


@contextlib.contextmanager
def visible_streams() -> Iterator[None]:
    """Let standard output and standard error be `VisibleStream` while the block runs."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (VisibleStream(stream) for stream in before)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


_OUR_WARNINGS = (InputWarning, ModelLimitWarning)


@contextlib.contextmanager
def warnings_at_end(*, is_strict: bool = False) -> Iterator[None]:
    """Collect our warnings and print each text once after the block; with `is_strict` they are errors.

    Warnings of other packages are shown as usual.
    """
    kept: dict[str, None] = {}
    with warnings.catch_warnings():
        for category in _OUR_WARNINGS:
            warnings.simplefilter("error" if is_strict else "always", category)
        previous = warnings.showwarning

        def keep(message: Any, category: Any, filename: str, lineno: int, file: Any = None, line: Any = None) -> None:
            if issubclass(category, _OUR_WARNINGS):
                kept[str(message)] = None
            else:
                previous(message, category, filename, lineno, file, line)

        warnings.showwarning = keep
        try:
            yield
        finally:
            with contextlib.suppress(OSError, ValueError):  # tables come before warnings; main reports this error
                sys.stdout.flush()
            for text in kept:
                print(text if "warning[" in text else f"aomc-sky: warning: {text}", file=sys.stderr)


def _open_missing_streams() -> None:
    """Open closed standard streams (`>&-`) on the null device: files of a run must not get their numbers."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115 - until the process ends


def _settle_stdout(error: BaseException) -> bool:
    """Flush standard output. If that or a print failed, discard the rest, or Python complains again at exit."""
    try:
        if isinstance(error, OSError) and error.filename is None and error.errno is not None:
            raise error
        sys.stdout.flush()
        return True
    except (OSError, ValueError):
        with contextlib.suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return False


INTERRUPTED = 130

_NO_MEMORY = (
    *("failed to map segment", "cannot allocate memory", "Cannot allocate memory", "can't start new thread"),
    *("load shared object file", "error return without exception set"),
)
"""Words of loaders of libraries, of threads and of Python when memory is short; the errors are of other kinds."""

_LEAST_DEPTH = 200
"""Below this recursion limit, libraries in C only report that a module cannot be imported."""


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a command ended."""

    exit_code: int
    problems: tuple[Problem, ...]
    text: str = ""  #: for a person; default: that of the problem


def _failure(exit_code: int, code: str, message: str, advice: str = "", text: str = "") -> Failure:
    return Failure(exit_code, (Problem(code=code, message=message, advice=advice),), text)


def _report_failure(error: BaseException, arguments: argparse.Namespace, *, as_json: bool) -> int | None:
    """Print why a command failed and return the exit code, or return None for a bug of ours."""
    failure = _failure_of(error, arguments)
    if failure is None:
        return None
    if isinstance(error, BrokenPipeError):
        return failure.exit_code
    if as_json:
        import json

        print(json.dumps({"error": _as_json(failure)}))
        return failure.exit_code
    cause = error.__cause__ if isinstance(error, PluginError) and "verbose" in arguments else None
    if cause is not None and arguments.verbose:
        traceback.print_exception(cause)  # the author of the model looks for the line
    print(failure.text or f"aomc-sky: error: {failure.problems[0].sentence}", file=sys.stderr)
    if cause is not None and not arguments.verbose:
        print("      = -v shows where in that package", file=sys.stderr)
    return failure.exit_code


def _end(arguments: argparse.Namespace) -> None:
    """End the process as after Ctrl-C, while the main thread hears nothing."""
    failure = _failure_of(KeyboardInterrupt(), arguments)
    assert failure is not None, "an interrupt has words"
    with contextlib.suppress(OSError):
        os.write(2, f"{failure.text}\n".encode())
    os._exit(failure.exit_code)


def _as_json(failure: Failure) -> dict[str, Any]:
    """The object that `error.schema.json` describes."""
    problems = [
        {
            "code": problem.code,
            "message": problem.message,
            "file": problem.path or None,
            "line": problem.line or None,
            "column": problem.column if problem.line else None,
            "field": problem.field or None,
            "advice": problem.advice or None,
        }
        for problem in failure.problems
    ]
    return {"schema": 1, "exit_status": failure.exit_code, "problems": problems}


def _failure_of(error: BaseException, arguments: argparse.Namespace) -> Failure | None:
    if isinstance(error, AomcSkyError):
        text = error_text(error)
        if isinstance(error, WrongWordsError):
            command = getattr(arguments, "command", None)
            text += f"\n      = help: aomc-sky {command + ' ' if command else ''}--help"
        return Failure(error.exit_code, error.problems, text)
    if isinstance(error, InputWarning | ModelLimitWarning):
        advice = "--strict turns warnings into errors"
        return _failure(3, "warning", str(error), advice, f"{error}\naomc-sky: error: {advice}")
    if isinstance(error, KeyboardInterrupt):
        resumes = getattr(arguments, "resumes", False) and arguments.out != "-"
        advice = "run the same command to continue" if resumes else ""
        return _failure(
            INTERRUPTED, "interrupted", "interrupted", advice, f"aomc-sky: interrupted{advice and '; '}{advice}"
        )
    if isinstance(error, OSError) and error.errno not in (None, errno.ENOMEM):
        return _failure(6, "system", f"{error.filename or 'standard output'}: {error.strerror}")
    return _fault_of_machine(error)


def _fault_of_machine(error: BaseException) -> Failure | None:
    """The failure if a limit of this process or of its numbers was reached, or None."""
    is_shallow = isinstance(error, ImportError) and sys.getrecursionlimit() < _LEAST_DEPTH
    if isinstance(error, RecursionError) or is_shallow:
        limit = f"the recursion limit of this Python, {sys.getrecursionlimit()}, is too low"
        return _failure(6, "machine", limit, "1000 is usual")
    if isinstance(error, OverflowError):
        return _failure(3, "number", f"a number is too large to be computed with ({error})")
    reason = re.split(r"\n|\. ", str(error))[0]
    may_be = isinstance(error, RuntimeError | ImportError | OSError | SystemError)
    is_of_memory = may_be and any(words in reason for words in _NO_MEMORY)
    if isinstance(error, MemoryError) or is_of_memory:
        why = f" ({reason})" if reason else ""
        return _failure(
            6, "machine", f"there is not enough memory for this process{why}", "see `ulimit -v`, or --threads 1"
        )
    return None
