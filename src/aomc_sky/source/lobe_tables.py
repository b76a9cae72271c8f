"""The lobes of a plan in the form the emission reads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.component import Law
from aomc_sky.kernels.plain_lobe import RANGE_COLUMNS

Tables = tuple[np.ndarray, ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class LobeTables:
    """Shapes and envelopes of all lobes.

    Parameters
    ----------
    lobe : ndarray, int32, shape (n_cell,)
        Number of each cell's lobe; -1 for other laws.
    tables : tuple of ndarray
        Those of `kernels.plain_lobe`, row by row; those of a band from `of_slots`. Lobes with equal envelopes share
        their bins.
    """

    lobe: np.ndarray
    tables: Tables

    @classmethod
    def of(cls, arrays: dict[str, np.ndarray]) -> LobeTables | None:
        """Build them from the arrays of a plan; None without a lobe."""
        start = arrays["component_start"][:-1]
        law = arrays["law"][start]
        numbers = np.flatnonzero(law >= Law.HG)
        if not numbers.size:
            return None
        numbers = numbers[np.argsort(law[numbers], kind="stable")]
        lobe = np.full(arrays["law"].size, -1, np.int32)
        lobe[start[numbers]] = np.arange(numbers.size)
        kinds = np.searchsorted(law[numbers], [Law.GGX, Law.BECKMANN]).astype(np.int32)
        shapes = np.concatenate([np.delete(arrays[f"shared_{k}"], 7) for k in numbers])
        ranges, bins, envelopes = _envelopes([arrays[f"bounds_{k}"] for k in numbers])
        return cls(lobe=lobe, tables=(ranges, bins, shapes, envelopes, kinds))

    def of_slots(self, slots: np.ndarray) -> tuple[np.ndarray, Tables]:
        """The lobes of chosen cells, and the tables; `kinds` gets the first slot of a lobe and the end of the last."""
        lobe = self.lobe[slots]
        of_lobes = np.flatnonzero(lobe >= 0)
        span = [of_lobes[0], of_lobes[-1] + 1] if of_lobes.size else [0, 0]
        return lobe, (*self.tables[:4], np.append(self.tables[4], np.array(span, np.int32)))


def _envelopes(cells_of_lobe: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ranges of each lobe, bins and cells of all envelopes."""
    known: dict[bytes, list[int]] = {}
    bins: list[np.ndarray] = []
    envelopes: list[np.ndarray] = []
    ranges = np.zeros((len(cells_of_lobe), RANGE_COLUMNS), np.uint64)
    for row, cells in zip(ranges, cells_of_lobe, strict=True):
        key = cells.tobytes()
        if key not in known:
            count = cells[:, 3].astype(np.int64)
            which = np.repeat(np.arange(count.size), count)
            part = np.arange(which.size) - np.repeat(np.cumsum(count) - count, count)
            known[key] = [sum(map(len, bins)), which.size.bit_length() - 1, sum(map(len, envelopes)), 0]
            bins.append((which << 16 | part).astype(np.uint32))
            envelopes.append(cells)
        row[:] = known[key]
    return ranges.ravel(), np.concatenate(bins), _on_cache_lines(np.concatenate(envelopes).ravel())


def _on_cache_lines(values: np.ndarray) -> np.ndarray:
    """A copy that begins on a cache line, so that a row of 64 bytes lies on one."""
    memory = np.empty(values.nbytes + 64, np.uint8)
    begin = -memory.ctypes.data % 64
    copy = memory[begin : begin + values.nbytes].view(values.dtype)
    copy[:] = values
    return copy
