"""The plan of a run, which every shard, export and check reads and never recomputes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.component import Component
from aomc_sky.errors import InputFileError, OutputError
from aomc_sky.float_mode import in_default_mode
from aomc_sky.plan.check import check_plan
from aomc_sky.plan.counts import PlanBand
from aomc_sky.plan.file import as_members, from_members, npz_bytes, read_npz, sha256_of

OTHER_PROCESSOR = 1e-12
"""Largest relative difference of numbers that another processor computes; whole numbers must be equal."""


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class Plan:
    """The settled part of a run; photons are a pure function of it.

    Parameters
    ----------
    bands : tuple of PlanBand
        One record for each waveband: `wavelength_nm`, `sky_wavelength_nm`, `requested` photons, the `row` of the
        components' masses, and where absolute units are known `irradiance_W_m2_nm` of each component and
        `horizon_loss`, which change no photon.
    components : tuple of Component
        Laws, cells, patches and masses in the order of the cells. Masses, weights and slopes have one row for each
        distinct sky; the masses of all components share the sum 1 of a row.
    cumulative : ndarray, int64, shape (n_replicate x n_band, n_cell + 1)
        Photons before each cell, one replicate band after the other.
    options : dict
        Everything else that changes photons, and names: JSON values only.

    Raises
    ------
    InputFileError
        E953 to E955: no photons can be made from such a plan. The member of plan.npz is named.

    Notes
    -----
    A replicate band is one replicate of one band; its number, replicate x n_bands + band, stands in every
    random counter where the band stands in a run without replicates, so that all are independent.
    `aomc_sky.plan.check` bounds all numbers by which kernels read, so that a plan that exists can be emitted from.

    Examples
    --------
    >>> source = sky.Scene(wavebands=[550.0], n_photons=1000, components="uniform").source(
    ...     seed=1
    ... )
    >>> source.plan.save("plan.npz")
    >>> again = sky.PhotonSource(sky.Plan.load("plan.npz"))
    >>> np.array_equal(again.photons().ux, source.photons().ux)
    True
    """

    bands: tuple[PlanBand, ...]
    components: tuple[Component, ...]
    cumulative: np.ndarray
    options: dict[str, Any]

    def __post_init__(self) -> None:
        check_plan(self.bands, self.components, self.cumulative, self.options)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Plan) and self.sha256 == other.sha256

    def __repr__(self) -> str:
        total = int(self.cumulative[:, -1].astype(object).sum())
        bands = f"{self.n_bands} waveband{'s' * (self.n_bands != 1)}"
        return f"<Plan {self.sha256[:16]}: {total} photons in {bands}, {self.n_cells} cells, seed {self.seed}>"

    def agrees(self, other: Plan) -> bool:
        """Whether it is the same run made on another processor: whole numbers are equal, others within 1e-12."""
        one, two = self.members(), other.members()
        if self.options != other.options or one.keys() != two.keys():
            return False
        pairs = [(array, two[name]) for name, array in one.items()]
        return all(a.shape == b.shape and a.dtype == b.dtype and not differing(a, b).any() for a, b in pairs)

    @property
    def seed(self) -> int:
        """Seed of the run."""
        return int(self.options["seed"])

    @property
    def n_bands(self) -> int:
        """Number of wavebands."""
        return len(self.bands)

    @property
    def wavelength_nm(self) -> np.ndarray:
        """Wavelength of each waveband, float64 (n_band,). [nm]"""
        return np.array([band.wavelength_nm for band in self.bands])

    @property
    def replicates(self) -> int:
        """Independent randomisations that share the photons of each band."""
        return int(self.cumulative.shape[0]) // self.n_bands

    @property
    def n_cells(self) -> int:
        """Number of cells of all components."""
        return int(self.cumulative.shape[1]) - 1

    @property
    def law(self) -> np.ndarray:
        """Number of each cell's law, int8 (n_cell,)."""
        laws = np.array([component.law for component in self.components], np.int8)
        return np.repeat(laws, [component.n_cells for component in self.components])

    @property
    def component_start(self) -> np.ndarray:
        """First cell of each component, and their number last; int64 (n_component + 1,)."""
        return np.cumsum([0, *(component.n_cells for component in self.components)], dtype=np.int64)

    @property
    def component_names(self) -> tuple[str, ...]:
        """Names of the components in the order of their cells."""
        return tuple(component.name for component in self.components)

    def mass(self, band: int) -> np.ndarray:
        """Probability of each cell in a band, float64 (n_cell,), sum 1; 0 without light."""
        parts = [component.mass[self.bands[band].row] for component in self.components]
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def stokes(self, band: int) -> np.ndarray | None:
        """Q/I and U/I of each cell in a band, float64 (n_cell, 2), 0 for unpolarised ones; None where all are."""
        if all(component.stokes is None for component in self.components):
            return None
        rows = [component.of_row(self.bands[band].row) for component in self.components]
        return np.concatenate([np.zeros((row.n_cells, 2)) if row.stokes is None else row.stokes[0] for row in rows])

    def members(self) -> dict[str, np.ndarray]:
        """The arrays of plan.npz by their names there."""
        return as_members(self.bands, self.components, self.cumulative, self.options)

    @property
    def sha256(self) -> str:
        """Name of the run: SHA-256 over sorted name, dtype, shape, little-endian bytes, and options."""
        return sha256_of(self.members(), self.options)

    def to_bytes(self) -> bytes:
        """The plan as the bytes of an npz file; equal plans give equal bytes."""
        return npz_bytes(self.members(), self.options)

    def save(self, path: str | Path) -> None:
        """Write the plan; `aomc_sky.outputs` does it atomically."""
        try:
            Path(path).write_bytes(self.to_bytes())
        except OSError as error:
            raise OutputError(f"cannot write {path}: {error.strerror or error}") from error

    @classmethod
    @in_default_mode
    def load(cls, path: str | Path) -> Plan:
        """Read a plan that `save` wrote; InputFileError (E951 to E955) if it is missing, damaged, or not a plan."""
        members, options = read_npz(path)
        try:
            bands, components, cumulative = from_members(members, options)
            return cls(bands=bands, components=components, cumulative=cumulative, options=options)
        except InputFileError as error:
            raise InputFileError([replace(problem, path=str(path)) for problem in error.problems]) from None


def differing(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Mask of the numbers of two arrays of one shape that are not those of one run; see `OTHER_PROCESSOR`."""
    if one.dtype.kind != "f":
        return np.asarray(one != other)
    return ~np.isclose(one, other, rtol=OTHER_PROCESSOR, atol=OTHER_PROCESSOR, equal_nan=True)
