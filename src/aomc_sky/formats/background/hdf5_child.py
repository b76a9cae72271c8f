"""The process that opens an HDF5 file for us, for a damaged file can end or hang the HDF5 library.

It takes the file as standard input and its limits as arguments, and opens no file by name. `hdf5_members` starts it
and judges what comes back.
"""

from __future__ import annotations

import contextlib
import math
import sys
import zlib
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np

from aomc_sky.formats.child_process import write_answer
from aomc_sky.system import limit_process

MAX_DEPTH = 4
MAX_FIELDS = 64
MAX_TEXT_BYTES = 65_536
MAX_VALUES_SHOWN = 1000
"""Values of a member that only informs; more are no text for a person."""
SPARE_BYTES = 96 << 20
"""Memory beyond a multiple of the size of the file. [bytes]"""
UNPACKED_BYTES = 16 << 20
"""What may be declared beyond a multiple of the size of the file. [bytes]"""
_DEFLATE, _SHUFFLE, _FLETCHER32 = 1, 2, 3


class RefusedError(Exception):
    """A member that is not read: code, what was found, what to write."""


class Reading:
    """What has been read of one file, and how many bytes more it may declare.

    `requested` are paths, with ``*`` for any name; values of those in `informing` are for persons, whatever their
    type and shape.
    """

    def __init__(self, h5py: Any, data: bytes, requested: list[list[str]], informing: list[str]) -> None:
        self.h5py = h5py
        self.requested = requested
        self.informing = frozenset(informing)
        # numbers pack to a half or a quarter, seldom to less
        self.budget = self.allowed = min(100 * len(data), 4 * len(data) + UNPACKED_BYTES)
        self.n_links = len(data) // 8
        self.groups: set[int] = set()
        self.faults: list[tuple[str, str, str, str]] = []
        self.names: list[str] = []
        self.texts: dict[str, str] = {}
        self.arrays: dict[str, np.ndarray] = {}
        access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
        access.set_fapl_core(backing_store=False)
        access.set_file_image(data)
        self.file = h5py.h5f.open(b"input", flags=h5py.h5f.ACC_RDONLY, fapl=access)

    def read_all(self) -> None:
        """Walk through the file."""
        root = self.h5py.h5g.open(self.file, b"/")
        self.groups.add(self.h5py.h5o.get_info(root).addr)
        self._attributes(root)
        self._group(root, ())

    def _attributes(self, root: Any) -> None:
        h5a = self.h5py.h5a
        names = [w[0][1:] for w in self.requested if w[0].startswith("@")]
        for name in names:
            with self._faults_of(f"attribute {name}"):
                if h5a.exists(root, name.encode()):
                    attribute = h5a.open(root, name.encode())
                    self._store(f"@{name}", attribute)

    def _group(self, group: Any, path: tuple[str, ...]) -> None:
        names: list[bytes] = []
        group.links.iterate(lambda name: names.append(name) if len(names) <= self.n_links else 0)
        self.n_links -= len(names)
        if self.n_links < 0:
            raise RefusedError("E503", "more links than the file can hold", "make the file again")
        for raw in names:
            here = (*path, raw.decode("utf-8", "replace"))
            with self._faults_of("/" + "/".join(here)):
                self._member(group, raw, here)

    @contextlib.contextmanager
    def _faults_of(self, name: str) -> Iterator[None]:
        try:
            yield
        except RefusedError as refusal:
            self.faults.append((refusal.args[0], name, refusal.args[1], refusal.args[2]))
        except MemoryError:
            raise
        except Exception as error:
            reason = str(error).partition(" (")[0]
            self.faults.append(("E501", name, f"the HDF5 library cannot read it: {reason}", "make the file again"))

    def _member(self, group: Any, raw: bytes, path: tuple[str, ...]) -> None:
        h5py = self.h5py
        if raw in (b"", b".", b"..") or b"/" in raw:
            raise RefusedError("E502", "a name that points to another group", "name it without slashes and dots")
        if group.links.get_info(raw).type != h5py.h5l.TYPE_HARD:
            raise RefusedError(
                "E502",
                "a link to a name or to another file; only data in this file itself are read",
                "copy the data into the file (h5copy -f soft,ext)",
            )
        info = h5py.h5o.get_info(group, raw)
        if info.type == h5py.h5o.TYPE_GROUP:
            if info.addr in self.groups:
                raise RefusedError("E502", "the same group has a second name", "give every group one name")
            self.groups.add(info.addr)
            self.names.append("/".join(path))
            if len(path) <= MAX_DEPTH and self._is_requested(path, leaf=False):
                self._group(h5py.h5g.open(group, raw), path)
            return
        self.names.append("/".join(path))
        if info.type == h5py.h5o.TYPE_DATASET and self._is_requested(path, leaf=True):
            dataset = h5py.h5d.open(group, raw)
            self._check_storage(dataset)
            self._store("/".join(path), dataset)

    def _is_requested(self, path: tuple[str, ...], *, leaf: bool) -> bool:
        return any(
            (len(w) == len(path) if leaf else len(w) > len(path))
            and all(a in ("*", b) for a, b in zip(w, path, strict=False))
            for w in self.requested
        )

    def _check_storage(self, dataset: Any) -> None:
        """Refuse what lies in other files, and what is larger unpacked than its declared size."""
        h5d = self.h5py.h5d
        plan = dataset.get_create_plist()
        layout = plan.get_layout()
        if layout == h5d.VIRTUAL or plan.get_external_count():
            raise RefusedError("E502", "its data are in another file", "write the data into the file (h5repack)")
        self._check_size(self._n_bytes(dataset), "an array")  # before any of its chunks is unpacked
        filters = [plan.get_filter(k)[0] for k in range(plan.get_nfilters())]
        rest = [f for f in filters if f != _SHUFFLE]
        if len(filters) > 3 or rest not in ([], [_DEFLATE], [_DEFLATE, _FLETCHER32], [_FLETCHER32]):
            advice = "h5repack -f GZIP=6, or -f NONE"
            raise RefusedError("E503", f"filters {filters}; gzip with shuffle and fletcher32 are read", advice)
        if layout != h5d.CHUNKED:
            return
        n_bytes = math.prod(plan.get_chunk()) * int(dataset.get_type().get_size())
        self._check_size(n_bytes, "a chunk")
        if _DEFLATE in filters:
            masked = 1 << filters.index(_DEFLATE)
            chunks: list[Any] = []
            dataset.chunk_iter(chunks.append)
            for chunk in chunks:
                if not chunk.filter_mask & masked:
                    self._check_chunk(dataset, chunk, n_bytes)

    def _check_chunk(self, dataset: Any, chunk: Any, n_bytes: int) -> None:
        self._check_size(chunk.size, "a stored chunk")
        _, data = dataset.read_direct_chunk(chunk.chunk_offset)
        if len(zlib.decompressobj().decompress(data, n_bytes + 1)) > n_bytes:
            raise RefusedError("E503", "a compressed chunk holds more bytes than it declares", "make the file again")

    def _check_size(self, n_bytes: int, what: str) -> None:
        if n_bytes > self.budget:
            raise RefusedError(
                "E503",
                f"{what} of {n_bytes} bytes is declared; of a file of this size {self.allowed} bytes in all are read",
                "write only the rows that the file has, with less compression (h5repack -f NONE)",
            )

    def _store(self, name: str, item: Any) -> None:
        """Read one dataset or attribute whose type and size are harmless."""
        space, kind = item.get_space(), item.get_type()
        if space.get_simple_extent_type() == self.h5py.h5s.NULL:
            if name in self.informing:
                self.texts[name] = ""
                return
            raise RefusedError("E505", "it is empty (a null dataspace)", "write its values")
        shape = space.get_simple_extent_dims()
        n_bytes = self._n_bytes(item)
        self._check_size(n_bytes, "an array")
        self.budget -= n_bytes
        if name in self.informing and math.prod(shape) > MAX_VALUES_SHOWN:
            found = f"{math.prod(shape)} values; at most {MAX_VALUES_SHOWN} are shown"
            raise RefusedError("E505", found, "write one text")
        if kind.get_class() == self.h5py.h5t.STRING:
            self.texts[name] = self._text(item, kind, shape, is_list=name in self.informing)
            return
        self._check_type(kind)
        array = np.empty(shape, kind.dtype)
        self._fill(item, array)
        if array.dtype.names is None:
            self.arrays[name] = _plain(array)
        else:
            self.arrays |= {f"{name}/{field}": _plain(array[field]) for field in array.dtype.names}

    def _n_bytes(self, item: Any) -> int:
        """What a dataset or attribute declares, in whole numbers without an end."""
        space = item.get_space()
        if space.get_simple_extent_type() == self.h5py.h5s.NULL:
            return 0
        return math.prod(space.get_simple_extent_dims()) * int(item.get_type().get_size())

    def _fill(self, item: Any, array: np.ndarray) -> None:
        if isinstance(item, self.h5py.h5a.AttrID):
            item.read(array)
        else:
            item.read(self.h5py.h5s.ALL, self.h5py.h5s.ALL, array)

    def _text(self, item: Any, kind: Any, shape: tuple[int, ...], *, is_list: bool) -> str:
        """One text, or several with commas between them where that may be."""
        n_values = math.prod(shape)
        if (n_values != 1 and not is_list) or kind.get_size() > MAX_TEXT_BYTES:
            found = f"{n_values} texts of {kind.get_size()} bytes; numbers are read, or one text of at most 64 kB"
            raise RefusedError("E505", found, "write numbers, or one text")
        array = np.empty(shape, kind.dtype)
        self._fill(item, array)
        texts, n_left = [], MAX_TEXT_BYTES
        for value in array.reshape(-1):
            data = value if isinstance(value, bytes) else str(value or "").encode("utf-8", "surrogateescape")
            texts.append(bytes(data[:n_left]).rstrip(b"\0 ").decode("utf-8", "replace"))
            n_left = max(n_left - len(data), 0)
        return ", ".join(text for text in texts if text)

    def _check_type(self, kind: Any) -> None:
        h5t = self.h5py.h5t
        number = (h5t.INTEGER, h5t.FLOAT, h5t.ENUM)
        parts = [kind]
        if kind.get_class() == h5t.COMPOUND:
            if kind.get_nmembers() > MAX_FIELDS:
                raise RefusedError("E505", f"{kind.get_nmembers()} members in one record", "write the members named")
            parts = [kind.get_member_type(k) for k in range(kind.get_nmembers())]
        for part in parts:
            inner = part.get_super() if part.get_class() == h5t.ARRAY else part
            if inner.get_class() not in number:
                raise RefusedError("E505", "a value that is not a number (text, reference or list)", "write numbers")


def _plain(array: np.ndarray) -> np.ndarray:
    """The numbers in this machine's order, as float32, float64, int64 or uint64."""
    real = np.float32 if array.dtype.itemsize <= 4 else np.float64
    kinds: dict[str, Any] = {"f": real, "i": np.int64, "u": np.uint64, "b": np.int64}
    return np.ascontiguousarray(array, kinds[array.dtype.kind])


def main(requested: list[list[str]], cpu_s: float, informing: list[str]) -> None:
    """Read standard input, write the answer, and end."""
    h5py = import_module("h5py")  # an extra

    data = sys.stdin.buffer.read()
    limit_process(12 * len(data) + SPARE_BYTES, cpu_s)
    reading = Reading(h5py, data, requested, informing)
    try:
        reading.read_all()
    except RefusedError as refusal:
        reading.faults.append((refusal.args[0], "", *refusal.args[1:]))
    head = {"faults": reading.faults, "names": reading.names, "texts": reading.texts}
    write_answer(head, reading.arrays)
