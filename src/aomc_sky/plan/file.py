"""The members of a plan as a file, plan.npz, and the hash over them.

The file holds its own hash: a changed or damaged file is refused first. No member is ever unpickled, and none is longer
than the file, so reading takes no more memory than the length of the file.
"""

from __future__ import annotations

import hashlib
import io
import json
import math
import os
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.errors import InputFileError, OutputError
from aomc_sky.formats.text_file import refuse
from aomc_sky.plan.check import check_stream
from aomc_sky.plan.sampling.streams import STREAM_VERSION
from aomc_sky.system import FileKindError, open_regular

MAX_PLAN_BYTES = 2**34
"""Largest plan that is read. [bytes]"""

_OPTIONS, _SHA256 = "options", "sha256"
_MAX_HEADER = 1000


def sha256_of(members: Mapping[str, np.ndarray], options: Mapping[str, Any]) -> str:
    """SHA-256 over sorted name, dtype, shape, little-endian bytes, and options."""
    digest = hashlib.sha256()
    digest.update(STREAM_VERSION.encode() + b"\0")
    for name in sorted(members):
        array = members[name]
        little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
        head = f"{name}\0{little.dtype.str}\0{','.join(map(str, little.shape))}\0"
        digest.update(head.encode())
        digest.update(little.data if little.size else b"")
    digest.update(_json(options))
    return digest.hexdigest()


def npz_bytes(members: Mapping[str, np.ndarray], options: Mapping[str, Any]) -> bytes:
    """The members, their options and the hash as the bytes of an npz file."""
    buffer = io.BytesIO()
    stored: dict[str, Any] = {
        _OPTIONS: np.frombuffer(_json(options), dtype=np.uint8),
        **dict(sorted(members.items())),
        _SHA256: np.frombuffer(bytes.fromhex(sha256_of(members, options)), dtype=np.uint8),
    }
    np.savez(buffer, **stored)
    return buffer.getvalue()


def read_npz(path: str | Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Members and options of a file that fits its hash; E951, or E955 for a plan of another stream."""
    members = _members(path)
    text, digest = members.pop(_OPTIONS, None), members.pop(_SHA256, None)
    try:
        options = json.loads(bytes(text))  # type: ignore[arg-type]
    except (TypeError, ValueError, RecursionError):
        raise _not_a_plan(path, "is not a plan: it holds no options") from None
    check_stream(options, str(path))
    if digest is None or digest.tobytes() != bytes.fromhex(sha256_of(members, options)):
        raise _not_a_plan(path, "does not fit its own SHA-256: it was changed or damaged after it was written")
    return members, options


def _json(options: Mapping[str, Any]) -> bytes:
    return json.dumps(options, sort_keys=True, separators=(",", ":")).encode()


def _not_a_plan(path: str | Path, message: str, advice: str = "make the run again") -> InputFileError:
    """The error for a file that is not a plan."""
    return refuse(path, message, advice=advice, code="E951")


def _members(path: str | Path) -> dict[str, np.ndarray]:
    """All arrays of the file, read-only; E951 for any problem."""
    try:
        with open_regular(path) as file, zipfile.ZipFile(file) as stored:
            size = os.fstat(file.fileno()).st_size
            infos = stored.infolist()
            is_packed = any(info.compress_type != zipfile.ZIP_STORED for info in infos)
            if is_packed or size > MAX_PLAN_BYTES or sum(info.file_size for info in infos) > size:
                raise _not_a_plan(
                    path, f"it has {size} bytes, and packed or longer members; we store arrays as they are"
                )
            return {info.filename.removesuffix(".npy"): _array(stored, info) for info in infos}
    except FileNotFoundError:
        raise _not_a_plan(path, "is not a readable plan: there is no such file", "name the folder of a run") from None
    except FileKindError as error:
        raise _not_a_plan(path, f"this is {error.kind}, expected a plan", "name the folder of a run") from None
    except OSError as error:
        raise OutputError(f"cannot read {path}: {error.strerror or error}") from error
    except (InputFileError, MemoryError):
        raise
    except Exception as error:  # zipfile, zlib and numpy each have their own
        raise _not_a_plan(path, f"is not a readable plan ({error})") from error


def _array(stored: zipfile.ZipFile, info: zipfile.ZipInfo) -> np.ndarray:
    """One array, read-only; its head must give the exact number of bytes, and a type of numbers."""
    with stored.open(info) as member:
        if np.lib.format.read_magic(member) != (1, 0):
            raise ValueError(f"{info.filename} is not a numpy array of version 1.0")
        shape, is_fortran, dtype = np.lib.format.read_array_header_1_0(member, max_header_size=_MAX_HEADER)
        n_bytes = math.prod(shape) * dtype.itemsize
        if dtype.kind not in "iufb" or is_fortran or min(shape, default=0) < 0:
            raise ValueError(f"{info.filename} holds {dtype}, expected an array of numbers in C order")
        if member.tell() + n_bytes != info.file_size:
            raise ValueError(f"{info.filename} says {n_bytes} bytes and holds {info.file_size - member.tell()}")
        data = member.read()
    return np.ndarray(shape, dtype, buffer=data)
