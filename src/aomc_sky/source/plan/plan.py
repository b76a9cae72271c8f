"""What every shard, export and check reads and never recomputes: counts, cells, keys, options."""

from __future__ import annotations

import hashlib
import io
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.errors import OutputError
from aomc_sky.float_mode import in_default_mode
from aomc_sky.grid import PatchGrid
from aomc_sky.sampling.streams import STREAM_VERSION
from aomc_sky.source.plan.file import read_plan_file
from aomc_sky.source.plan.schema import check_plan


@dataclass(frozen=True, kw_only=True, slots=True)
class Plan:
    """The settled part of a run; photons are a pure function of it.

    Parameters
    ----------
    arrays : dict of ndarray
        `wavelength_nm`, `sky_wavelength_nm`, `requested` (n_band,); `cumulative` int64
        (n_replicate x n_band, n_cell + 1), photons before each cell, one replicate band after the other; `row_of_band`
        (n_band,); `mass` float64 (n_row, n_cell), sums to 1; `weight` (n_row, n_cell) or (0, 0);
        `law` int8 and `cell` float64 (n_cell, 6); `component_start` (n_component + 1,);
        `keys` uint64, one per stream; and for each component k with patches `zenith_bounds_deg_k`,
        `azimuth_bounds_deg_k`, for one of law PEREZ also `shared_k` (11,) and `bounds_k` (cells of the
        component, 2). Where absolute units are known there are `irradiance_W_m2_nm` float64
        (n_band, n_component) and `horizon_loss` float64 (n_band,), which change no photon.
    options : dict
        Everything else that changes photons, and names: JSON values only.

    Notes
    -----
    A replicate band is one replicate of one band; its number, replicate x n_bands + band, stands in every
    random counter where the band stands in a run without replicates, so that all are independent.
    `aomc_sky.source.plan.schema` has every rule that a plan keeps; whoever emits photons asks for `check` first.
    """

    arrays: dict[str, np.ndarray]
    options: dict[str, Any]
    _checked: tuple[dict[str, np.ndarray], str] | None = field(default=None, init=False, repr=False, compare=False)

    def check(self, path: str | Path = "plan") -> None:
        """Raise unless the plan keeps the schema; of equal read-only arrays and options only the first time.

        Parameters
        ----------
        path : str or Path
            What the message calls the plan.

        Raises
        ------
        InputFileError
            E952 to E955, naming the member, what was found and what is allowed.
        """
        if self._checked is not None:
            arrays, options = self._checked
            same = arrays.keys() == self.arrays.keys() and all(a is self.arrays[n] for n, a in arrays.items())
            if same and options == repr(self.options):
                return
        check_plan(self.arrays, self.options, str(path))
        if not any(array.flags.writeable for array in self.arrays.values()):
            object.__setattr__(self, "_checked", (dict(self.arrays), repr(self.options)))

    @property
    def seed(self) -> int:
        """Seed of the run."""
        return int(self.options["seed"])

    @property
    def n_bands(self) -> int:
        """Number of wavebands."""
        return int(self.arrays["wavelength_nm"].size)

    @property
    def replicates(self) -> int:
        """Independent randomisations that share the photons of each band."""
        return int(self.arrays["cumulative"].shape[0]) // self.n_bands

    @property
    def n_cells(self) -> int:
        """Number of cells of all components."""
        return int(self.arrays["cell"].shape[0])

    @property
    def component_names(self) -> tuple[str, ...]:
        """Names of the components in the order of their cells."""
        return tuple(self.options["components"])

    def grid_of(self, component: int) -> PatchGrid | None:
        """Patches of a component, None for a beam or a disc."""
        if f"zenith_bounds_deg_{component}" not in self.arrays:
            return None
        return PatchGrid(
            zenith_bounds_deg=self.arrays[f"zenith_bounds_deg_{component}"],
            azimuth_bounds_deg=self.arrays[f"azimuth_bounds_deg_{component}"],
            azimuth_first_index=int(self.options["azimuth_first_index"][component]),
        )

    @property
    def sha256(self) -> str:
        """Name of the run: SHA-256 over sorted name, dtype, shape, little-endian bytes, and options."""
        digest = hashlib.sha256()
        digest.update(STREAM_VERSION.encode() + b"\0")
        for name in sorted(self.arrays):
            array = self.arrays[name]
            little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
            head = f"{name}\0{little.dtype.str}\0{','.join(map(str, little.shape))}\0"
            digest.update(head.encode())
            digest.update(little.data if little.size else b"")
        digest.update(json.dumps(self.options, sort_keys=True, separators=(",", ":")).encode())
        return digest.hexdigest()

    def to_bytes(self) -> bytes:
        """The plan as the bytes of an npz file; equal plans give equal bytes."""
        buffer = io.BytesIO()
        text = json.dumps(self.options, sort_keys=True, separators=(",", ":"))
        arrays: dict[str, Any] = dict(sorted(self.arrays.items()))
        np.savez(buffer, options=np.frombuffer(text.encode(), dtype=np.uint8), **arrays)
        return buffer.getvalue()

    def save(self, path: str | Path) -> None:
        """Write the plan; `aomc_sky.outputs` does it atomically."""
        try:
            Path(path).write_bytes(self.to_bytes())
        except OSError as error:
            raise OutputError(f"cannot write {path}: {error.strerror or error}") from error

    @classmethod
    @in_default_mode
    def load(cls, path: str | Path) -> Plan:
        """Read a plan that `save` wrote.

        Raises
        ------
        InputFileError
            E951 to E955: the file is missing, damaged, or not a plan.
        OutputError
            The operating system refuses.
        """
        arrays, options = read_plan_file(path)
        plan = cls(arrays=arrays, options=options)
        plan.check(path)
        return plan
