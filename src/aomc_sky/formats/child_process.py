"""A process of its own that opens a file nobody vouches for, for a damaged one can end or hang the library."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any, BinaryIO, cast

import numpy as np

from aomc_sky.errors import AomcSkyError, OutputError
from aomc_sky.formats.text_file import refuse
from aomc_sky.regular_file import FileKindError, open_regular
from aomc_sky.system import was_too_slow

_START = (
    "import json, sys; from importlib import import_module; sys.path[:] = json.loads(sys.argv[1]); "
    "import_module(sys.argv[2]).main(*json.loads(sys.argv[3]))"
)


def opened(path: str | Path, *, what: str, code: str) -> BinaryIO:
    """A regular file, open for a child to read; `what` it should be, and the code of the error, for messages."""
    advice = f"give the path of {what}"
    try:
        return cast(BinaryIO, open_regular(path).detach())  # the child goes on where the descriptor stands
    except FileKindError:
        raise refuse(path, "not a regular file", advice=advice, code=code) from None
    except PermissionError as error:
        raise OutputError(f"cannot read {path}: {error.strerror}") from error
    except OSError as error:
        reason = error.strerror or error
        raise refuse(path, f"the file cannot be opened: {reason}", advice=advice, code=code) from None


def answer_of_child(
    path: str | Path, file: BinaryIO, module: str, task: list[Any], *, cpu_s: float, library: str, code: str
) -> bytes:
    """What `main(*task)` of a module writes that gets the file as standard input; `task` is JSON values.

    However the child ends other than by itself is an error of the file, and `library` could not read it.
    """
    if not sys.executable:
        raise AomcSkyError(f"cannot read {path}: sys.executable does not name the Python to start for it")
    # one thread: the pool of a linear algebra library would take memory that nobody uses
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
    again = "make the file again"
    # a waiting time only for a machine that is busy with other things: processor time is what is limited
    try:
        done = subprocess.run(
            [sys.executable, "-I", "-B", "-X", "utf8", "-c", _START, json.dumps(sys.path), module, json.dumps(task)],
            stdin=file,
            capture_output=True,
            env=environment,
            timeout=30.0 + 10.0 * cpu_s,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise refuse(path, f"{library} does not finish reading it", advice=again, code=code) from None
    except OSError as error:
        raise AomcSkyError(f"cannot read {path}: {sys.executable} cannot be started: {error.strerror}") from error
    if done.returncode == 0:
        return done.stdout
    raise refuse(path, f"{library} cannot read it: {_reason(done)}", advice=again, code=code)


def _reason(done: subprocess.CompletedProcess[bytes]) -> str:
    if was_too_slow(done.returncode):
        return "it does not finish with this file"
    if done.returncode < 0:
        return f"the file is damaged (the library was stopped by signal {-done.returncode})"
    lines = done.stderr.decode("utf-8", "replace").strip().splitlines()
    return printable(lines[-1].partition(": ")[2] or lines[-1]) if lines else f"exit status {done.returncode}"


def parsed_answer(answer: bytes) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Head and arrays that `write_answer` wrote; ValueError, TypeError, KeyError or EOFError where it did not end."""
    stream = io.BytesIO(answer)
    head = json.loads(stream.readline())
    arrays: dict[str, np.ndarray] = {}
    for name in head["arrays"]:
        array = np.lib.format.read_array(stream, allow_pickle=False)
        array.setflags(write=False)
        arrays[name] = array
    return head, arrays


def printable(name: str) -> str:
    """A name from a file, harmless for a terminal and of a length that can be read."""
    shown = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in name[:200])
    return shown if len(name) <= 200 else f"{shown}..."


# in the child


def write_answer(head: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
    """Write one line of JSON and the arrays in numpy's format to standard output."""
    out = sys.stdout.buffer
    out.write(json.dumps({**head, "arrays": list(arrays)}).encode() + b"\n")
    pipe = SimpleNamespace(write=out.write)  # numpy would look for the position in a file
    for array in arrays.values():
        np.lib.format.write_array(cast(Any, pipe), array, allow_pickle=False)
    out.flush()
