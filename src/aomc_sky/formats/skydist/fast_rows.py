"""The rows of a skydist.inp without a doubtful character, through numpy's own text reader."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np

from aomc_sky.formats.skydist.head import MIN_ROW_BYTES, SkyHead

_PLAIN = b"0123456789+-.eE \t\r\n"
MAX_LINES_AFTER = 50  # a comment and a few blank lines; more of them is a matter for the slow reader
_PIECE_BYTES = 1 << 22
_ROW = np.dtype([("wave", np.int64), ("zenith", np.int64), ("azimuth", np.int64), ("value", np.float64)])
_HOW: dict[str, Any] = {"dtype": _ROW, "comments": "#", "usecols": (0, 1, 2, 3), "ndmin": 1, "encoding": "latin-1"}


def read_rows_fast(data: bytes, head: SkyHead) -> tuple[np.ndarray, np.ndarray] | None:
    """Read all rows, or return None where anything is not plain: the slow reader then says what.

    Accepts only what `skydist_rows.read_rows` accepts without a message, with equal results.
    """
    if head.n_rows * MIN_ROW_BYTES > len(data) + 1:
        return None
    start = _offset_after(data, head.first_row)
    stop = _end_of_rows(data, head.n_rows, start) if start >= 0 else -1
    if stop < 0 or not _nothing_but_a_note(data, stop):
        return None
    if data[start:stop].translate(None, _PLAIN):
        return None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # numpy before 2 reads 1.0 as an integer, with a warning
            pieces = [np.loadtxt(io.BytesIO(piece), **_HOW) for piece in _pieces(data, start, stop)]
    except (ValueError, Warning):
        return None
    rows = np.concatenate(pieces) if pieces else np.zeros(0, _ROW)
    if rows.size != head.n_rows:
        return None
    return _table(rows, head)


def _pieces(data: bytes, start: int, stop: int) -> Iterator[bytes]:
    """Whole lines; between two pieces other threads come to work, such as one that shows how long it takes."""
    while start < stop:
        end = data.find(b"\n", min(start + _PIECE_BYTES, stop), stop) + 1 or stop
        yield data[start:end]
        start = end


def _table(rows: np.ndarray, head: SkyHead) -> tuple[np.ndarray, np.ndarray] | None:
    wave, zenith, azimuth, value = (rows[name] for name in ("wave", "zenith", "azimuth", "value"))
    inside = (
        wave.min() >= 1
        and wave.max() <= head.n_table
        and zenith.min() >= 1
        and zenith.max() <= head.n_zenith
        and azimuth.min() >= 0
        and azimuth.max() <= head.n_azimuth
    )
    if not inside or not np.all(np.isfinite(value)) or value.min() < 0:
        return None
    shape = (head.n_table, head.n_zenith, head.n_azimuth + 1)
    cell = ((wave - 1) * shape[1] + (zenith - 1)) * shape[2] + azimuth
    line = np.zeros(shape, dtype=np.int32)
    line.ravel()[cell] = np.arange(head.first_row + 1, head.first_row + 1 + rows.size, dtype=np.int32)
    radiance = np.zeros(shape)
    radiance.ravel()[cell] = value  # of a patch that stands more than once, the last line holds
    if not np.array_equal(radiance.ravel()[cell], value):  # its values differ: the slow reader says where
        return None
    return radiance, line


def _offset_after(data: bytes, n_lines: int) -> int:
    """Offset after the first `n_lines` lines, -1 if the data end before."""
    end = 0
    for _ in range(n_lines):
        end = data.find(b"\n", end) + 1
        if end == 0:
            return -1
    return end


def _end_of_rows(data: bytes, n_lines: int, start: int) -> int:
    """Offset after `n_lines` more line ends, -1 in doubt; the last line may lack its end."""
    n_after = data.count(b"\n", start) - n_lines
    if n_after < 0:
        return len(data) if n_after == -1 and not data.endswith(b"\n") else -1
    if n_after > MAX_LINES_AFTER:
        return -1
    end = len(data)
    for _ in range(n_after + 1):
        end = data.rfind(b"\n", start, end)
    return end + 1


def _nothing_but_a_note(data: bytes, stop: int) -> bool:
    """Whether nothing follows the data, or only a comment: otherwise rows have to be counted."""
    rest = data[stop : stop + 4096].lstrip()
    return not rest or rest.startswith(b"#")
