"""The words of the random streams that one band needs before its first photon."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.kernels.arithmetic.constants import ACCEPT_STEP, R2_STEP_U, R2_STEP_V
from aomc_sky.sampling.streams import philox_pair
from aomc_sky.source.options import Order, Placement
from aomc_sky.source.plan.plan import Plan
from aomc_sky.source.tables.rings import Rings


@dataclass(frozen=True, kw_only=True, slots=True)
class StreamWords:
    """Keys, shifts and steps of a band, in the form the kernels read."""

    #: 32-bit round keys of the shuffled order, uint64 (3,); None leaves photons in the order of the cells.
    order_keys: np.ndarray | None
    #: Place in the cell as a 64-bit fraction: shift + rank x step, uint64 (2,) each. A step of 0 is the centre.
    shifts: np.ndarray
    steps: np.ndarray
    #: What each ring adds to the second place, uint64 (n_ring,); see `Rings.turns`.
    turns: np.ndarray
    #: Shift and step of the words that decide the first trial of a rejection; the key of what moves them for lobes.
    accept: np.ndarray
    place_key: np.uint64
    position_key: np.uint64
    #: The band's part of the Philox counters.
    band: np.uint64
    #: Whether places come from Philox instead.
    jitter: bool | None

    @classmethod
    def of(cls, plan: Plan, band: int, rings: Rings) -> StreamWords:
        """Derive the words of a band from the keys and the counts of the plan."""
        order_key, shift_key, place_key, position_key = (np.uint64(k) for k in plan.arrays["keys"])
        by_rank = plan.options["placement"] == Placement.R2.value
        shuffled = plan.options["order"] == Order.SHUFFLED.value
        half = np.full(2, 1 << 63, dtype=np.uint64)
        return cls(
            order_keys=_order_keys(order_key, band) if shuffled else None,
            shifts=_band_words(shift_key, band) if by_rank else half,
            steps=np.array([R2_STEP_U, R2_STEP_V] if by_rank else [0, 0], dtype=np.uint64),
            turns=rings.turns(plan.arrays["cumulative"][band]) if by_rank else np.zeros(rings.first.size, np.uint64),
            accept=np.insert(_band_words(shift_key, band, 1), 1, ACCEPT_STEP),
            place_key=place_key,
            position_key=position_key,
            band=np.uint64(band),
            jitter=True if plan.options["placement"] == Placement.PHILOX.value else None,
        )

    def arguments(self) -> tuple[object, ...]:
        """The first arguments of the emission after the range, in their order."""
        return self.order_keys, self.shifts, self.steps, self.place_key, self.band, self.jitter


def lobe_offset_words(plan: Plan, band: int, cells: np.ndarray) -> np.ndarray:
    """A 64-bit word for each lobe of a band, addressed by its cell: Philox counter (cell, 0, band, 2)."""
    key = int(plan.arrays["keys"][1])
    return np.array([philox_pair(key, cell, band, 2)[0] for cell in cells.tolist()], dtype=np.uint64)


def _band_words(key: np.uint64, band: int, draw: int = 0) -> np.ndarray:
    """Two 64-bit words of a band from a stream: Philox counter (0, 0, band, draw)."""
    return np.array(philox_pair(int(key), 0, band, draw), dtype=np.uint64)


def _order_keys(key: np.uint64, band: int) -> np.ndarray:
    """Three 32-bit round keys of a band's order."""
    first, second = (int(w) for w in _band_words(key, band))
    return np.array([first & 0xFFFFFFFF, first >> 32, second & 0xFFFFFFFF], dtype=np.uint64)
