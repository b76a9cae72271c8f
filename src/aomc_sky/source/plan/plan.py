"""What every shard, export and check reads and never recomputes, and plan.npz, its file, read as a stranger's.

Kind, sizes and members of a file are judged before anything is read. `Plan.save` writes members one after the other as
they are in memory, so a plan that takes more memory than its file is long was not written by us. No member is ever
unpickled: the type of each is looked at first.
"""

from __future__ import annotations

import hashlib
import io
import json
import math
import os
import re
import struct
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from aomc_sky.errors import InputFileError, OutputError
from aomc_sky.float_mode import in_default_mode
from aomc_sky.formats.text_file import refuse
from aomc_sky.grid import PatchGrid
from aomc_sky.regular_file import FileKindError, open_regular
from aomc_sky.sampling.streams import STREAM_VERSION
from aomc_sky.source.plan.schema import MAX_PLAN_BYTES, check_plan

MAX_MEMBERS = 2**16
"""Most arrays of a plan: four for each of 16 000 components."""

MAX_OPTIONS_BYTES = 2**24

_OPTIONS_MEMBER = "options"

_NAME = re.compile(r"([A-Za-z_][A-Za-z0-9_]{0,40})\.npy")
_ENTRY_BYTES = 256  # of a member in the directory of a zip file, its name included
_END, _END_64, _LOCATOR_64 = struct.Struct("<4s4H2LH"), struct.Struct("<4sQ2H2L4Q"), struct.Struct("<4sLQL")
_MAX_HEADER = 1000

StoredPlan = tuple[dict[str, np.ndarray], dict[str, Any]]


@dataclass(frozen=True, kw_only=True, slots=True)
class Plan:
    """The settled part of a run; photons are a pure function of it.

    Parameters
    ----------
    arrays : dict of ndarray
        `wavelength_nm`, `sky_wavelength_nm`, `requested` (n_band,); `cumulative` int64
        (n_replicate x n_band, n_cell + 1), photons before each cell, one replicate band after the other; `row_of_band`
        (n_band,); `mass` float64 (n_row, n_cell), sums to 1; `weight` (n_row, n_cell) or (0, 0);
        `law` int8 and `cell` float64 (n_cell, 6); `component_start` (n_component + 1,);
        `keys` uint64, one per stream; and for each component k with patches `zenith_bounds_deg_k`,
        `azimuth_bounds_deg_k`, for one of law PEREZ also `shared_k` (11,) and `bounds_k` (cells of the
        component, 2). Where absolute units are known there are `irradiance_W_m2_nm` float64
        (n_band, n_component) and `horizon_loss` float64 (n_band,), which change no photon.
    options : dict
        Everything else that changes photons, and names: JSON values only.

    Notes
    -----
    A replicate band is one replicate of one band; its number, replicate x n_bands + band, stands in every
    random counter where the band stands in a run without replicates, so that all are independent.
    `aomc_sky.source.plan.schema` has every rule that a plan keeps; whoever emits photons asks for `check` first.
    """

    arrays: dict[str, np.ndarray]
    options: dict[str, Any]
    _checked: tuple[dict[str, np.ndarray], str] | None = field(default=None, init=False, repr=False, compare=False)

    def check(self, path: str | Path = "plan") -> None:
        """Raise unless the plan keeps the schema; of equal read-only arrays and options only the first time.

        Parameters
        ----------
        path : str or Path
            What the message calls the plan.

        Raises
        ------
        InputFileError
            E952 to E955, naming the member, what was found and what is allowed.
        """
        if self._checked is not None:
            arrays, options = self._checked
            same = arrays.keys() == self.arrays.keys() and all(a is self.arrays[n] for n, a in arrays.items())
            if same and options == repr(self.options):
                return
        check_plan(self.arrays, self.options, str(path))
        if not any(array.flags.writeable for array in self.arrays.values()):
            object.__setattr__(self, "_checked", (dict(self.arrays), repr(self.options)))

    @property
    def seed(self) -> int:
        """Seed of the run."""
        return int(self.options["seed"])

    @property
    def n_bands(self) -> int:
        """Number of wavebands."""
        return int(self.arrays["wavelength_nm"].size)

    @property
    def replicates(self) -> int:
        """Independent randomisations that share the photons of each band."""
        return int(self.arrays["cumulative"].shape[0]) // self.n_bands

    @property
    def n_cells(self) -> int:
        """Number of cells of all components."""
        return int(self.arrays["cell"].shape[0])

    @property
    def component_names(self) -> tuple[str, ...]:
        """Names of the components in the order of their cells."""
        return tuple(self.options["components"])

    def grid_of(self, component: int) -> PatchGrid | None:
        """Patches of a component, None for a beam or a disc."""
        if f"zenith_bounds_deg_{component}" not in self.arrays:
            return None
        return PatchGrid(
            zenith_bounds_deg=self.arrays[f"zenith_bounds_deg_{component}"],
            azimuth_bounds_deg=self.arrays[f"azimuth_bounds_deg_{component}"],
            azimuth_first_index=int(self.options["azimuth_first_index"][component]),
        )

    @property
    def sha256(self) -> str:
        """Name of the run: SHA-256 over sorted name, dtype, shape, little-endian bytes, and options."""
        digest = hashlib.sha256()
        digest.update(STREAM_VERSION.encode() + b"\0")
        for name in sorted(self.arrays):
            array = self.arrays[name]
            little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
            head = f"{name}\0{little.dtype.str}\0{','.join(map(str, little.shape))}\0"
            digest.update(head.encode())
            digest.update(little.data if little.size else b"")
        digest.update(json.dumps(self.options, sort_keys=True, separators=(",", ":")).encode())
        return digest.hexdigest()

    def to_bytes(self) -> bytes:
        """The plan as the bytes of an npz file; equal plans give equal bytes."""
        buffer = io.BytesIO()
        text = json.dumps(self.options, sort_keys=True, separators=(",", ":"))
        arrays: dict[str, Any] = dict(sorted(self.arrays.items()))
        np.savez(buffer, options=np.frombuffer(text.encode(), dtype=np.uint8), **arrays)
        return buffer.getvalue()

    def save(self, path: str | Path) -> None:
        """Write the plan; `aomc_sky.outputs` does it atomically."""
        try:
            Path(path).write_bytes(self.to_bytes())
        except OSError as error:
            raise OutputError(f"cannot write {path}: {error.strerror or error}") from error

    @classmethod
    @in_default_mode
    def load(cls, path: str | Path) -> Plan:
        """Read a plan that `save` wrote.

        Raises
        ------
        InputFileError
            E951 to E955: the file is missing, damaged, or not a plan.
        OutputError
            The operating system refuses.
        """
        arrays, options = read_plan_file(path)
        plan = cls(arrays=arrays, options=options)
        plan.check(path)
        return plan


def not_a_plan(path: str | Path, message: str, advice: str = "make the run again") -> InputFileError:
    """The error for a file that is no plan as a whole."""
    return refuse(path, message, advice=advice, code="E951")


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
