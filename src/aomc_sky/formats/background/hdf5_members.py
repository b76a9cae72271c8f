"""Members of an HDF5 file that nobody vouches for, read by a process of its own."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from aomc_sky.extras import optional_module
from aomc_sky.formats.child_process import answer_of_child, opened, parsed_answer, printable
from aomc_sky.formats.report import Report
from aomc_sky.formats.text_file import refuse

MAX_FILE_BYTES = 1 << 30
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_CHILD = "aomc_sky.formats.background.hdf5_child"
_LIBRARY = "the HDF5 library"
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
    with opened(path, what="an HDF5 file", code="E500") as file:
        size = os.fstat(file.fileno()).st_size
        if size > MAX_FILE_BYTES:
            raise refuse(path, f"the file has {size} bytes; at most {MAX_FILE_BYTES} are read", code="E503")
        if not _has_signature(file, size):
            raise refuse(path, "not an HDF5 file: its signature is missing", advice="name an HDF5 file", code="E501")
        file.seek(0)
        answer = _ask_child(path, file, requested, informing, cpu_s=0.25 + size / 2e6)
    try:
        head, arrays = parsed_answer(answer)
        harmless = {f"attribute {name[1:]}" if name.startswith("@") else f"/{name}" for name in informing}
        for code, name, message, advice in head["faults"]:
            is_warning = code == "E505" and name in harmless
            report.add(code, message, name=printable(name), advice=advice, is_warning=is_warning)
        return Hdf5Members(names=frozenset(head["names"]), arrays=arrays, texts=head["texts"])
    except (ValueError, TypeError, KeyError, EOFError) as error:  # the child died in the middle of its answer
        raise refuse(path, f"{_LIBRARY} cannot read it: the file is damaged", advice=_AGAIN, code="E501") from error


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
    task = [[w.split("/") for w in requested], cpu_s, list(informing)]
    return answer_of_child(path, file, _CHILD, task, cpu_s=cpu_s, library=_LIBRARY, code="E501")
