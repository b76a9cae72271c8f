"""Photons as one MCPL file: writes the same bytes as libmcpl, and reads files of any program."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import aomc_sky
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.emission.photons import PhotonBatch
from aomc_sky.errors import SceneError, UsageError, require_kind
from aomc_sky.formats.mcpl.header import McplHeader, McplRuns, encode_header, plan_begin
from aomc_sky.kernels.arithmetic.rng import philox_pair
from aomc_sky.outputs.manifest import CONVENTIONS
from aomc_sky.outputs.photons.files import (
    FileLayout,
    PhotonFile,
    PhotonRows,
    PhotonWriter,
    emit_photons,
    photon_files,
    require_space,
)
from aomc_sky.outputs.run_folder import RunFolder
from aomc_sky.outputs.statistics import batch_functions
from aomc_sky.plan.allocation import AllocationMethod
from aomc_sky.plan.streams import POSITION, STREAM_VERSION, stream_key
from aomc_sky.system import prepare_target
from aomc_sky.whole_number import as_number_of

if TYPE_CHECKING:
    from aomc_sky.formats.mcpl.file import McplFile, McplParticles

PHOTON = 22
"""The photon in the numbering of the Particle Data Group."""

OPTICAL_PHOTON = -22
"""The optical photon of Geant4, which has no other number."""

MEV_NM = 1.2398419843320026e-3
"""h c: energy [MeV] times wavelength [nm] of a photon, exact constants of the SI, rounded to float64."""

MAX_CELLS = 2**20
"""From this cell on, photons have the user flags 0."""

MAX_WAVEBANDS = 2**12
"""From this waveband on, counted from 1, photons have the user flags 0."""

ENERGY_TOLERANCE = 1e-4
"""Largest relative difference between the energy of a photon and that of its waveband."""

AXIS_DRAW = 3
"""Draw of the words that choose the axes, after those of positions (0) and numbers (1, 2) under the same key."""

_CM_PER_M = 100.0
_WAVELENGTHS_PER_COMMENT = 100
_AXES = (
    "polarisation: one axis of the electric vector a photon, along its direction of polarisation with the probability "
    "(1 + degree)/2, else across it; the mean over photons is the Stokes vector of the light"
)


_OTHERS = ("energy", "position", "time", "user_flags", "polarisation")
"""Columns of a particle besides kind, direction and weight."""


def _are_photons(particles: McplParticles) -> np.ndarray:
    return np.isin(particles.pdg_code, (PHOTON, OPTICAL_PHOTON))


def _has_energy(energy: np.ndarray, expected: float) -> np.ndarray:
    return np.abs(energy - expected) <= ENERGY_TOLERANCE * expected


def _mcpl_rows(file: McplFile, energy: float | None) -> Iterator[PhotonRows]:
    start = 0
    for particles in file.blocks():
        chosen = _are_photons(particles)
        if energy is not None:
            chosen &= _has_energy(particles.energy, energy)
        direction, weight = particles.direction[chosen], particles.weight[chosen]
        others = {
            name: getattr(particles, name)[chosen] for name in _OTHERS if getattr(file.header, f"has_{name}", True)
        }
        yield PhotonRows(start=start, direction=direction, weight=weight, others=others)
        start += len(direction)


class McplWriter(PhotonWriter):
    """The MCPL file of a source and its bytes: all wavebands in one file, one after the other.

    float32 photons make a file of single precision, float64 ones a file of double precision.
    """

    names = ("photons.mcpl",)

    def __init__(self, source: PhotonSource, name: str = names[0], pdg_code: int = PHOTON) -> None:
        super().__init__(source)
        self._name, self._pdg_code = name, pdg_code
        self._record = self._header(0, ()).record
        self._energy = _energies(source)
        self._axis_key = stream_key(source.plan.seed, POSITION, source.plan.options["method"])

    def parts(self, bands: Sequence[int]) -> list[tuple[int, ...]]:
        """Wavebands that share a file: all."""
        return [tuple(bands)]

    def layouts(self, bands: tuple[int, ...]) -> tuple[FileLayout, ...]:
        """The one file."""
        n = sum(self.source.launched[band] for band in bands)
        head = encode_header(self._header(n, _comments(self.source, bands)))
        return (FileLayout(self._name, head, self._record.itemsize, n),)

    def chunks(self, batch: PhotonBatch) -> tuple[memoryview, ...]:
        """Records of a batch; depth and time are 0."""
        records = np.zeros(len(batch), self._record)
        if records.size == 0:
            return (memoryview(b""),)
        _pack(batch, self._energy[batch.band], records)
        if batch.x is not None:
            records["position"] = self.others(batch)["position"]
        if batch.weight is not None:
            records["weight"] = batch.weight
        if batch.q is not None:
            records["polarisation"] = self._axes(batch)
        return (records.view(np.uint8).data,)

    def others(self, batch: PhotonBatch) -> dict[str, np.ndarray]:
        """Energy, position, time, user flags and polarisation of each photon, with the bits of the file."""
        n, waveband, dtype = len(batch), batch.band + 1, self.source.dtype
        flags = waveband * MAX_CELLS + batch.patch if waveband < MAX_WAVEBANDS else np.zeros(n, np.int64)
        position = np.zeros((n, 3), dtype)
        if batch.x is not None and batch.y is not None:
            # the product in float32 has the bits of a rounded float64 product, for 100 has 7 bits
            position[:, 0], position[:, 1] = _CM_PER_M * batch.x, _CM_PER_M * batch.y
        return {
            "energy": np.full(n, self._energy[batch.band]),
            "position": position,
            "time": np.zeros(n),
            "user_flags": np.where(batch.patch < MAX_CELLS, flags, 0),
            "polarisation": self._axes(batch),
        }

    def _axes(self, batch: PhotonBatch) -> np.ndarray:
        """The electric vector of each photon, unit vectors (n, 3) in the precision of the file; 0 without any.

        It lies along the direction of polarisation with the probability (1 + degree) / 2, else across it, so that its
        mean over photons has their Stokes vector. An independent word of Philox decides: key of the positions, counter
        (photon, waveband, `AXIS_DRAW`). Square roots and divisions are rounded alike everywhere, sines are not.
        """
        if batch.q is None or batch.u is None:
            return np.zeros((len(batch), 3))
        q, u, ux, uy, uz = (np.asarray(a, np.float64) for a in (batch.q, batch.u, batch.ux, batch.uy, batch.uz))
        degree = np.sqrt(q * q + u * u)
        # cosine and sine of the angle from the meridian plane, half that of (q, u): the larger one first
        larger = np.sqrt(np.where(degree > 0, (degree + np.abs(q)) / 2.0, 1.0))
        smaller = u / (2.0 * larger)
        scale = np.sqrt(larger * larger + smaller * smaller)
        along = np.where(q < 0, smaller, larger) / scale
        across = np.where(q < 0, larger, smaller) / scale
        photon = np.arange(batch.start, batch.start + len(batch), dtype=np.uint64)
        word, _ = philox_pair(np.uint64(self._axis_key), photon, np.uint64(batch.band), np.uint64(AXIS_DRAW))
        is_along = (word >> np.uint64(11)) * 2.0**-53 < (1.0 + degree) / 2.0
        along, across = np.where(is_along, along, -across), np.where(is_along, across, along)
        sine2 = ux * ux + uy * uy
        sine, length = np.sqrt(sine2), np.sqrt(sine2 + uz * uz)
        is_slanted = sine > 0  # straight down the azimuth is 0
        cos_azimuth = np.where(is_slanted, -ux / np.where(is_slanted, sine, 1.0), 1.0)
        sin_azimuth = np.where(is_slanted, -uy / np.where(is_slanted, sine, 1.0), 0.0)
        inwards = along * -uz / length
        x, y = inwards * cos_azimuth + across * sin_azimuth, inwards * sin_azimuth - across * cos_azimuth
        return np.stack([x, y, -along * sine / length], axis=1).astype(self.source.dtype)

    @staticmethod
    def read(path: Path, wavelength_nm: np.ndarray, bands: tuple[int, ...], weights: str | Path | None) -> PhotonFile:
        """Open an MCPL file: each photon belongs to the waveband of its energy."""
        from aomc_sky.formats.mcpl.file import read_mcpl

        if weights is not None:
            raise UsageError("--weights is for a .npy file; an MCPL file holds its own weights")
        file, energy = read_mcpl(path), MEV_NM / wavelength_nm
        n_of, n_photons = np.zeros(energy.size, dtype=np.int64), 0
        for particles in file.blocks():
            own = particles.energy[_are_photons(particles)]
            n_photons += own.size
            n_of += [np.count_nonzero(_has_energy(own, expected)) for expected in energy]
        notes = []
        if n_photons < len(file):
            notes.append(f"{len(file) - n_photons} of {len(file)} particles are not photons and were left out")
        if not n_of.any():
            if not bands and energy.size > 1:
                none = f"no photon of {path} has the energy of a waveband of the scene"
                raise UsageError(f"{none}: name their waveband with --waveband")
            if len(bands) > 1:
                raise UsageError(f"no photon of {path} has the energy of a waveband: give one --waveband for all")
            notes += ["no photon has the energy of a waveband: all photons are used"] * (n_photons > 0)
            rows = {band: partial(_mcpl_rows, file, None) for band in bands or (0,)}
            return PhotonFile(path=path, rows=rows, notes=tuple(notes), header=file.header)
        bands = bands or tuple(np.flatnonzero(n_of).tolist())
        left = n_photons - int(n_of[list(bands)].sum())
        if left > 0:
            notes.append(f"{left} of {n_photons} photons belong to other wavebands, or to none, and were left out")
        return PhotonFile(
            path=path,
            rows={band: partial(_mcpl_rows, file, float(energy[band])) for band in bands},
            notes=tuple(notes),
            header=file.header,
            n_of={int(band): int(n_of[band]) for band in np.flatnonzero(n_of)},
        )

    def _header(self, n: int, comments: tuple[str, ...]) -> McplHeader:
        return McplHeader(
            n_particles=n,
            source=f"aomc-sky {aomc_sky.__version__}",
            comments=comments,
            has_user_flags=True,
            has_polarisation=self.source.has_polarisation,
            is_double=self.source.dtype == np.float64,
            pdg_code=self._pdg_code,
            weight=0.0 if self.source.has_weights else 1.0,
            is_little_endian=sys.byteorder == "little",
        )


def _energies(source: PhotonSource) -> np.ndarray:
    """Energy of a photon of each waveband, in the precision of the file. [MeV]"""
    wavelength = source.plan.wavelength_nm
    with np.errstate(divide="ignore", over="ignore", under="ignore"):
        energy = (MEV_NM / wavelength).astype(source.dtype)
    for band in np.flatnonzero(~((energy > 0) & np.isfinite(energy))):
        if source.n_photons(int(band)):
            raise SceneError(
                f"waveband {band + 1} has the wavelength {wavelength[band]} nm, for which MCPL has no photon energy",
                "correct lambbot.inp, or write --format npy",
            )
    return energy


def _pack(batch: PhotonBatch, energy: np.floating, records: np.ndarray) -> None:
    """Fill directions, energies and flags."""
    waveband = batch.band + 1
    is_flagged = waveband < MAX_WAVEBANDS
    flags = np.uint32(waveband * MAX_CELLS if is_flagged else 0)
    packed = [records["packed"][:, k] for k in range(3)]
    n_flagged = np.int32(MAX_CELLS if is_flagged else 0)
    photons = (batch.ux, batch.uy, batch.uz, batch.patch)
    batch_functions().pack(*photons, energy, flags, n_flagged, *packed, records["user_flags"])


def _comments(source: PhotonSource, bands: Sequence[int]) -> tuple[str, ...]:
    """Comments for readers of the file, without machine and time, so that equal runs give equal files.

    Between runs of the same wavebands only sums differ, so their files can be merged.
    """
    flags = "user flags: waveband x 2^20 + cell; waveband from 1, cell from 0 as in the columns of counts"
    if source.plan.n_cells > MAX_CELLS or source.n_bands >= MAX_WAVEBANDS:
        flags += "; 0 where the cell is 2^20 or more, or the waveband 4096 or more"
    weight = "weights of mean 1" if source.has_weights else "all weights are 1"
    return (
        f"made by aomc-sky {aomc_sky.__version__}, streams {STREAM_VERSION}",
        f"directions: {CONVENTIONS['direction']}; {CONVENTIONS['frame']}; azimuth {CONVENTIONS['azimuth']}",
        "positions: cm, where the photon enters the surface; origin at the centre of the footprint, z = 0",
        "energy: h c / wavelength of the waveband; time 0; " + weight,
        flags,
        *([_components(source)] if len(source.components) > 1 else []),
        *([_AXES] if source.has_polarisation else []),
        *_wavelengths(source, bands),
        *_runs(source, bands).comments(),
    )


def _components(source: PhotonSource) -> str:
    """The cells of each component, for hosts that tell the light apart."""
    names, start = source.plan.component_names, source.plan.component_start.tolist()
    cells = (f"{name} {first} to {end - 1}" for name, first, end in zip(names, start[:-1], start[1:], strict=True))
    return f"cells of components: {', '.join(cells)}"


def _runs(source: PhotonSource, bands: Sequence[int]) -> McplRuns:
    """The one run of a file that we write."""
    n, options = sum(source.n_photons(band) for band in bands), source.plan.options
    return McplRuns(
        n_runs=1,
        n_photons=n,
        n_iid=n if options["method"] == "iid" else 0,
        n_stratified=n if options["allocation"] != AllocationMethod.MULTINOMIAL.value else 0,
        seed=source.plan.seed,
        plan=plan_begin(source.plan.sha256),
    )


def _wavelengths(source: PhotonSource, bands: Sequence[int]) -> Iterator[str]:
    for start in range(0, len(bands), _WAVELENGTHS_PER_COMMENT):
        part = bands[start : start + _WAVELENGTHS_PER_COMMENT]
        pairs = (f"{band + 1}: {source.plan.bands[band].wavelength_nm!r}" for band in part)
        yield f"wavelengths of the wavebands [nm]: {', '.join(pairs)}"


def write_mcpl(source: PhotonSource, path: str | Path, *, threads: int = 0, pdg_code: int = PHOTON) -> None:
    """Write all photons of a source as one MCPL file (format 3).

    Parameters
    ----------
    source : PhotonSource
        Where the photons come from.
    path : str or Path
        The file, replaced atomically; its folder must exist.
    threads : int
        Threads, 0 for one per CPU; the bytes do not depend on it. [0 to 1024]
    pdg_code : {22, -22}
        Kind of the particles: the photon, or the optical photon of Geant4.

    Raises
    ------
    OutputError
        The operating system refuses, or the disk is full; nothing half-written is left.

    Notes
    -----
    Photons pass through in blocks: memory stays flat whatever their number. See docs/formats/mcpl.md
    for units, conventions and user flags.

    Examples
    --------
    >>> scene = sky.Scene(wavebands=[550.0], n_photons=100, components="uniform")
    >>> sky.write_mcpl(scene.source(seed=1), "photons.mcpl")
    """
    require_kind(source, PhotonSource, "write_mcpl(scene.source(seed=1), path)")
    path = Path(path)
    if not path.name or path.suffix.lower() == ".gz":
        raise UsageError(f"expected the name of a file such as photons.mcpl, which gzip can pack, got {str(path)!r}")
    threads = as_number_of(threads, "threads", 0, 1024)
    if pdg_code not in (PHOTON, OPTICAL_PHOTON):
        raise UsageError(f"pdg_code must be {PHOTON} (photon) or {OPTICAL_PHOTON} (optical photon), got {pdg_code!r}")
    bands = range(source.n_bands)
    prepare_target(path)
    files = photon_files(RunFolder(path.parent), [McplWriter(source, path.name, int(pdg_code))], bands)
    require_space(files)
    emit_photons(source, files, bands, threads)
