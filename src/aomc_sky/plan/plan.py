"""The plan of a run, which every shard, export and check reads and never recomputes; and its file plan.npz.

The file holds its own hash: a changed or damaged file is refused first. No member is ever unpickled, and none is longer
than the file, so reading takes no more memory than the length of the file.
"""

from __future__ import annotations

import hashlib
import io
import json
import math
import os
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.content import same_content
from aomc_sky.errors import InputFileError, OutputError
from aomc_sky.float_mode import in_default_mode
from aomc_sky.formats.text_file import refuse
from aomc_sky.grid import PatchGrid
from aomc_sky.plan.check import check_plan, check_stream
from aomc_sky.plan.sampling.streams import STREAM_VERSION
from aomc_sky.system import FileKindError, open_regular

MAX_PLAN_BYTES = 2**34
"""Largest plan that is read. [bytes]"""

_OPTIONS, _SHA256 = "options", "sha256"
_MAX_HEADER = 1000


OTHER_PROCESSOR = 1e-12
"""Largest relative difference of numbers that another processor computes; whole numbers must be equal."""


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
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
        component, 2), for one of law CELL_SLOPED `slope_k` (1 or n_row, cells of the component, 2). Where absolute
        units are known there are `irradiance_W_m2_nm` float64 (n_band, n_component) and `horizon_loss` float64
        (n_band,), which change no photon.
    options : dict
        Everything else that changes photons, and names: JSON values only.

    Notes
    -----
    A replicate band is one replicate of one band; its number, replicate x n_bands + band, stands in every
    random counter where the band stands in a run without replicates, so that all are independent.
    `aomc_sky.plan.check` bounds all numbers by which kernels read; whoever emits photons asks for `check` first.

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

    arrays: dict[str, np.ndarray]
    options: dict[str, Any]

    __eq__ = same_content

    def __repr__(self) -> str:
        total = int(self.arrays["cumulative"][:, -1].astype(object).sum())
        bands = f"{self.n_bands} waveband{'s' * (self.n_bands != 1)}"
        return f"<Plan {self.sha256[:16]}: {total} photons in {bands}, {self.n_cells} cells, seed {self.seed}>"

    def agrees(self, other: Plan) -> bool:
        """Whether it is the same run made on another processor: whole numbers are equal, others within 1e-12."""
        return (
            self.options == other.options
            and self.arrays.keys() == other.arrays.keys()
            and all(_agree(array, other.arrays[name]) for name, array in self.arrays.items())
        )

    def check(self, path: str | Path = "plan") -> None:
        """Raise unless photons can be made: InputFileError E952 to E955, which calls the plan `path`."""
        check_plan(self.arrays, self.options, str(path))

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
        members: dict[str, Any] = {
            _OPTIONS: np.frombuffer(text.encode(), dtype=np.uint8),
            **dict(sorted(self.arrays.items())),
            _SHA256: np.frombuffer(bytes.fromhex(self.sha256), dtype=np.uint8),
        }
        np.savez(buffer, **members)
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
        """Read a plan that `save` wrote; InputFileError (E951 to E955) if it is missing, damaged, or not a plan."""
        members = _members(path)
        text, digest = members.pop(_OPTIONS, None), members.pop(_SHA256, None)
        try:
            options = json.loads(bytes(text))  # type: ignore[arg-type]
        except (TypeError, ValueError, RecursionError):
            raise _not_a_plan(path, "is not a plan: it holds no options") from None
        check_stream(options, str(path))
        plan = cls(arrays=members, options=options)
        if digest is None or digest.tobytes() != bytes.fromhex(plan.sha256):
            raise _not_a_plan(path, "does not fit its own SHA-256: it was changed or damaged after it was written")
        plan.check(path)
        return plan


def differing(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Mask of the numbers of two arrays of one shape that are not those of one run; see `OTHER_PROCESSOR`."""
    if one.dtype.kind != "f":
        return np.asarray(one != other)
    return ~np.isclose(one, other, rtol=OTHER_PROCESSOR, atol=OTHER_PROCESSOR, equal_nan=True)


def _agree(one: np.ndarray, other: np.ndarray) -> bool:
    return one.shape == other.shape and one.dtype == other.dtype and not differing(one, other).any()


def _not_a_plan(path: str | Path, message: str, advice: str = "make the run again") -> InputFileError:
    """The error for a file that is not a plan."""
    return refuse(path, message, advice=advice, code="E951")


def _members(path: str | Path) -> dict[str, np.ndarray]:
    """All arrays of the file, read-only; E951 for any problem."""
    try:
        with open_regular(path) as file, zipfile.ZipFile(file) as stored:
            size = os.fstat(file.fileno()).st_size
            infos = stored.infolist()
            is_packed = any(info.compress_type != zipfile.ZIP_STORED for info in infos)
            if is_packed or size > MAX_PLAN_BYTES or sum(info.file_size for info in infos) > size:
                raise _not_a_plan(
                    path, f"it has {size} bytes, and packed or longer members; we store arrays as they are"
                )
            return {info.filename.removesuffix(".npy"): _array(stored, info) for info in infos}
    except FileNotFoundError:
        raise _not_a_plan(path, "is not a readable plan: there is no such file", "name the folder of a run") from None
    except FileKindError as error:
        raise _not_a_plan(path, f"this is {error.kind}, wanted a plan", "name the folder of a run") from None
    except OSError as error:
        raise OutputError(f"cannot read {path}: {error.strerror or error}") from error
    except (InputFileError, MemoryError):
        raise
    except Exception as error:  # zipfile, zlib and numpy each have their own
        raise _not_a_plan(path, f"is not a readable plan ({error})") from error


def _array(stored: zipfile.ZipFile, info: zipfile.ZipInfo) -> np.ndarray:
    """One array, read-only; its head must give the exact number of bytes, and a type of numbers."""
    with stored.open(info) as member:
        if np.lib.format.read_magic(member) != (1, 0):
            raise ValueError(f"{info.filename} is not a numpy array of version 1.0")
        shape, is_fortran, dtype = np.lib.format.read_array_header_1_0(member, max_header_size=_MAX_HEADER)
        n_bytes = math.prod(shape) * dtype.itemsize
        if dtype.kind not in "iufb" or is_fortran or min(shape, default=0) < 0:
            raise ValueError(f"{info.filename} holds {dtype}, wanted an array of numbers in C order")
        if member.tell() + n_bytes != info.file_size:
            raise ValueError(f"{info.filename} says {n_bytes} bytes and holds {info.file_size - member.tell()}")
        data = member.read()
    return np.ndarray(shape, dtype, buffer=data)
