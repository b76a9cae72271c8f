"""The lobes of a plan in the form the emission reads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.component import N_LOBE_SHARED, Law
from aomc_sky.kernels.plain_lobe import BIN_COLUMNS, IS_BECKMANN, IS_HG, LOBE_COLUMNS

Tables = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True, kw_only=True, slots=True)
class LobeTables:
    """Shapes and envelopes of all lobes.

    Parameters
    ----------
    lobe : ndarray, int32, shape (n_cell,)
        Number of each cell's lobe; -1 for other laws.
    ranges : ndarray, uint64
        First bin and binary logarithm of the number of bins, for each lobe.
    shapes, bins : ndarray, float64
        Tables of `kernels.plain_lobe`, row by row. Lobes with equal envelopes share their bins.
    """

    lobe: np.ndarray
    ranges: np.ndarray
    shapes: np.ndarray
    bins: np.ndarray

    @classmethod
    def of(cls, arrays: dict[str, np.ndarray]) -> LobeTables | None:
        """Build them from the arrays of a plan; None without a lobe."""
        start = arrays["component_start"]
        law = [Law(int(code)) for code in arrays["law"][start[:-1]]]
        numbers = [k for k, code in enumerate(law) if code.is_lobe]
        if not numbers:
            return None
        lobe = np.full(arrays["law"].size, -1, np.int32)
        lobe[start[numbers]] = np.arange(len(numbers))
        shapes = np.zeros((len(numbers), LOBE_COLUMNS))
        ranges, parts, known, first = [], [], {}, 0
        for row, k in zip(shapes, numbers, strict=True):
            row[:N_LOBE_SHARED] = arrays[f"shared_{k}"]
            row[IS_HG], row[IS_BECKMANN] = law[k] is Law.HG, law[k] is Law.BECKMANN
            bins = arrays[f"bounds_{k}"]
            key = bins.tobytes()
            if key not in known:
                known[key] = first
                parts.append(bins)
                first += bins.shape[0]
            ranges.append((known[key], bins.shape[0].bit_length() - 1))
        bins = np.concatenate(parts)
        assert bins.shape[1] == BIN_COLUMNS
        return cls(lobe=lobe, ranges=np.array(ranges, np.uint64).ravel(), shapes=shapes.ravel(), bins=bins.ravel())

    @property
    def tables(self) -> Tables:
        """What the kernels call tables."""
        return self.ranges, self.shapes, self.bins

    def of_slots(self, slots: np.ndarray) -> tuple[np.ndarray, Tables]:
        """The lobes of chosen cells, and the tables."""
        return self.lobe[slots], self.tables
