"""The plan of a run, which every shard, export and check reads and never recomputes, and its file plan.npz.

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
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.errors import AomcSkyError, InputFileError, OutputError, require_kind
from aomc_sky.float_mode import in_default_mode
from aomc_sky.formats.text_file import refuse
from aomc_sky.grid import PatchGrid
from aomc_sky.plan.allocation import PlanBand
from aomc_sky.plan.check import check_members, check_plan, check_stream, refused
from aomc_sky.plan.streams import STREAM_VERSION, photon_keys
from aomc_sky.system import FileKindError, open_regular
from aomc_sky.whole_number import as_index

OTHER_PROCESSOR = 1e-12
"""Largest relative difference of numbers that another processor computes; whole numbers must be equal."""

MAX_PLAN_BYTES = 2**34
"""Largest plan that is read. [bytes]"""

_OPTIONS, _SHA256, _STATED = "options", "sha256", b"aomc-sky made from"
_MAX_HEADER = 1000


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
    bias : ndarray, float64, shape (n_row, n_cell), optional
        Photons of a cell over those that its light would get; None where photons are shared out as light is.

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
    bias: np.ndarray | None = None
    _sha256: str = field(init=False, repr=False, default="")  #: once it was asked for

    def __post_init__(self) -> None:
        check_plan(self.bands, self.components, self.cumulative, self.options, self.bias)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Plan) and self.sha256 == other.sha256

    def __repr__(self) -> str:
        total = int(self.cumulative[:, -1].astype(object).sum())
        bands = f"{self.n_bands} waveband{'s' * (self.n_bands != 1)}"
        return f"<Plan {self.sha256[:16]}: {total} photons in {bands}, {self.n_cells} cells, seed {self.seed}>"

    def agrees(self, other: Plan) -> bool:
        """Whether it is the same run made on another processor: whole numbers are equal, others within 1e-12."""
        require_kind(other, Plan, "plan.agrees(sky.Plan.load('plan.npz'))")
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

    def row_of(self, band: int) -> int:
        """Row of the components that serves a band; IndexError where it does not exist."""
        band = as_index(band, "band")
        if not 0 <= band < self.n_bands:
            raise IndexError(f"band {band} does not exist; bands run from 0 to {self.n_bands - 1}")
        return self.bands[band].row

    def mass(self, band: int) -> np.ndarray:
        """Share of the light of each cell in a band, float64 (n_cell,), sum 1; 0 without light."""
        row = self.row_of(band)
        parts = [component.mass[row] for component in self.components]
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def launch(self, band: int) -> np.ndarray:
        """Share of the photons of each cell in a band, float64 (n_cell,), sum 1; that of the light without a bias."""
        mass = self.mass(band)
        return mass if self.bias is None else mass * self.bias[self.row_of(band)]

    def masses(self, bands: Iterable[int]) -> list[np.ndarray]:
        """The `mass` of several bands."""
        return [self.mass(band) for band in bands]

    def weight(self, band: int) -> np.ndarray | None:
        """Weight of the photons of each cell in a band, float64 (n_cell,), or None; see `weight_has_mu`."""
        row = self.row_of(band)
        if self.bias is not None:
            return np.asarray(1.0 / self.bias[row])
        parts = [component.weight[row] for component in self.components if component.weight is not None]
        return np.concatenate(parts) if parts else None

    @property
    def weight_has_mu(self) -> np.ndarray:
        """Whether photons of each cell have a further factor mu, bool (n_cell,): those launched by solid angle."""
        has_weight = all(component.weight is not None for component in self.components)
        return np.asarray((self.law == Law.CELL_MU) & has_weight)

    def stokes(self, band: int) -> np.ndarray | None:
        """Q/I and U/I of each cell in a band, float64 (n_cell, 2), 0 for unpolarised ones; None where all are."""
        row = self.row_of(band)
        if all(component.stokes is None for component in self.components):
            return None
        rows = [component.of_row(row) for component in self.components]
        return np.concatenate([np.zeros((row.n_cells, 2)) if row.stokes is None else row.stokes[0] for row in rows])

    def members(self) -> dict[str, np.ndarray]:
        """The arrays of plan.npz by their names there."""
        bands, components = self.bands, self.components
        weights = [component.weight for component in components if component.weight is not None]
        members = {
            "wavelength_nm": self.wavelength_nm,
            "sky_wavelength_nm": np.array([band.sky_wavelength_nm for band in bands]),
            "requested": np.array([band.requested for band in bands], np.int64),
            "row_of_band": np.array([band.row for band in bands], np.int64),
            "cumulative": self.cumulative,
            "mass": _joined([component.mass for component in components], axis=1),
            "weight": _joined(weights, axis=1) if weights else np.zeros((0, 0)),
            "law": self.law,
            "cell": _joined([component.cell for component in components], axis=0),
            "component_start": self.component_start,
            "keys": photon_keys(self.options["seed"], self.options["method"]),
        }
        if self.bias is not None:
            members["bias"] = self.bias
        for k, component in enumerate(components):
            if component.grid is not None:
                members[f"zenith_bounds_deg_{k}"] = component.grid.zenith_bounds_deg
                members[f"azimuth_bounds_deg_{k}"] = component.grid.azimuth_bounds_deg
            for name in ("shared", "bounds", "slope", "stokes"):
                if (array := getattr(component, name)) is not None:
                    members[f"{name}_{k}"] = array
        if bands[0].irradiance_W_m2_nm is not None:
            members["irradiance_W_m2_nm"] = np.array([band.irradiance_W_m2_nm for band in bands])
            members["horizon_loss"] = np.array([band.horizon_loss for band in bands])
        return members

    @property
    def sha256(self) -> str:
        """Name of the run: SHA-256 over sorted name, dtype, shape, little-endian bytes, and options."""
        if not self._sha256:
            object.__setattr__(self, "_sha256", sha256_of(self.members(), self.options))
        return self._sha256

    def to_bytes(self, stated: Mapping[str, str] | None = None) -> bytes:
        """The plan as the bytes of an npz file; equal plans give equal bytes.

        `stated` are digests of what the plan was made from, by name. They change neither a photon nor the hash.
        """
        return npz_bytes(self.members(), self.options, self.sha256, stated)

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
        members, options = read_npz(os.fspath(path))
        try:
            return from_members(members, options)
        except InputFileError as error:
            raise InputFileError([replace(problem, path=str(path)) for problem in error.problems]) from None


def differing(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Mask of the numbers of two arrays of one shape that are not those of one run; see `OTHER_PROCESSOR`."""
    if one.dtype.kind != "f":
        return np.asarray(one != other)
    return ~np.isclose(one, other, rtol=OTHER_PROCESSOR, atol=OTHER_PROCESSOR, equal_nan=True)


def from_members(members: Mapping[str, np.ndarray], options: dict[str, Any]) -> Plan:
    """The plan of these arrays; InputFileError (E952 to E955) names the first member that is wrong."""
    check_members(members, options)
    absolute, loss = members.get("irradiance_W_m2_nm"), members.get("horizon_loss")
    bands = tuple(
        PlanBand(
            wavelength_nm=float(members["wavelength_nm"][band]),
            sky_wavelength_nm=float(members["sky_wavelength_nm"][band]),
            requested=int(members["requested"][band]),
            row=int(members["row_of_band"][band]),
            irradiance_W_m2_nm=None if absolute is None else tuple(absolute[band].tolist()),
            horizon_loss=0.0 if loss is None else float(loss[band]),
        )
        for band in range(members["wavelength_nm"].size)
    )
    components = tuple(_component(members, options, k) for k in range(len(options["components"])))
    cumulative, bias = members["cumulative"], members.get("bias")
    return Plan(bands=bands, components=components, cumulative=cumulative, options=options, bias=bias)


def _component(members: Mapping[str, np.ndarray], options: Mapping[str, Any], k: int) -> Component:
    start, end = members["component_start"][k : k + 2].tolist()
    mass, weight = members["mass"][:, start:end], members["weight"]
    try:
        return Component(
            name=options["components"][k],
            law=Law(int(members["law"][start])),
            strength=mass.sum(axis=1),
            mass=mass,
            cell=members["cell"][start:end],
            grid=_grid(members, options, k),
            weight=weight[:, start:end] if weight.size else None,
            shared=members.get(f"shared_{k}"),
            bounds=members.get(f"bounds_{k}"),
            slope=members.get(f"slope_{k}"),
            stokes=members.get(f"stokes_{k}"),
        )
    except ValueError as error:  # types, lengths and masses were checked before: a slope is too steep
        raise refused("E954", f"slope_{k}", str(error)) from None


def _grid(members: Mapping[str, np.ndarray], options: Mapping[str, Any], k: int) -> PatchGrid | None:
    zenith, azimuth = members.get(f"zenith_bounds_deg_{k}"), members.get(f"azimuth_bounds_deg_{k}")
    if zenith is None or azimuth is None:
        return None
    first = options["azimuth_first_index"][k]
    try:
        return PatchGrid(zenith_bounds_deg=zenith, azimuth_bounds_deg=azimuth, azimuth_first_index=first)
    except (ValueError, AomcSkyError) as error:
        raise refused("E954", f"zenith_bounds_deg_{k}", str(error)) from None


def _joined(parts: Sequence[np.ndarray], axis: int) -> np.ndarray:
    """All parts in one array; a single one is not copied, for it may be as large as the plan."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=axis)


def sha256_of(members: Mapping[str, np.ndarray], options: Mapping[str, Any]) -> str:
    """SHA-256 over sorted name, dtype, shape, little-endian bytes, and options."""
    digest = hashlib.sha256()
    digest.update(STREAM_VERSION.encode() + b"\0")
    for name in sorted(members):
        array = members[name]
        little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
        head = f"{name}\0{little.dtype.str}\0{','.join(map(str, little.shape))}\0"
        digest.update(head.encode())
        digest.update(little.data if little.size else b"")
    digest.update(_json(options))
    return digest.hexdigest()


def npz_bytes(
    members: Mapping[str, np.ndarray],
    options: Mapping[str, Any],
    sha256: str,
    stated: Mapping[str, str] | None = None,
) -> bytes:
    """The members, their options and their hash as the bytes of an npz file, whose comment holds what is `stated`."""
    buffer = io.BytesIO()
    stored: dict[str, Any] = {
        _OPTIONS: np.frombuffer(_json(options), dtype=np.uint8),
        **dict(sorted(members.items())),
        _SHA256: np.frombuffer(bytes.fromhex(sha256), dtype=np.uint8),
    }
    np.savez(buffer, **stored)
    if stated is not None:  # a comment, so that older versions read the plan
        text = _json(stated)
        with zipfile.ZipFile(buffer, "a") as archive:
            archive.comment = b" ".join((_STATED, hashlib.sha256(text).hexdigest().encode(), text))
    return buffer.getvalue()


def read_stated(path: str | Path) -> dict[str, str] | None:
    """Digests of what a plan was made from; None where it states nothing, E951 where they do not fit their own."""
    with open_regular(path) as file, zipfile.ZipFile(file) as archive:
        comment = archive.comment
    if not comment:
        return None
    head, _, rest = comment[len(_STATED) :].partition(b" ")[2].partition(b" ")
    if not comment.startswith(_STATED) or head != hashlib.sha256(rest).hexdigest().encode():
        raise _not_a_plan(path, "states of its scene what does not fit its digest: it was changed or damaged")
    return dict(json.loads(rest))


def read_npz(path: str | Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Members and options of a file that fits its hash; E951, or E955 for a plan of another stream."""
    members = _members(path)
    text, digest = members.pop(_OPTIONS, None), members.pop(_SHA256, None)
    try:
        options = json.loads(bytes(text))  # type: ignore[arg-type]
    except (TypeError, ValueError, RecursionError):
        raise _not_a_plan(path, "is not a plan: it holds no options") from None
    check_stream(options, str(path))
    if digest is None or digest.tobytes() != bytes.fromhex(sha256_of(members, options)):
        raise _not_a_plan(path, "does not fit its own SHA-256: it was changed or damaged after it was written")
    return members, options


def _json(options: Mapping[str, Any]) -> bytes:
    return json.dumps(options, sort_keys=True, separators=(",", ":")).encode()


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
        raise _not_a_plan(path, f"this is {error.kind}, expected a plan", "name the folder of a run") from None
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
            raise ValueError(f"{info.filename} holds {dtype}, expected an array of numbers in C order")
        if member.tell() + n_bytes != info.file_size:
            raise ValueError(f"{info.filename} says {n_bytes} bytes and holds {info.file_size - member.tell()}")
        data = member.read()
    return np.ndarray(shape, dtype, buffer=data)
