"""What is said of a command that fails: a text for a person on standard error, or one JSON object for a program."""

from __future__ import annotations

import argparse
import sys
import traceback
from dataclasses import dataclass
from typing import Any

from aomc_sky.cli.terminal import error_text
from aomc_sky.cli.usage import WrongWordsError
from aomc_sky.errors import AomcSkyError, InputFileError, InputWarning, ModelLimitWarning, PluginError

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


def report_failure(error: BaseException, arguments: argparse.Namespace, *, as_json: bool) -> int | None:
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
