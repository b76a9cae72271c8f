"""Members of a background-sky file from an unknown source."""

from __future__ import annotations

import contextlib
import math
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.extras import optional_module
from aomc_sky.formats.hdf5_storage import (
    RefusedError,
    allowed_bytes,
    declared_bytes,
    require_hard_link,
    require_own_data,
    require_plain_chunks,
    require_size,
)
from aomc_sky.formats.report import Report, printable
from aomc_sky.formats.text_file import open_data, refuse

EXTRA = "hdf5"
TEXTS = {"Name": "name", "Author": "author", "Description": "description", "Organization": "organization"}
NUMBERS = {"FileType": "file_type", "FormatVersion": "format_version"}
OPTIONAL = ("Description", "Organization")
#: Members that say something to persons and nothing to us: no reason to refuse a file, whatever they hold.
INFORMING = tuple(f"{prefix}{name}" for prefix in ("Info/", "@") for name in ("FileType", *TEXTS))
#: Members that are read: paths, with ``*`` for any name and ``@name`` for an attribute of the root.
MEMBERS = (
    *(f"{prefix}{name}" for prefix in ("Info/", "@") for name in (*NUMBERS, *TEXTS)),
    "LobeAnims/*/Lobes",
    "LobeAnims/*/ReferenceTime",
    "SpectralCurves",
    "SpectralSamples",
)

RECORD_PARTS = ("Type", "Param0", "Param1", "Coeff", "LocalTransform", "CurveIndex", "RelativeTime", "TimePoint")
"""Members of the records of lobes and of reference times that are read."""

MAX_FILE_BYTES = 1 << 30
MAX_TEXT_BYTES = 65_536
MAX_VALUES_SHOWN = 1000
"""Values of a member that only informs; more are no text for a person."""
_LIBRARY = "the HDF5 library"
_AGAIN = "make the file again"


SPECTRA = ("SpectralSamples", "SpectralCurves")
UNITS, NEUTRAL, FILLS = ("units", "unit"), {"scale_factor": 1.0, "add_offset": 0.0}, ("_fillvalue", "missing_value")
STATING = (*UNITS, *NEUTRAL, *FILLS)
"""Attributes of the spectra that state something, as ``SpectralCurves@units``, in any letters; others are quoted."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Hdf5Members:
    """The requested members that the file has."""

    #: Paths of all groups and datasets seen, without the leading slash
    names: set[str] = field(default_factory=set)
    #: Numbers, as float32, float64, int64 or uint64; a member of a record under its own name
    #: (``LobeAnims/a/Lobes/Type``), an attribute of the root under ``@name``
    arrays: dict[str, np.ndarray] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)


def read_members(path: str | Path, report: Report) -> Hdf5Members:
    """Read `MEMBERS`.

    No other file is opened. Links other than hard ones, external and virtual storage are refused (E502). The reader
    also refuses sizes that the file cannot hold, filters other than gzip, shuffle and fletcher32 (E503), and members
    without numbers or text (E505). Members of `INFORMING` may be texts, lists of texts and numbers of any shape.
    Anything else is a warning.
    """
    h5py = optional_module("h5py", extra=EXTRA)
    with open_data(path, what="an HDF5 file", code="E500") as file:
        size = os.fstat(file.fileno()).st_size
        if size > MAX_FILE_BYTES:
            raise refuse(path, f"the file has {size} bytes; at most {MAX_FILE_BYTES} are read", code="E503")
        if not h5py.is_hdf5(path):
            raise refuse(path, "not an HDF5 file: its signature is missing", advice="name an HDF5 file", code="E501")
        reading = _Reading(h5py, size, report)
        try:
            # by its path: where a damaged file has no bytes, h5py asks a Python file object for them without end
            with h5py.File(path, "r", locking=False) as root:
                reading.read_all(root)
        except Exception as error:  # the library raises its own errors and Python's, whatever the damage is
            reason = printable(str(error) or type(error).__name__)
            raise refuse(path, f"{_LIBRARY} cannot read it: {reason}", advice=_AGAIN, code="E501") from error
    return reading.members


class _Reading:
    """The members read so far, and the bytes that further ones may declare."""

    def __init__(self, h5py: Any, n_bytes: int, report: Report) -> None:
        self.h5py, self.report = h5py, report
        self.budget = self.allowed = allowed_bytes(n_bytes)
        self.groups: set[Any] = set()
        self.members = Hdf5Members()

    def read_all(self, root: Any) -> None:
        """Walk through the file."""
        self.groups.add(root)
        for name in (path for path in MEMBERS if path.startswith("@")):
            with self._faults_named(f"attribute {name[1:]}", name):
                if name[1:] in root.attrs:
                    self._store(name, root.attrs.get_id(name[1:]), partial(root.attrs.get, name[1:]))
        self._group(root, ())

    @contextlib.contextmanager
    def _faults_named(self, shown: str, name: str) -> Iterator[None]:
        try:
            yield
        except RefusedError as refusal:
            is_warning = refusal.code == "E505" and name in INFORMING
            advice = refusal.advice
            self.report.add(refusal.code, refusal.message, name=printable(shown), advice=advice, is_warning=is_warning)
        except Exception as error:
            message = f"{_LIBRARY} cannot read it: {printable(str(error).partition(' (')[0])}"
            self.report.add("E501", message, name=printable(shown), advice=_AGAIN)

    def _group(self, group: Any, path: tuple[str, ...]) -> None:
        for name in group:
            here = (*path, name)
            with self._faults_named("/" + "/".join(here), "/".join(here)):
                self._member(group, name, here)

    def _member(self, group: Any, name: str, path: tuple[str, ...]) -> None:
        if name in ("", ".", "..") or "/" in name:
            raise RefusedError("E502", "a name that points to another group", "name it without slashes and dots")
        require_hard_link(group, name)
        item = group[name]
        if isinstance(item, self.h5py.Group):
            if item in self.groups:
                raise RefusedError("E502", "the same group has a second name", "give every group one name")
            self.groups.add(item)
            self.members.names.add("/".join(path))
            if _is_read(path, leaf=False):
                self._group(item, path)
            return
        self.members.names.add("/".join(path))
        if isinstance(item, self.h5py.Dataset) and _is_read(path, leaf=True):
            require_own_data(item)
            require_size(declared_bytes(item), self.budget, self.allowed, "an array")  # before a chunk is unpacked
            require_plain_chunks(item, self.budget)
            self._store("/".join(path), item, partial(item.__getitem__, ()))
            for word in item.attrs if path[0] in SPECTRA else ():
                if word.lower() in STATING or self._informs(item.attrs.get_id(word)):
                    self._store(f"{path[0]}@{word}", item.attrs.get_id(word), partial(item.attrs.get, word))

    def _informs(self, attribute: Any) -> bool:
        """Whether an attribute is one text or number of a harmless size, and not one of very many."""
        dtype, shape, is_full = attribute.dtype, attribute.shape, len(self.members.texts) >= MAX_VALUES_SHOWN
        if shape is None or math.prod(shape) != 1 or dtype.itemsize > MAX_TEXT_BYTES or is_full:
            return False
        return dtype.kind in "iuf" or self.h5py.check_string_dtype(dtype) is not None

    def _store(self, name: str, item: Any, values: Callable[[], Any]) -> None:
        """Take the values of a dataset or an attribute whose type and size are harmless."""
        is_informing = name in INFORMING
        if item.shape is None:
            if not is_informing:
                raise RefusedError("E505", "it is empty (a null dataspace)", "write its values")
            self.members.texts[name] = ""
            return
        n_values, n_bytes = math.prod(item.shape), declared_bytes(item)
        require_size(n_bytes, self.budget, self.allowed, "an array")
        self.budget -= n_bytes
        if is_informing and n_values > MAX_VALUES_SHOWN:
            raise RefusedError("E505", f"{n_values} values; at most {MAX_VALUES_SHOWN} are shown", "write one text")
        if self.h5py.check_string_dtype(item.dtype) is not None:
            width = item.dtype.itemsize
            if (n_values != 1 and not is_informing) or width > MAX_TEXT_BYTES:
                found = f"{n_values} texts of {width} bytes; numbers are read, or one text of at most 64 kB"
                raise RefusedError("E505", found, "write numbers, or one text")
            self.members.texts[name] = _text(np.asarray(values(), item.dtype))
            return
        if item.dtype.names is None:
            _require_numbers(item.dtype)
            self.members.arrays[name] = _plain(np.asarray(values()))
            return
        parts = [part for part in item.dtype.names if part in RECORD_PARTS]  # others are no reason to refuse a file
        if not parts or not isinstance(item, self.h5py.Dataset):
            raise RefusedError("E505", "a record of other members than those of lobes and times", "write numbers")
        for part in parts:
            _require_numbers(item.dtype[part])
        array = np.asarray(item.fields(parts)[()])
        self.members.arrays.update({f"{name}/{part}": _plain(array[part]) for part in parts})


def _is_read(path: tuple[str, ...], *, leaf: bool) -> bool:
    """Whether this path is a member that is read, or a group that holds one."""
    return any(
        (len(member) == len(path) if leaf else len(member) > len(path))
        and all(a in ("*", b) for a, b in zip(member, path, strict=False))
        for member in (one.split("/") for one in MEMBERS)
    )


def _text(array: np.ndarray) -> str:
    """One text, or several with commas between them."""
    texts, n_left = [], MAX_TEXT_BYTES
    for value in array.reshape(-1):
        data = value if isinstance(value, bytes) else str(value or "").encode("utf-8", "surrogateescape")
        texts.append(bytes(data[:n_left]).rstrip(b"\0 ").decode("utf-8", "replace"))
        n_left = max(n_left - len(data), 0)
    return ", ".join(text for text in texts if text)


def _require_numbers(dtype: np.dtype) -> None:
    if dtype.base.kind not in "biuf":
        raise RefusedError("E505", "a value that is not a number (text, reference or list)", "write numbers")


def _plain(array: np.ndarray) -> np.ndarray:
    """The numbers in this machine's order, as float32, float64, int64 or uint64; read-only."""
    real = np.float32 if array.dtype.itemsize <= 4 else np.float64
    kinds: dict[str, Any] = {"f": real, "i": np.int64, "u": np.uint64, "b": np.int64}
    plain = np.ascontiguousarray(array, kinds[array.dtype.kind]).reshape(array.shape)
    plain.setflags(write=False)
    return plain
