"""The laws HG, GGX and BECKMANN: one lobe times the cosine, as `CellLaw` asks for it, and the tables of all lobes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from aomc_sky.component import CellLaw, Component, Law
from aomc_sky.errors import SceneError
from aomc_sky.kernels.arithmetic.constants import on_cache_lines
from aomc_sky.skies.lobes.envelope import LAWS
from aomc_sky.skies.lobes.horizon import masses_of_lobe
from aomc_sky.skies.lobes.kernels.law import LINE_MARGIN, OFFSET_BITS, RANGE_COLUMNS
from aomc_sky.skies.lobes.lobe import axis_deg
from aomc_sky.skies.lobes.patches import TiltedLobe, patch_shares

_N_SHARED = 10
_N_ENVELOPE = 8
_ROUNDING = 1e-9
_MAX_BINS = 2**16  # the number of a bin in its cell, and of a cell in its lobe, share one word of 32 bits


def _axis_deg(component: Component) -> tuple[float, float, float]:
    """Direction of the axis, and twice the angle that holds half of a lobe, of the narrower way where it has two."""
    lobe = TiltedLobe.of(component)
    if lobe.kind == "hg":
        half = 2.0 * math.asin((1.0 - lobe.param0) * math.sqrt(2.0 + lobe.param0) / 2.0)
    else:
        half = math.atan(min(lobe.stretch) * (1.0 if lobe.kind == "ggx" else math.sqrt(math.log(2.0))))
    return *axis_deg(lobe.rotation), 2.0 * math.degrees(half)


def _radiance(component: Component) -> Callable[[float, np.ndarray, np.ndarray], np.ndarray]:
    lobe = TiltedLobe.of(component)
    projected = masses_of_lobe(lobe.kind, lobe.param0, lobe.param1, lobe.rotation[2])[1]
    return partial(_radiance_at, lobe, 1.0 / projected)


def _radiance_at(
    lobe: TiltedLobe, per_irradiance: float, irradiance: float, zenith: np.ndarray, azimuth: np.ndarray
) -> np.ndarray:
    sine, (along_x, along_y, axis) = np.sin(zenith), lobe.rotation.T.tolist()
    x, y, z = sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(zenith)
    h = ((x - axis[0]) ** 2 + (y - axis[1]) ** 2 + (z - axis[2]) ** 2) / 4.0
    m_x, m_y = (x * a + y * b + z * c for a, b, c in (along_x, along_y))
    return lobe.density(lobe.kind, h, m_x, m_y) * (irradiance * per_irradiance)


def _refused(cell: np.ndarray, bounds: np.ndarray | None) -> tuple[str, str, str] | None:
    if bounds is None:
        return "bounds", "", "an envelope"
    if len(cell) != 1:
        return "component_start", f"{len(cell)} cells", "one for a lobe"
    b, width, a, count, half, *turn, bound = bounds.T
    total = int(min(count.sum(), 2.0 * _MAX_BINS)) if count.min() >= 1 and np.all(count == np.rint(count)) else 0
    if not (2 <= total <= _MAX_BINS and total.bit_count() == 1):
        return "bounds", "", f"a power of two of whole bins, 2 to {_MAX_BINS}"
    least = np.minimum.reduce([b, width, a, half, 0.5 - half, *(1.0 - np.abs(turn))]).min()
    is_inside = least >= 0.0 and np.all(np.abs(a + b + width * count - 1.0) <= _ROUNDING) and np.all(bound > 0.0)
    return None if is_inside else ("bounds", "", "cells inside the plane of the envelope, and bounds above 0")


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
        """Build them from the components of a plan, in the order of their laws; SceneError for what no plan has."""
        start = np.cumsum([0, *(component.n_cells for component in components)])
        law = np.array([component.law for component in components])
        numbers = np.flatnonzero(np.isin(law, list(LAWS.values())))
        numbers = numbers[np.argsort(law[numbers], kind="stable")]
        lobe = np.full(start[-1], -1, np.int32)
        lobe[start[numbers]] = np.arange(numbers.size)
        kinds = np.searchsorted(law[numbers], [Law.GGX, Law.BECKMANN]).astype(np.int32)
        lobes = [components[k] for k in numbers.tolist()]
        for one in lobes:
            if fault := _refused(one.cell, one.bounds):
                raise SceneError(f"lobe {one.name!r}: expected {fault[2]}")
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


LOBE = CellLaw(
    moments=lambda component: (component.cell[:, 0], component.cell[:, 2]),
    reaches_horizon=lambda cell: np.ones(len(cell), dtype=bool),
    shares=patch_shares,
    radiance=_radiance,
    width_rad=lambda component: TiltedLobe.of(component).width,
    axis_deg=_axis_deg,
    leave_out="leave [[background]] out of sky.toml: the AOMC program knows no lobes",
    tables=lambda _, n_bound: ((_N_SHARED,), (n_bound, _N_ENVELOPE)),
    refused=_refused,
    hook="lobes",
    hook_tables=LobeTables.of,
)
