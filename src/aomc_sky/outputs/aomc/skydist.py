"""A skydist.inp from which the unmodified AOMC 1.2.2 program launches exactly our photon counts, and its folder."""

from __future__ import annotations

import dataclasses
import shutil
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.errors import AllocationError, InputWarning, SceneError
from aomc_sky.formats.aomc.amc import AmcConfig, LightSource, read_amc, read_lambbot
from aomc_sky.formats.aomc.skydist import Bins, SkyTable, Values, write_skydist
from aomc_sky.formats.text_file import read_lines, write_atomically
from aomc_sky.outputs.aomc.degree_counts import (
    LAST_ZENITH_DEG,
    MOST_PHOTONS,
    degree_counts,
    degree_reasons,
    photon_reasons,
    refuse,
    wavelength_reasons,
)
from aomc_sky.outputs.run_folder import RunFolder
from aomc_sky.plan.allocation import AllocationMethod, allocate
from aomc_sky.skies.tabulated import aomc_weight
from aomc_sky.source.scene import Scene
from aomc_sky.system import appearing, open_regular
from aomc_sky.wavebands import Wavebands, midpoint_wavelength_index

_FIRST_COLUMN, _ITERATIONS_END = 48, 60
_DRIFT = "the program's own rounding is kept: {} to {} photons in a waveband for {} iterations"


@dataclass(frozen=True, kw_only=True, slots=True)
class AomcSky:
    """The contents of a folder of `--to aomc`."""

    table: SkyTable  #: radiances on whole degrees, wavelengths ascending
    iterations: int  #: line 1 of amc.inp: the photons of every waveband that has any
    counts: np.ndarray  #: photons that the program will launch, from zenith index 1; int64 (n_band, 89, n_azimuth)
    wavelength_nm: np.ndarray  #: of the wavebands; float64 (n_band,)
    sky_wavelength_nm: np.ndarray  #: of the sky that the program takes for each waveband; float64 (n_band,)
    notes: tuple[str, ...] = ()  #: lines for the user


def aomc_sky(source: PhotonSource, bands: Sequence[int] | None = None) -> AomcSky:
    """Turn the counts of a run into radiances for the AOMC program, checked by its own 32-bit rule.

    amc.inp holds one number of photons. If the wavebands of a run differ in it, the run is planned again with the
    largest one for all of them. A run with the program's own rounding (``--compat aomc``) keeps its counts, whose
    totals drift. Wavebands that are not among `bands` launch nothing, unless they have the wavelength of
    one. SceneError names the reasons why the program cannot have the run; AllocationError if no radiances give the
    counts.
    """
    chosen = list(range(source.n_bands) if bands is None else bands)
    n_photons = {band: source.n_photons(band) for band in chosen if source.n_photons(band)}
    if source.has_weights:
        option = "--bias" if source.has_bias else "--weights"
        refuse([f"its photons have weights, and the program has none; run it without {option}"])
    iterations, planned, total_note = max(n_photons.values(), default=0), source, ""
    if is_rounded := source.plan.options["allocation"] == AllocationMethod.AOMC.value:
        iterations = max(source.plan.bands[band].requested for band in chosen)
        on_degrees, note = _counts_of_table(source, chosen), ""
        totals = on_degrees[chosen].sum(axis=(1, 2))
        if not np.all(totals == iterations):
            note = _DRIFT.format(totals.min(), totals.max(), iterations)
    else:
        if len(set(n_photons.values())) > 1:
            planned = one_total(source, n_photons)
            total_note = (
                f"the wavebands of the run have {min(n_photons.values())} to {iterations} photons, but amc.inp holds "
                f"one number: each waveband was planned again with {iterations} photons; multiply the results of a "
                f"waveband by its photons in the run over {iterations}"
            )
        refuse([*photon_reasons(n_photons), *degree_reasons(planned, chosen)])
        on_degrees, note = degree_counts(planned, chosen)
    wavelength_nm = source.plan.wavelength_nm
    band_of_row, row_of_band = _wavelength_rows(wavelength_nm, chosen)
    own = on_degrees[band_of_row[row_of_band]]
    refuse(wavelength_reasons(wavelength_nm, [b for b in chosen if not np.array_equal(own[b], on_degrees[b])]))
    radiance = [
        _program_radiances(source.mass(band), on_degrees[band], iterations)
        if is_rounded and band in chosen
        else exact_radiances(on_degrees[band])
        for band in band_of_row.tolist()
    ]
    return AomcSky(
        table=SkyTable(wavelength_nm=wavelength_nm[band_of_row], radiance=np.stack(radiance).astype(np.float64)),
        iterations=iterations,
        counts=own,
        wavelength_nm=wavelength_nm,
        sky_wavelength_nm=wavelength_nm[band_of_row[row_of_band]],
        notes=tuple(filter(None, (note, total_note))),
    )


def _counts_of_table(source: PhotonSource, chosen: Sequence[int]) -> np.ndarray:
    """Counts of a run with ``--compat aomc``, from zenith index 1; 0 for bands that are not chosen."""
    grid = source.grid
    assert grid is not None  # the program's rounding is for one table
    on_degrees = np.zeros((source.n_bands, LAST_ZENITH_DEG, grid.n_azimuth), dtype=np.int64)
    counts = source.counts.reshape(source.n_bands, grid.n_zenith, grid.n_azimuth)[chosen, :LAST_ZENITH_DEG]
    on_degrees[chosen, : grid.n_zenith] = counts
    return on_degrees


def one_total(source: PhotonSource, n_photons: dict[int, int]) -> PhotonSource:
    """The same sky, seed and methods with the largest of the given totals in each of these wavebands."""
    plan = source.plan
    requested = np.zeros(source.n_bands, dtype=np.int64)
    requested[list(n_photons)] = max(n_photons.values())
    scene = Scene(
        wavebands=Wavebands(wavelength_nm=plan.wavelength_nm),
        n_photons=requested,
        components=source.components,
        row_of_band=np.array([band.row for band in plan.bands]),
    )
    return scene.source(plan.seed, allocation=plan.options["allocation"], method=plan.options["method"])


def _wavelength_rows(wavelength_nm: np.ndarray, chosen: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """The waveband of each row of the table, and the row that the program takes for each waveband.

    Rows ascend in wavelength and differ in 32 bits. A chosen waveband comes before others of the same wavelength.
    The program takes the first j with wavelength < (w[j] + w[j+1]) / 2, which finds each wavelength of an ascending
    table whose neighbours differ as 32-bit floats.
    """
    single = wavelength_nm.astype(np.float32)
    is_chosen = np.zeros(wavelength_nm.size, dtype=bool)
    is_chosen[list(chosen)] = True
    order = np.lexsort((np.arange(single.size), ~is_chosen, single))
    band_of_row = order[np.unique(single[order], return_index=True)[1]]
    return band_of_row, midpoint_wavelength_index(wavelength_nm, wavelength_nm[band_of_row])


def write_amc_copy(scene: Path, target: Path, iterations: int) -> None:
    """Copy amc.inp with new iterations [1 to 999 999 999] and a light source from a file."""
    config = read_quietly(scene)
    lines = read_lines(scene)
    lines[0] = _with_field(lines[0], str(iterations), _ITERATIONS_END)
    lines[1] = _with_field(lines[1], str(int(LightSource.FILE)), _FIRST_COLUMN + 1)
    # only labels and comments have characters beyond ASCII
    text = "".join(f"{line}\n" for line in lines).encode("ascii", "replace").decode("ascii")
    write_atomically(target, text)
    if read_quietly(target) != dataclasses.replace(config, iterations=iterations, light_source=LightSource.FILE):
        raise SceneError(
            f"{target} is not the scene that it was copied from when it is read again", "write amc.inp by hand"
        )


def _with_field(line: str, value: str, end: int) -> str:
    width = end - _FIRST_COLUMN
    return f"{line[:_FIRST_COLUMN]:<{_FIRST_COLUMN}}{value:<{width}}{line[end:]}"


def read_quietly(path: Path) -> AmcConfig:
    """Read amc.inp without warnings, which the run has shown already."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)
        return read_amc(path, lenient=True)


SKYDIST = "skydist.inp"
COUNTS = "counts.csv"
_PROGRAM_FILES = ("amc.inp", "lambbot.inp", "conc.inp", "abs.inp", "scat.inp", "spf.inp")
"""Files that the program reads besides the sky; the last four describe the water."""
_LEFT_OUT = (SKYDIST, "amc.inp", "difcol.inp")
"""Files of a scene that are not copied: two are made new, and the program does not need difcol.inp."""


def check_scene(amc_inp: Path, wavelength_nm: np.ndarray) -> None:
    """Refuse a scene whose lambbot.inp has not the wavebands of the run. [nm]"""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)  # the run has shown them
        scene_nm = read_lambbot(amc_inp.parent / "lambbot.inp", lenient=True).wavelength_nm
    if not np.array_equal(scene_nm, wavelength_nm):
        raise SceneError(
            f"{amc_inp.parent / 'lambbot.inp'} has {scene_nm.size} wavebands that are not the {wavelength_nm.size} of "
            "the run",
            "name the scene that was run",
        )


def write_aomc_folder(sky: AomcSky, folder: RunFolder, amc_inp: Path | None) -> list[str]:
    """Write the sky and its counts, and copy the other files of a scene; returns the names of all files.

    amc.inp is copied last, with new iterations and light source 1.
    """
    write_skydist(sky.table, folder.path / SKYDIST, bins=Bins.DEGREES, values=Values.RADIANCE)
    names = [SKYDIST, COUNTS]
    folder.write(COUNTS, counts_text(sky))
    if amc_inp is None:
        return names
    others = sorted(p for p in amc_inp.parent.glob("*.inp") if p.is_file() and p.name not in _LEFT_OUT)
    for path in others:
        with appearing(folder.path / path.name) as target, open_regular(path) as source:
            shutil.copyfileobj(source, target)
    write_amc_copy(amc_inp, folder.path / "amc.inp", sky.iterations)
    return [*names, "amc.inp", *(p.name for p in others)]


def counts_text(sky: AomcSky) -> bytes:
    """Photons that the program launches: a line for each whole degree with photons."""
    lines = ["waveband,wavelength_nm,sky_wavelength_nm,zenith_index,azimuth_index,photons"]
    for band, counts in enumerate(sky.counts):
        head = f"{band + 1},{float(sky.wavelength_nm[band])!r},{float(sky.sky_wavelength_nm[band])!r}"
        zenith, azimuth = np.nonzero(counts)
        rows = zip((zenith + 1).tolist(), azimuth.tolist(), counts[zenith, azimuth].tolist(), strict=True)
        lines += [f"{head},{z},{a},{n}" for z, a, n in rows]
    return "\n".join([*lines, ""]).encode("ascii")


def water_note(folder: RunFolder) -> str:
    """A note on files that are missing: the program opens all of them, and stops without one."""
    missing = [name for name in _PROGRAM_FILES if folder.size_of(name) is None]
    return f"the AOMC program also reads {', '.join(missing)} from the folder of skydist.inp" if missing else ""


_NEIGHBOURS = 3
"""Floats to try on each side of a first guess; more reach no other weight by the four products of the program."""

_STEPS = 24
_SCALES = 32
_PROGRAM_SCALES, _PROGRAM_EXPONENT = 256, 20


def exact_radiances(counts: np.ndarray) -> np.ndarray:
    """Radiances on whole degrees that make the AOMC program launch these photons, checked by its own rule; float32.

    Up to 1.6e7 photons, weights equal to the counts would give the counts. But the program's four products round and
    cannot reach every weight. If that matters (in patches with a quarter of the photons or more), values move by units
    of the last place. If that does not help, all values are scaled a little, which makes other weights possible. The
    search takes about 10 ms for a full table of 89 x 360, and ten times that for many scales. AllocationError if no
    values are found.
    """
    total = int(counts.sum())
    if total > MOST_PHOTONS:
        raise AllocationError(
            f"{total} photons in a band are more than the {MOST_PHOTONS} that the program can distribute"
        )
    if total == 0:
        return np.zeros(counts.shape, dtype=np.float32)
    for trial in range(_SCALES):
        radiance = _refined(counts, total, 1.0 + trial / 4096.0)
        if radiance is not None:
            return radiance
    raise AllocationError(
        "no 32-bit radiances make the AOMC program launch exactly these counts", "export another seed or photon number"
    )


def _program_radiances(mass: np.ndarray, counts: np.ndarray, iterations: int) -> np.ndarray:
    """Radiances on whole degrees that the program rounds to these photons, with their drift; float32.

    The masses of a run with ``--compat aomc`` are the program's 32-bit weights over their sum. A scale is searched that
    turns them into weights again, with the roundings of the run.
    """
    table, rows = np.zeros(counts.shape), mass.reshape(-1, counts.shape[1])[: len(counts)]
    table[: len(rows)] = rows
    for trial in range(_PROGRAM_SCALES):
        radiance = _nearest(table * np.ldexp(1.0 + trial / 4096.0, _PROGRAM_EXPONENT))
        if not table.any() or np.array_equal(allocate(aomc_weight(radiance), iterations, method="aomc"), counts):
            return radiance
    raise AllocationError(
        "no 32-bit radiances were found that the AOMC program rounds to the counts of this run; the scene's own "
        "skydist.inp gives them"
    )


def _refined(counts: np.ndarray, total: int, scale: float) -> np.ndarray | None:
    """Radiances whose weights are about `scale` times the counts, or None if none give the counts."""
    radiance = _nearest(scale * counts)
    for step in range(_STEPS):
        weight = aomc_weight(radiance)
        launched = allocate(weight, total, method=AllocationMethod.AOMC)
        wrong = launched != counts
        if not wrong.any():
            return radiance
        if step < _STEPS // 2:
            radiance = np.where(wrong, _nearest(_share(weight, counts, wrong) * counts), radiance)
            continue
        towards = np.where(launched < counts, np.float32(np.inf), np.float32(0))
        radiance = np.where(wrong, np.nextafter(radiance, towards), radiance)
    return None


def _share(weight: np.ndarray, counts: np.ndarray, wrong: np.ndarray) -> float:
    """Weight per photon that fits the program's sum after the wrong patches are corrected."""
    summed = float(np.cumsum(weight.ravel("F"))[-1])  # one after the other, as the program adds
    right_photons = float(counts[~wrong].sum())
    if right_photons == 0:
        return summed / float(counts.sum())
    return (summed - float(weight[wrong].sum(dtype=np.float64))) / right_photons


def _nearest(weight: np.ndarray) -> np.ndarray:
    """Radiances, float32, whose weights by the program's rule are nearest to these weights."""
    unit = aomc_weight(np.ones(weight.shape)).astype(np.float64)
    guess = (weight / unit).astype(np.float32)
    best, distance = guess, np.abs(aomc_weight(guess) - weight)
    for direction in (np.float32(0), np.float32(np.inf)):
        candidate = guess
        for _ in range(_NEIGHBOURS):
            candidate = np.where(weight > 0, np.nextafter(candidate, direction), candidate)
            error = np.abs(aomc_weight(candidate) - weight)
            best, distance = np.where(error < distance, candidate, best), np.minimum(error, distance)
    return best
