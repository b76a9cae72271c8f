"""Members of an HDF5 file that nobody vouches for, read by a process of its own."""

from __future__ import annotations

import io
import json
import os
import signal
import stat
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, cast

import numpy as np

from aomc_sky.errors import AomcSkyError, OutputError
from aomc_sky.extras import optional_module
from aomc_sky.formats.report import Report
from aomc_sky.formats.text_file import refuse

MAX_FILE_BYTES = 1 << 30
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_CHILD = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from aomc_sky.formats.background.hdf5_child import main; main(*json.loads(sys.argv[2]))"
)
_AGAIN = "make the file again"


@dataclass(frozen=True, kw_only=True, slots=True)
class Hdf5Members:
    """What was requested of a file and is there."""

    names: frozenset[str]  #: Paths of all groups and datasets seen, without the leading slash
    #: Numbers, as float32, float64, int64 or uint64; a member of a record under its own name
    #: (``LobeAnims/a/Lobes/Type``), an attribute of the root under ``@name``
    arrays: dict[str, np.ndarray]
    texts: dict[str, str]


def read_members(
    path: str | Path, requested: Sequence[str], report: Report, *, extra: str, informing: Sequence[str] = ()
) -> Hdf5Members:
    """Read members; `requested` are paths, with ``*`` for any name and ``@name`` for an attribute of the root.

    No other file is opened, whatever the file says: links other than hard ones, external and virtual storage
    are refused (E502), sizes beyond what the file can hold and filters other than gzip, shuffle and
    fletcher32 too (E503), and members that hold no numbers or text (E505). Of the `informing` ones, which are for
    persons, texts, lists of texts and numbers of any shape are taken, and what is none of these is a warning.
    """
    optional_module("h5py", extra=extra)
    with _opened(path) as file:
        size = os.fstat(file.fileno()).st_size
        if size > MAX_FILE_BYTES:
            raise refuse(path, f"the file has {size} bytes; at most {MAX_FILE_BYTES} are read", code="E503")
        if not _has_signature(file, size):
            raise refuse(path, "not an HDF5 file: its signature is missing", advice="name an HDF5 file", code="E501")
        file.seek(0)
        answer = _ask_child(path, file, requested, informing, cpu_s=0.25 + size / 2e6)
    try:
        head, arrays = _parsed(answer)
        harmless = {f"attribute {name[1:]}" if name.startswith("@") else f"/{name}" for name in informing}
        for code, name, message, advice in head["faults"]:
            is_warning = code == "E505" and name in harmless
            report.add(code, message, name=printable(name), advice=advice, is_warning=is_warning)
        return Hdf5Members(names=frozenset(head["names"]), arrays=arrays, texts=head["texts"])
    except (ValueError, TypeError, KeyError, EOFError) as error:  # the child died in the middle of its answer
        raise refuse(
            path, "the HDF5 library cannot read it: the file is damaged", advice=_AGAIN, code="E501"
        ) from error


def printable(name: str) -> str:
    """A name from a file, harmless for a terminal and of a length that can be read."""
    shown = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in name[:200])
    return shown if len(name) <= 200 else f"{shown}..."


def _opened(path: str | Path) -> BinaryIO:
    advice = "give the path of an HDF5 file"
    try:
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except PermissionError as error:
        raise OutputError(f"cannot read {path}: {error.strerror}") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise refuse(path, f"the file cannot be opened: {reason}", advice=advice, code="E500") from None
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise refuse(path, "not a regular file", advice=advice, code="E500")
    return cast(BinaryIO, os.fdopen(handle, "rb", buffering=0))  # the child goes on where the descriptor stands


def _has_signature(file: BinaryIO, size: int) -> bool:
    """The signature stands at 0, 512, 1024, 2048 ...; before it may be anything."""
    offset = 0
    while offset < size:
        file.seek(offset)
        if file.read(8) == _SIGNATURE:
            return True
        offset = max(512, 2 * offset)
    return False


def _ask_child(
    path: str | Path, file: BinaryIO, requested: Sequence[str], informing: Sequence[str], *, cpu_s: float
) -> bytes:
    if not sys.executable:
        raise AomcSkyError(f"cannot read {path}: sys.executable does not name the Python to start for it")
    task = json.dumps([[w.split("/") for w in requested], cpu_s, list(informing)])
    # one thread: the pool of a linear algebra library would take memory that nobody uses
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
    # a waiting time only for a machine that is busy with other things: processor time is what is limited
    try:
        done = subprocess.run(
            [sys.executable, "-I", "-B", "-X", "utf8", "-c", _CHILD, json.dumps(sys.path), task],
            stdin=file,
            capture_output=True,
            env=environment,
            timeout=30.0 + 10.0 * cpu_s,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise refuse(path, "the HDF5 library does not finish reading it", advice=_AGAIN, code="E501") from None
    except OSError as error:
        raise AomcSkyError(f"cannot read {path}: {sys.executable} cannot be started: {error.strerror}") from error
    if done.returncode == 0:
        return done.stdout
    raise refuse(path, f"the HDF5 library cannot read it: {_reason(done)}", advice=_AGAIN, code="E501")


def _reason(done: subprocess.CompletedProcess[bytes]) -> str:
    if sys.platform != "win32" and done.returncode == -signal.SIGPROF:
        return "it does not finish with this file"
    if done.returncode < 0:
        return f"the file is damaged (the library was stopped by signal {-done.returncode})"
    lines = done.stderr.decode("utf-8", "replace").strip().splitlines()
    return printable(lines[-1].partition(": ")[2] or lines[-1]) if lines else f"exit status {done.returncode}"


def _parsed(answer: bytes) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    stream = io.BytesIO(answer)
    head = json.loads(stream.readline())
    arrays: dict[str, np.ndarray] = {}
    for name in head["arrays"]:
        array = np.lib.format.read_array(stream, allow_pickle=False)
        array.setflags(write=False)
        arrays[name] = array
    return head, arrays
