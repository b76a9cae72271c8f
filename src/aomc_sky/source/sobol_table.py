"""What the Sobol emission reads of one lane: who gets how many photons, scrambling keys, cumulative masses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.component import Law
from aomc_sky.kernels.plain_sobol import N_GROUPS, TABLE_GROUPS, top_table
from aomc_sky.sampling.fixed_point import FIXED_POINT_BITS
from aomc_sky.sampling.streams import philox_pair
from aomc_sky.source.band_table import BandTable, CellWords, PerezBounds
from aomc_sky.source.lobe_tables import LobeTables

_SENTINELS = np.full(2, 2**64 - 1, np.uint64)
_MAX_GUIDE_BITS = 17


def _cumulated(mass: np.ndarray) -> np.ndarray:
    """Masses uint64 (n,) that sum to 2^62 as uint64 (n + 1,), 0 to 2^62."""
    return np.concatenate([np.zeros(1, np.uint64), np.cumsum(mass, dtype=np.uint64)])


def _guide(ends: np.ndarray) -> tuple[np.ndarray, int]:
    """For each multiple of 2^shift below 2^62 the step of `ends` that it lies in, and the shift."""
    bits = min(max((8 * ends.size).bit_length(), 4), _MAX_GUIDE_BITS)
    shift = FIXED_POINT_BITS - bits
    first = np.arange(1 << bits, dtype=np.uint64) << np.uint64(shift)
    return np.searchsorted(ends[1:-1], first, side="right"), shift


@dataclass(frozen=True, kw_only=True, slots=True)
class SobolComponent:
    """One component with photons.

    Parameters
    ----------
    first_slot : int
        Its first cell among the slots of the lane.
    rings, cells : ndarray, uint64
        Cumulative masses, 0 to 2^62.
    keys : ndarray, uint32, shape (2, 8, 2)
        Scrambling keys.
    n_groups : int
        Groups of four levels that are scrambled; 0 for a beam, which needs no point. [0, 3 to 8]
    """

    first_slot: int
    rings: np.ndarray
    cells: np.ndarray
    keys: np.ndarray
    n_groups: int


@dataclass(frozen=True, kw_only=True, slots=True)
class SobolLane:
    """The Sobol sequences of one lane, one for each component.

    Parameters
    ----------
    lane : int
        Its number, the address of its random numbers.
    place_key : numpy.uint64
        Key of the numbers below the scrambled levels and of rejections.
    tree : ndarray, uint64
        Photons of the nodes above the components; see `kernels.plain_sobol.component_points`.
    components : tuple of SobolComponent or None
        None for a component without photons.
    """

    lane: int
    place_key: np.uint64
    tree: np.ndarray
    components: tuple[SobolComponent | None, ...]

    @classmethod
    def of(cls, arrays: dict[str, np.ndarray], lane: int, photons: np.ndarray, slots: np.ndarray) -> SobolLane:
        """Build the tables of a lane.

        Parameters
        ----------
        arrays : dict of ndarray
            Of the plan.
        lane : int
            Replicate x n_bands + band.
        photons : ndarray, int64, shape (n_component,)
            Photons of each component.
        slots : ndarray, int, shape (n_slot,)
            Cells that take part, in order; all that have a mass are among them.
        """
        mass, start = lane_mass(arrays, lane), arrays["component_start"]
        scramble_key, place_key = arrays["sobol_keys"]
        parts: list[SobolComponent | None] = []
        for k, n in enumerate(photons.tolist()):
            first, last = np.searchsorted(slots, start[k : k + 2]).tolist()
            if n == 0:
                parts.append(None)
                continue
            columns = _columns(arrays, k)
            own = slots[first:last]
            is_beam = own.size == 1 and arrays["law"][own[0]] == Law.BEAM
            of_ring = np.flatnonzero(np.diff((own - start[k]) // columns, prepend=-1))
            parts.append(
                SobolComponent(
                    first_slot=first,
                    rings=_cumulated(np.add.reduceat(mass[own], of_ring)),
                    cells=_cumulated(mass[own]),
                    keys=_node_keys(int(scramble_key), k, lane),
                    n_groups=0 if is_beam else max(TABLE_GROUPS, -(-(n - 1).bit_length() // 4)),
                )
            )
        return cls(lane=lane, place_key=np.uint64(place_key), tree=_tree(photons), components=tuple(parts))

    def plain_address(self) -> tuple[Any, ...]:
        """What `kernels.plain_sobol.find_cells` reads after the photons."""
        keys = [None if c is None else c.keys for c in self.components]
        groups = [0 if c is None else c.n_groups for c in self.components]
        tables = [None if c is None else (c.first_slot, c.rings, c.cells) for c in self.components]
        return self.lane, self.place_key, self.tree, keys, groups, tables

    def kernel_address(self) -> tuple[Any, ...]:
        """What the kernels of `emit_sobol` read after the photons: flat arrays and numbers."""
        n_leaf = self.tree.size // 2
        tops = np.zeros((n_leaf, 2, 4096), np.uint16)
        keys = np.zeros((n_leaf, 2, N_GROUPS, 2), np.uint32)
        for k, c in enumerate(self.components):
            if c is not None:
                tops[k], keys[k] = top_table(c.keys), c.keys
        return np.uint64(self.lane), self.place_key, self.tree, tops.ravel(), keys.ravel(), self._tables(n_leaf)

    def _tables(self, n_leaf: int) -> tuple[np.ndarray, ...]:
        """Bounds of each component's parts, then rings, their guides, cells, and theirs; see `emit_sobol`."""
        at = np.zeros((n_leaf, 12), np.uint64)
        parts: list[list[np.ndarray]] = [[], [], [], []]
        for k, c in enumerate(self.components):
            if c is None:
                continue
            for ends, part, first in ((c.rings, 0, 0), (c.cells, 2, 5)):
                guide, shift = _guide(ends)
                for i, values in enumerate((np.concatenate([ends, _SENTINELS]), guide)):
                    before = sum(map(len, parts[part + i]))
                    at[k, first + 2 * i : first + 2 * i + 2] = before, before + values.size
                    parts[part + i].append(values)
                at[k, first + 4] = shift
            at[k, 10:] = c.first_slot, c.n_groups
        rings, ring_guide, cells, guide = (np.concatenate(p) for p in parts)
        kind = np.uint16 if max(int(ring_guide.max()), int(guide.max())) < 2**16 else np.uint32
        return at.ravel(), rings, ring_guide.astype(kind), cells, guide.astype(kind)


def _columns(arrays: dict[str, np.ndarray], component: int) -> int:
    """Cells of a ring; those of a component without patches are one ring."""
    bounds = arrays.get(f"azimuth_bounds_deg_{component}")
    start = arrays["component_start"]
    return int(start[component + 1] - start[component]) if bounds is None else bounds.shape[0]


def _tree(photons: np.ndarray) -> np.ndarray:
    """Photons of the nodes of a binary tree whose leaves are the components, in heap order from node 1."""
    n_leaf = 1 << (photons.size - 1).bit_length()
    tree = np.zeros(2 * n_leaf, np.uint64)
    tree[n_leaf : n_leaf + photons.size] = photons
    for node in range(n_leaf - 1, 0, -1):
        tree[node] = tree[2 * node] + tree[2 * node + 1]
    return tree


def _node_keys(key: int, component: int, lane: int) -> np.ndarray:
    """Keys of a component's scrambling, uint32 (2, 8, 2): for each coordinate and group of four levels."""
    words = [philox_pair(key, component * 2 * N_GROUPS + i, lane, 0) for i in range(2 * N_GROUPS)]
    return np.array([(a >> 32, b >> 32) for a, b in words], dtype=np.uint32).reshape(2, N_GROUPS, 2)


def lane_photons(arrays: dict[str, np.ndarray], lane: int) -> np.ndarray:
    """Photons of each component in a lane, int64 (n_component,)."""
    return np.diff(arrays["cumulative"][lane, arrays["component_start"]])


def lane_mass(arrays: dict[str, np.ndarray], lane: int) -> np.ndarray:
    """Masses of the cells of a lane, each component on its own, in units of 2^-62."""
    return np.asarray(arrays["sobol_mass"][arrays["row_of_band"][lane % arrays["wavelength_nm"].size]])


def plain_lane(arrays: dict[str, np.ndarray], lane: int) -> tuple[tuple[Any, ...], np.ndarray]:
    """What `kernels.plain_sobol` reads of a lane: an address, and the cells of its slots."""
    slots = np.flatnonzero(lane_mass(arrays, lane))
    return SobolLane.of(arrays, lane, lane_photons(arrays, lane), slots).plain_address(), slots


@dataclass(frozen=True, kw_only=True, slots=True)
class SobolTable:
    """What `kernels.emit_sobol` reads of a lane with photons: sequences, and laws and parameters of its slots."""

    lane: SobolLane
    band: BandTable

    @classmethod
    def of(
        cls,
        arrays: dict[str, np.ndarray],
        lane: int,
        cells: CellWords,
        luminance: PerezBounds | None,
        lobes: LobeTables | None,
    ) -> SobolTable:
        """Build the tables. A slot is a cell with a mass, whether a photon hits it or not."""
        counts = np.diff(arrays["cumulative"][lane])
        held = np.maximum(counts, lane_mass(arrays, lane) > 0)
        band = BandTable.of(np.append(0, np.cumsum(held)), arrays["law"], cells, luminance, lobes)
        slots = np.arange(counts.size) if band.cell_of_slot is None else band.cell_of_slot
        return cls(lane=SobolLane.of(arrays, lane, lane_photons(arrays, lane), slots), band=band)

    def laws(self, words: np.ndarray) -> tuple[object, ...]:
        """The arguments of the kernel from `place` on, before the outputs."""
        table = self.band
        laws = (table.law, table.main_in_mu, table.main_is_mixed, table.is_narrow)
        return table.place, words, *laws, table.perez, table.lobes, table.cell_of_slot
