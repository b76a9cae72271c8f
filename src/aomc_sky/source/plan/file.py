"""plan.npz as a stranger's file: its kind, its sizes and its members are judged before anything is read.

The errors of such a file stand here too: `not_a_plan` for the file, `PlanRuleError` for a rule of the schema.

`Plan.save` writes members one after the other as they are in memory, so a plan that takes more memory than its file is
long was not written by us. No member is ever unpickled: the type of each is looked at first.
"""

from __future__ import annotations

import json
import math
import os
import re
import struct
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from aomc_sky.errors import InputFileError, OutputError, Problem
from aomc_sky.formats.text_file import refuse
from aomc_sky.regular_file import FileKindError, open_regular

MAX_PLAN_BYTES = 2**34
"""Largest plan that is written or read: what the machines that run it hold."""

MAX_MEMBERS = 2**16
"""Most arrays of a plan: four for each of 16 000 components."""

MAX_OPTIONS_BYTES = 2**24

_OPTIONS_MEMBER = "options"

_NAME = re.compile(r"([A-Za-z_][A-Za-z0-9_]{0,40})\.npy")
_ENTRY_BYTES = 256  # of a member in the directory of a zip file, its name included
_END, _END_64, _LOCATOR_64 = struct.Struct("<4s4H2LH"), struct.Struct("<4sQ2H2L4Q"), struct.Struct("<4sLQL")
_MAX_HEADER = 1000
_MOST_SHOWN = 100

Arrays = Mapping[str, np.ndarray]
StoredPlan = tuple[dict[str, np.ndarray], dict[str, Any]]


def not_a_plan(path: str | Path, message: str, advice: str = "make the run again") -> InputFileError:
    """The error for a file that is no plan as a whole."""
    return refuse(path, message, advice=advice, code="E951")


class PlanRuleError(Exception):
    """Code, member, and what is wrong with it; `naming` adds the path."""

    def __init__(self, code: str, member: str, message: str) -> None:
        self.code, self.member, self.message = code, member, message
        super().__init__(code, member, message)


def refuse_value(member: str, found: object, expected: str) -> PlanRuleError:
    """The problem of values that a plan cannot have (E954)."""
    text = found if isinstance(found, str) else shown(found)
    return PlanRuleError("E954", member, f"found {text}, wanted {expected}")


def shown(value: object) -> str:
    """A value for a message: short, and without characters that a terminal obeys."""
    text = ascii(value.item() if isinstance(value, np.generic) else value)
    return text if len(text) <= _MOST_SHOWN else f"{text[: _MOST_SHOWN - 3]}..."


@contextmanager
def naming(path: str) -> Iterator[None]:
    """Turn the problem of a rule into the error of a file, with code, path and member."""
    try:
        yield
    except PlanRuleError as rule:
        problem = Problem(
            path=path,
            line=0,
            column=0,
            code=rule.code,
            field=rule.member,
            message=rule.message,
            advice="make the run again, or take the plan.npz that it wrote",
        )
        raise InputFileError([problem]) from None


def read_plan_file(path: str | Path) -> StoredPlan:
    """Read all arrays of a plan, read-only, and its options; what they mean is not looked at. E951: no such plan."""
    with _stored(path) as (stored, members):
        options = _options(stored, members, path)
        arrays = {n: _array(stored, info, path) for n, info in members.items() if n != _OPTIONS_MEMBER}
    return arrays, options


def member_names(path: str | Path) -> frozenset[str]:
    """Names of the arrays of a plan, which say what kind of plan it is; errors as of `read_plan_file`."""
    with _stored(path) as (_, members):
        return frozenset(members) - {_OPTIONS_MEMBER}


@contextmanager
def _stored(path: str | Path) -> Iterator[tuple[zipfile.ZipFile, dict[str, zipfile.ZipInfo]]]:
    """The open file and its members; E951 for whatever goes wrong inside it."""
    with _opened(path) as file:
        try:
            with zipfile.ZipFile(_judged(file, path)) as stored:
                yield stored, _members(stored, os.fstat(file.fileno()).st_size, path)
        except (InputFileError, MemoryError):
            raise
        except Exception as error:  # zipfile, zlib, numpy and json each have their own
            raise not_a_plan(path, f"is not a readable plan ({error})") from error


def _opened(path: str | Path) -> BinaryIO:
    try:
        return open_regular(path)
    except FileNotFoundError:
        raise not_a_plan(path, "is not a readable plan: there is no such file", "name the folder of a run") from None
    except FileKindError as error:
        raise not_a_plan(path, f"this is {error.kind}, wanted a plan", "name the folder of a run") from None
    except OSError as error:
        raise OutputError(f"cannot read {path}: {error.strerror or error}") from error


def _judged(file: BinaryIO, path: str | Path) -> BinaryIO:
    """The file, if neither it nor its directory is longer than that of a plan can be."""
    size = os.fstat(file.fileno()).st_size
    if size > MAX_PLAN_BYTES:
        raise not_a_plan(path, f"the file has {size} bytes; a plan has at most {MAX_PLAN_BYTES}")
    directory = _directory_bytes(file, size)
    if directory is None:
        raise not_a_plan(
            path, "is not a readable plan: not a zip file, or one that is cut short or has data after its end"
        )
    if directory > MAX_MEMBERS * _ENTRY_BYTES:
        raise not_a_plan(path, f"its directory has {directory} bytes; that of {MAX_MEMBERS} arrays is shorter")
    return file


def _directory_bytes(file: BinaryIO, size: int) -> int | None:
    """Length of the directory as the last bytes of the file say it; None where they say nothing."""
    tail = min(size, _LOCATOR_64.size + _END_64.size + _END.size)
    file.seek(size - tail)
    data = file.read(tail)
    if len(data) < _END.size or not data[-_END.size :].startswith(b"PK\x05\x06"):
        return None
    n_bytes = int(_END.unpack(data[-_END.size :])[5])
    if data[-_END.size - _LOCATOR_64.size :].startswith(b"PK\x06\x07"):
        if not data.startswith(b"PK\x06\x06"):
            return None
        n_bytes = max(n_bytes, int(_END_64.unpack(data[: _END_64.size])[8]))
    return n_bytes


def _members(stored: zipfile.ZipFile, size: int, path: str | Path) -> dict[str, zipfile.ZipInfo]:
    """Members by the names of their arrays: plain names, each once, stored as they are, no longer than the file."""
    members: dict[str, zipfile.ZipInfo] = {}
    for info in stored.infolist():
        name = _NAME.fullmatch(info.filename)
        if name is None:
            raise not_a_plan(path, f"holds a member {info.filename[:60]!r}; a plan holds only arrays with plain names")
        if name[1] in members:
            raise not_a_plan(path, f"holds {info.filename} twice")
        if info.flag_bits & 1 or info.compress_type != zipfile.ZIP_STORED or info.file_size != info.compress_size:
            raise not_a_plan(path, f"{info.filename} is compressed or encrypted; a plan holds its arrays uncompressed")
        members[name[1]] = info
    total = sum(info.file_size for info in members.values())
    if total > size:
        raise not_a_plan(path, f"its members have {total} bytes and the file {size}: they overlap")
    return members


def _options(stored: zipfile.ZipFile, members: dict[str, zipfile.ZipInfo], path: str | Path) -> dict[str, Any]:
    if _OPTIONS_MEMBER not in members:
        raise not_a_plan(path, "is not a plan: it holds no options")
    if members[_OPTIONS_MEMBER].file_size > MAX_OPTIONS_BYTES:
        raise not_a_plan(
            path, f"its options have {members[_OPTIONS_MEMBER].file_size} bytes, at most {MAX_OPTIONS_BYTES}"
        )
    text = _array(stored, members[_OPTIONS_MEMBER], path)
    if text.dtype != np.uint8 or text.ndim != 1:
        raise not_a_plan(path, f"its options are {text.dtype} of shape {text.shape}, wanted bytes in one dimension")
    options = json.loads(text.tobytes().decode())
    if not isinstance(options, dict):
        raise not_a_plan(path, "its options are not a JSON object")
    return options


def _array(stored: zipfile.ZipFile, info: zipfile.ZipInfo, path: str | Path) -> np.ndarray:
    """One array, read-only: its head says exactly as many bytes as there are, and no type that needs an object."""
    with stored.open(info) as member:
        if np.lib.format.read_magic(member) != (1, 0):
            raise not_a_plan(path, f"{info.filename} is not a numpy array of version 1.0")
        shape, is_fortran, dtype = np.lib.format.read_array_header_1_0(member, max_header_size=_MAX_HEADER)
        n_bytes = math.prod(shape) * dtype.itemsize
        if dtype.kind not in "iufb" or is_fortran or min(shape, default=0) < 0:
            raise not_a_plan(path, f"{info.filename} holds {dtype}, wanted an array of numbers in C order")
        if member.tell() + n_bytes != info.file_size:
            raise not_a_plan(path, f"{info.filename} says {n_bytes} bytes and holds {info.file_size - member.tell()}")
        data = member.read()
    return np.ndarray(shape, dtype, buffer=data)
