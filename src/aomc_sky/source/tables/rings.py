"""The rings of a plan's cells, and the turn that each adds to the azimuthal places of its photons."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.kernels.arithmetic.constants import R2_STEP_V, RING_STEP

_UPPER_HALF = np.uint64(0xFFFFFFFF00000000)


@dataclass(frozen=True, kw_only=True, slots=True)
class Rings:
    """Which ring each cell lies in.

    A ring is a run of neighbouring cells of one component between the same two zenith angles, that is with the
    same first three parameters: a zenith row of a grid, however wide its columns are. A beam, a disc and a lobe are a
    ring each. Rings are numbered from 0 through all components, in the order of the cells.
    """

    #: Number of each cell's ring, int64 (n_cell,).
    of_cell: np.ndarray
    #: The first cell of each ring, int64 (n_ring,).
    first: np.ndarray

    @classmethod
    def of(cls, arrays: dict[str, np.ndarray]) -> Rings:
        """Find them in the arrays of a plan."""
        cell = arrays["cell"]
        starts = np.ones(cell.shape[0], dtype=bool)
        starts[1:] = np.any(cell[1:, :3] != cell[:-1, :3], axis=1)
        starts[arrays["component_start"][:-1]] = True
        return cls(of_cell=np.cumsum(starts) - 1, first=np.flatnonzero(starts))

    def turns(self, cumulative: np.ndarray) -> np.ndarray:
        """What each ring adds to shift + rank x step of v: 64-bit fractions that wrap, multiples of 2^-32; (n_ring,).

        The steps along a ring count from its first photon, and rings start a golden ratio apart: whatever number of
        photons a ring holds, photons above each other in neighbouring rings are never nearly in step.

        `cumulative`, int64 (n_cell + 1,), holds the band's photons before each cell.
        """
        number = np.arange(self.first.size, dtype=np.uint64)
        turns = number * RING_STEP - cumulative[self.first].astype(np.uint64) * R2_STEP_V
        return turns & _UPPER_HALF  # what stands beside float32 parameters has 32 bits
