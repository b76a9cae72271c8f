"""Tables of all lobes for the emission: shapes, envelopes and bins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.kernels.arithmetic.constants import on_cache_lines
from aomc_sky.skies.lobes.kernels.law import LINE_MARGIN, OFFSET_BITS, RANGE_COLUMNS


@dataclass(frozen=True, kw_only=True, slots=True)
class LobeTables:
    """Shapes and envelopes of all lobes."""

    #: Number of each cell's lobe, int32 (n_cell,); -1 for other laws.
    lobe: np.ndarray
    #: The cell of each lobe, int64 (n_lobe,).
    cell: np.ndarray
    #: Those of `skies.lobes.kernels.law`, row by row; those of a band from `for_slots`. Lobes with equal
    #: envelopes share their bins.
    tables: tuple[np.ndarray, ...]

    @classmethod
    def of(cls, components: Sequence[Component]) -> LobeTables:
        """Build them from the components of a plan, in the order of their laws."""
        start = np.cumsum([0, *(component.n_cells for component in components)])
        law = np.array([component.law for component in components])
        numbers = np.flatnonzero((law >= Law.HG) & (law <= Law.BECKMANN))
        numbers = numbers[np.argsort(law[numbers], kind="stable")]
        lobe = np.full(start[-1], -1, np.int32)
        lobe[start[numbers]] = np.arange(numbers.size)
        kinds = np.searchsorted(law[numbers], [Law.GGX, Law.BECKMANN]).astype(np.int32)
        lobes = [components[k] for k in numbers.tolist()]
        shapes = np.concatenate([np.delete(c.shared, 7) for c in lobes if c.shared is not None])
        ranges, bins, envelopes = _envelopes([c.bounds for c in lobes if c.bounds is not None])
        return cls(lobe=lobe, cell=start[numbers], tables=(ranges, bins, shapes, envelopes, kinds))

    def for_slots(self, slots: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
        """The lobes of chosen cells, and the tables; `kinds` gets the first slot of a lobe and the end of the last."""
        lobe = self.lobe[slots]
        lobe_slots = np.flatnonzero(lobe >= 0)
        span = [lobe_slots[0], lobe_slots[-1] + 1] if lobe_slots.size else [0, 0]
        return lobe, (*self.tables[:4], np.append(self.tables[4], np.array(span, np.int32)))

    def bin_proposals(self, cumulative: np.ndarray, words: np.ndarray) -> tuple[np.ndarray, ...]:
        """`bin_proposals` and `bins_per_photon` of the kernels: how photons are shared out over the bins of each lobe.

        `cumulative` (n_cell + 1,) holds the photons before each cell, `words` uint64 (n_lobe,) the random ones of the
        offsets.
        """
        before, n = cumulative[self.cell].astype(np.uint64), np.diff(cumulative)[self.cell].astype(np.uint64)
        bits = self.tables[0].reshape(-1, RANGE_COLUMNS)[:, 1]
        size = np.uint64(1) << bits
        unit = bits + np.uint64(OFFSET_BITS)
        offset = words >> (np.uint64(64) - unit)
        proposals = np.stack([before, n // size, n % size, offset, bits], axis=1)
        bins_per_photon = np.divide(size.astype(np.float64), n, out=np.zeros(n.size), where=n > 0)
        left = ((np.uint64(1) << unit) - offset).astype(np.float64) / (np.uint64(1) << unit)
        lines = np.stack([bins_per_photon, left * bins_per_photon - LINE_MARGIN], axis=1)
        return proposals.ravel(), lines.ravel()


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
    return ranges.ravel(), np.concatenate(bins), on_cache_lines(np.concatenate(envelopes).ravel())
