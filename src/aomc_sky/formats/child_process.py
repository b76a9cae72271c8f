"""A process of its own that opens a file nobody vouches for, for a damaged one can end or hang the library."""

from __future__ import annotations

import contextlib
import io
import json
import os
import signal
import stat
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any, BinaryIO, cast

import numpy as np

from aomc_sky.errors import AomcSkyError, OutputError
from aomc_sky.formats.text_file import refuse

with contextlib.suppress(ModuleNotFoundError):  # Windows
    import resource

_START = (
    "import json, sys; from importlib import import_module; sys.path[:] = json.loads(sys.argv[1]); "
    "import_module(sys.argv[2]).main(*json.loads(sys.argv[3]))"
)


def opened(path: str | Path, *, what: str, code: str) -> BinaryIO:
    """A regular file, open for a child to read; `what` it should be, and the code of the error, for messages."""
    advice = f"give the path of {what}"
    try:
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except PermissionError as error:
        raise OutputError(f"cannot read {path}: {error.strerror}") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise refuse(path, f"the file cannot be opened: {reason}", advice=advice, code=code) from None
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise refuse(path, "not a regular file", advice=advice, code=code)
    return cast(BinaryIO, os.fdopen(handle, "rb", buffering=0))  # the child goes on where the descriptor stands


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
    if sys.platform != "win32" and done.returncode == -signal.SIGPROF:
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


def limit(n_bytes: int, cpu_s: float) -> None:
    """Limit memory and processor time, and let no file be opened from here on."""
    if sys.platform == "win32":
        return
    signal.setitimer(signal.ITIMER_PROF, cpu_s)  # its signal ends the process
    with contextlib.suppress(OSError, ValueError):
        with open("/proc/self/statm", encoding="ascii") as file:
            used = int(file.read().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + n_bytes, used + n_bytes))
    with contextlib.suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_NOFILE, (0, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))


def write_answer(head: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
    """Write one line of JSON and the arrays in numpy's format to standard output."""
    out = sys.stdout.buffer
    out.write(json.dumps({**head, "arrays": list(arrays)}).encode() + b"\n")
    pipe = SimpleNamespace(write=out.write)  # numpy would look for the position in a file
    for array in arrays.values():
        np.lib.format.write_array(cast(Any, pipe), array, allow_pickle=False)
    out.flush()
