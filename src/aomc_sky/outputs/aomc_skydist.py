"""A skydist.inp from which the unmodified AOMC 1.2.2 program launches exactly our photon counts."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aomc_sky.errors import AllocationError, InputWarning, SceneError
from aomc_sky.formats.amc import AmcConfig, LightSource, read_amc
from aomc_sky.formats.skydist import Bins, SkyTable, Values, write_skydist
from aomc_sky.formats.text_file import read_bytes, split_lines, write_atomically
from aomc_sky.outputs.aomc_values import MOST_PHOTONS, exact_radiances
from aomc_sky.outputs.degree_counts import degree_counts
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.wavebands import midpoint_wavelength_index

_FIRST_COLUMN, _ITERATIONS_END = 48, 60


@dataclass(frozen=True, kw_only=True, slots=True)
class AomcSky:
    """What `--to aomc` writes.

    Parameters
    ----------
    table : SkyTable
        Radiances on whole degrees, wavelengths ascending.
    iterations : int
        Line 1 of amc.inp: the photons of every waveband that has any.
    counts : ndarray, int64, shape (n_band, 89, n_azimuth)
        Photons that the program will launch from zenith index 1 .. 89 and azimuth index 0 ...
    notes : tuple of str
        What the user should know, a line each.
    """

    table: SkyTable
    iterations: int
    counts: np.ndarray
    notes: tuple[str, ...] = ()


def aomc_sky(source: PhotonSource, bands: Sequence[int] | None = None) -> AomcSky:
    """Turn the counts of a run into radiances for the AOMC program.

    Parameters
    ----------
    source : PhotonSource
        The run.
    bands : sequence of int, optional
        Wavebands wanted, all by default; the others launch nothing. [0-based]

    Returns
    -------
    AomcSky
        Checked: the program's own 32-bit rule gives back exactly `counts`.

    Raises
    ------
    SceneError
        The format cannot carry the run: photons from a beam, wavebands with different totals, or two
        different wavebands that the program cannot tell apart.
    AllocationError
        More than 1.6e7 photons in a band, or no radiances that give the counts.
    """
    chosen = range(source.n_bands) if bands is None else bands
    iterations = _common_total(source, chosen)
    found = degree_counts(source, chosen)
    wavelength = source.plan.arrays["wavelength_nm"]
    table, band_of_table = _wavelength_table(wavelength, found.counts)
    radiance = np.zeros((table.size, *found.counts.shape[1:]))
    for k, band in enumerate(band_of_table):
        radiance[k] = exact_radiances(found.counts[band])
    sky = SkyTable(wavelength_nm=table, radiance=radiance)
    notes = (found.note, *_dark_note(found.counts))
    return AomcSky(table=sky, iterations=iterations, counts=found.counts, notes=tuple(n for n in notes if n))


def _common_total(source: PhotonSource, bands: Sequence[int]) -> int:
    """Photons of every waveband that has any."""
    totals = {band: source.n_photons(band) for band in bands if source.n_photons(band)}
    if not totals:
        raise SceneError("no waveband of this run has photons, so there is nothing to export")
    band, most = max(totals.items(), key=lambda item: item[1])
    if most > MOST_PHOTONS:
        raise AllocationError(
            f"waveband {band + 1} has {most} photons; the AOMC program counts in 32-bit floats, and up to "
            f"{MOST_PHOTONS} per waveband come out exactly: export a run with fewer iterations, several with other "
            "seeds if need be"
        )
    other, least = min(totals.items(), key=lambda item: item[1])
    if least != most:
        raise SceneError(
            f"waveband {band + 1} has {most} photons and waveband {other + 1} has {least}; amc.inp has one number of "
            "iterations for all wavebands: export one at a time with --waveband"
        )
    return most


def _wavelength_table(wavelength_nm: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ascending wavelengths for the table and the band that each belongs to.

    The program takes the first j with wavelength < (w[j] + w[j+1]) / 2, which finds every wavelength of an
    ascending table that 32-bit floats tell from its neighbours.
    """
    _, first, index = np.unique(wavelength_nm.astype(np.float32), return_index=True, return_inverse=True)
    for band, k in enumerate(index):
        if not np.array_equal(counts[band], counts[first[k]]):
            raise SceneError(
                f"wavebands {first[k] + 1} and {band + 1} have the same wavelength, {wavelength_nm[band]:g} nm, and "
                "different counts; the AOMC program chooses a sky by its wavelength: export one at a time with "
                "--waveband"
            )
    table = wavelength_nm[first]
    taken = midpoint_wavelength_index(wavelength_nm, table)
    if not np.array_equal(taken, index):
        band = int(np.flatnonzero(taken != index)[0])
        raise SceneError(
            f"waveband {band + 1} at {wavelength_nm[band]!r} nm is too close to another one for the AOMC program's "
            "32-bit floats to choose its own sky"
        )
    return table, first


def _dark_note(counts: np.ndarray) -> tuple[str, ...]:
    dark = np.flatnonzero(counts.sum(axis=(1, 2)) == 0) + 1
    if not dark.size:
        return ()
    named = ", ".join(map(str, dark[:20].tolist())) + (" ..." if dark.size > 20 else "")
    return (f"wavebands without photons, whose sky is dark: {named}",)


def write_aomc_sky(sky: AomcSky, folder: Path) -> None:
    """Write skydist.inp into a folder; `read_skydist` gives the same radiances back."""
    write_skydist(sky.table, folder / "skydist.inp", bins=Bins.DEGREES, values=Values.RADIANCE)


def write_amc_copy(scene: Path, target: Path, iterations: int) -> None:
    """Copy amc.inp with another number of iterations and the light source from a file; all else stays.

    Parameters
    ----------
    scene, target : Path
        The amc.inp to read and the one to write.
    iterations : int
        For line 1. [1 to 999 999 999]

    Raises
    ------
    InputFileError
        The scene's amc.inp cannot be read.
    """
    config = _read_quietly(scene)
    lines = split_lines(read_bytes(scene))
    lines[0] = _with_field(lines[0], str(iterations), _ITERATIONS_END)
    lines[1] = _with_field(lines[1], str(int(LightSource.FILE)), _FIRST_COLUMN + 1)
    # characters beyond ASCII stand in labels and comments, which nobody reads
    text = "".join(f"{line}\n" for line in lines).encode("ascii", "replace").decode("ascii")
    write_atomically(target, text)
    _check_copy(target, dataclasses.replace(config, iterations=iterations, light_source=LightSource.FILE))


def _with_field(line: str, value: str, end: int) -> str:
    width = end - _FIRST_COLUMN
    return f"{line[:_FIRST_COLUMN]:<{_FIRST_COLUMN}}{value:<{width}}{line[end:]}"


def _check_copy(target: Path, wanted: AmcConfig) -> None:
    if _read_quietly(target) != wanted:
        raise SceneError(f"{target} does not read back as the scene it was copied from; write amc.inp by hand")


def _read_quietly(path: Path) -> AmcConfig:
    """Read amc.inp without the warnings that the run has already given."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)
        return read_amc(path, lenient=True)
