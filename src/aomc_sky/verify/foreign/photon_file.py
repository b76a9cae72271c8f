"""Photons that any code has written, as blocks of one waveband: numpy files and MCPL."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.formats.mcpl.file import McplFile, read_mcpl
from aomc_sky.formats.mcpl.header import McplHeader
from aomc_sky.formats.photons_npy import PhotonsNpy, read_photons_npy
from aomc_sky.formats.text_file import refuse
from aomc_sky.outputs.photons.mcpl import MEV_NM, PHOTON
from aomc_sky.verify.sky.direction_counts import PhotonRows

ENERGY_TOLERANCE = 1e-4
"""How far a photon's energy may be from that of its waveband, as a share of it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PhotonFile:
    """A file of photons and the wavebands of a scene that they belong to."""

    path: Path
    #: Wavebands that have photons in it, or that the user says. [0-based]
    bands: tuple[int, ...]
    #: What a person should know: photons that were left out.
    notes: tuple[str, ...] = ()
    #: What the head of an MCPL file says.
    header: McplHeader | None = None
    #: Photons of each of these wavebands, where their energies tell them apart.
    n_of: Mapping[int, int] = field(default_factory=dict)
    _npy: PhotonsNpy | None = field(default=None, repr=False)
    _weights: PhotonsNpy | None = field(default=None, repr=False)
    _mcpl: McplFile | None = field(default=None, repr=False)
    _energy: Mapping[int, float] = field(default_factory=dict, repr=False)

    def rows(self, band: int) -> Iterator[PhotonRows]:
        """Photons of a waveband, block by block."""
        if self._npy is not None:
            return _npy_rows(self._npy, self._weights)
        assert self._mcpl is not None
        return _mcpl_rows(self._mcpl, self._energy.get(band))


def open_photons(
    path: str | Path,
    wavelength_nm: np.ndarray,
    *,
    wavebands: Sequence[int] | None = None,
    weights: str | Path | None = None,
) -> PhotonFile:
    """Open a file of photons.

    ``.npy``: rows ux, uy, uz, and the weight where there is a fourth column, or in a numpy file of `weights`; anything
    else: MCPL, of which photons belong to the waveband of their energy. `wavebands` are 1-based. A UsageError says that
    neither the file nor the user names the waveband, or that there is no such one.
    """
    path = Path(path)
    bands = None if not wavebands else tuple(dict.fromkeys(_checked(w, wavelength_nm.size) for w in wavebands))
    if path.suffix.lower() == ".npy":
        return _open_npy(path, bands, wavelength_nm.size, weights)
    if weights is not None:
        raise UsageError("--weights goes with a .npy file; MCPL has weights of its own")
    return _open_mcpl(path, bands, wavelength_nm)


def _checked(waveband: int, n_bands: int) -> int:
    if not 1 <= waveband <= n_bands:
        raise UsageError(f"waveband {waveband} is not in this scene; it has wavebands 1 to {n_bands}")
    return waveband - 1


def _open_npy(path: Path, bands: tuple[int, ...] | None, n_bands: int, weights: str | Path | None) -> PhotonFile:
    photons = read_photons_npy(path)
    if bands is None and n_bands > 1:
        raise UsageError(f"the scene has {n_bands} wavebands: say with --waveband which one the photons belong to")
    if bands is not None and len(bands) > 1:
        raise UsageError("a .npy file holds photons of one waveband: give one --waveband")
    of_weights = None if weights is None else read_photons_npy(weights, n_columns=(1,))
    if of_weights is not None and photons.n_columns == 4:
        raise UsageError(f"{path} has weights in its fourth column: leave --weights out")
    if of_weights is not None and len(of_weights) != len(photons):
        raise refuse(
            of_weights.path, f"{len(of_weights)} weights for the {len(photons)} photons of {path}", code="E903"
        )
    return PhotonFile(path=path, bands=bands or (0,), _npy=photons, _weights=of_weights)


def _npy_rows(photons: PhotonsNpy, weights: PhotonsNpy | None) -> Iterator[PhotonRows]:
    of_weights = None if weights is None else weights.blocks()
    start = 0
    for rows in photons.blocks():
        weight = rows[:, 3] if photons.n_columns == 4 else None
        if of_weights is not None:
            weight = next(of_weights)[:, 0]
        yield PhotonRows(start=start, direction=rows[:, :3], weight=weight)
        start += len(rows)


def _open_mcpl(path: Path, bands: tuple[int, ...] | None, wavelength_nm: np.ndarray) -> PhotonFile:
    file = read_mcpl(path)
    energy = MEV_NM / wavelength_nm
    found, n_photons = _photons_of(file, energy)
    notes = []
    if n_photons < len(file):
        notes.append(f"{len(file) - n_photons} of {len(file)} particles are no photons and were left out")
    if not found.any():
        if bands is None and wavelength_nm.size > 1:
            raise UsageError(
                f"no photon of {path} has the energy of a waveband of the scene: say with --waveband which one they "
                "belong to"
            )
        if bands is not None and len(bands) > 1:
            raise UsageError(f"no photon of {path} has the energy of a waveband: give one --waveband for all")
        notes.append("no photon has the energy of a waveband: all of them are taken")
        return PhotonFile(path=path, bands=bands or (0,), notes=tuple(notes), header=file.header, _mcpl=file)
    chosen = bands if bands is not None else tuple(np.flatnonzero(found).tolist())
    left = n_photons - int(found[list(chosen)].sum())
    if left > 0:
        notes.append(f"{left} of {n_photons} photons belong to other wavebands or to none and were left out")
    return PhotonFile(
        path=path,
        bands=chosen,
        notes=tuple(notes),
        header=file.header,
        n_of={band: int(found[band]) for band in chosen},
        _mcpl=file,
        _energy={band: float(energy[band]) for band in chosen},
    )


def _photons_of(file: McplFile, energy: np.ndarray) -> tuple[np.ndarray, int]:
    """Photons with the energy of each waveband, and photons in all."""
    found, n_photons = np.zeros(energy.size, dtype=np.int64), 0
    for particles in file.blocks():
        own = particles.energy[particles.pdg_code == PHOTON]
        n_photons += own.size
        for band in range(energy.size):
            found[band] += int(np.count_nonzero(_has_energy(own, float(energy[band]))))
    return found, n_photons


def _has_energy(energy: np.ndarray, expected: float) -> np.ndarray:
    return np.abs(energy - expected) <= ENERGY_TOLERANCE * expected


def _mcpl_rows(file: McplFile, energy: float | None) -> Iterator[PhotonRows]:
    start = 0
    for particles in file.blocks():
        chosen = particles.pdg_code == PHOTON
        if energy is not None:
            chosen &= _has_energy(particles.energy, energy)
        direction, weight = particles.direction[chosen], particles.weight[chosen]
        yield PhotonRows(start=start, direction=direction, weight=weight)
        start += len(direction)
