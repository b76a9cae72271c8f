"""A skydist.inp from which the unmodified AOMC 1.2.2 program launches exactly our photon counts, and its folder."""

from __future__ import annotations

import dataclasses
import shutil
import warnings
from collections.abc import Iterator, Sequence
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
    DegreeCounts,
    Refusal,
    degree_counts,
    degree_refusals,
    photon_refusals,
    raise_all,
    wavelength_refusals,
)
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.plan.sampling.allocation import AllocationMethod, allocate
from aomc_sky.skies.tabulated import aomc_weight
from aomc_sky.source.scene import Scene
from aomc_sky.system import open_regular
from aomc_sky.wavebands import Wavebands, midpoint_wavelength_index

INTENSITIES = "intensities.csv"
"""File of the totals of a run that amc.inp cannot hold."""

_FIRST_COLUMN, _ITERATIONS_END = 48, 60

_DRIFT = "the program's own rounding is kept: {} to {} photons in a waveband for {} iterations"


@dataclass(frozen=True, kw_only=True, slots=True)
class AomcSky:
    """What `--to aomc` writes."""

    table: SkyTable  #: radiances on whole degrees, wavelengths ascending
    iterations: int  #: line 1 of amc.inp: the photons of every waveband that has any
    #: photons that the program will launch from zenith index 1 .. 89 and azimuth index 0 ...; int64 (n_band, 89,
    #: n_azimuth)
    counts: np.ndarray
    #: of the wavebands, and of the sky that each of them takes [nm]; float64 (n_band,)
    wavelength_nm: np.ndarray
    sky_wavelength_nm: np.ndarray
    #: photons of each waveband in the run, where they differ from those that the program launches; int64 (n_band,)
    photons_of_run: np.ndarray | None = None
    notes: tuple[str, ...] = ()  #: what the user should know, a line each


def aomc_sky(
    source: PhotonSource, bands: Sequence[int] | None = None, *, scene: str = "AMC_INP", run: str = "RUN"
) -> AomcSky:
    """Turn the counts of a run into radiances for the AOMC program, checked by its own 32-bit rule.

    A run whose wavebands have different totals is planned anew with the largest of them in each, for amc.inp
    knows one. A run by the program's own rounding (``--compat aomc``) keeps its counts, whose totals drift.
    Wavebands that are not among `bands` launch nothing. `scene` and `run` are how the user would name them, for the
    command that cures a refusal: a SceneError with every reason, or an AllocationError where photons are too many or no
    radiances give the counts.
    """
    chosen = list(range(source.n_bands) if bands is None else bands)
    if source.plan.options["allocation"] == AllocationMethod.AOMC.value:
        return _as_the_program_rounds(source, chosen)
    n_photons = {band: source.n_photons(band) for band in chosen if source.n_photons(band)}
    differ = len(set(n_photons.values())) > 1
    planned = one_total(source, n_photons) if differ else source
    refusals = [*photon_refusals(n_photons), *degree_refusals(planned, chosen)]
    on_degrees = DegreeCounts(counts=planned.counts[:, :, None]) if refusals else degree_counts(planned, chosen)
    rows = _wavelength_rows(source.plan.arrays["wavelength_nm"], on_degrees.counts, chosen)
    raise_all([*refusals, *rows.refusals()], scene=scene, run=run)
    iterations = max(n_photons.values())
    photons_of_run = None
    if differ:
        photons_of_run = np.array([n_photons.get(band, 0) for band in range(source.n_bands)])
    return _sky(
        rows,
        [exact_radiances(n) for n in on_degrees.counts[rows.band_of_row]],
        on_degrees.counts[rows.band_of_row],
        chosen=chosen,
        iterations=iterations,
        photons_of_run=photons_of_run,
        notes=(on_degrees.note, _total_note(photons_of_run, iterations)),
    )


def _as_the_program_rounds(source: PhotonSource, chosen: Sequence[int]) -> AomcSky:
    """A run with ``--compat aomc``: its own iterations, from which the program rounds its counts, drift included."""
    grid = source.grid
    assert grid is not None  # the program's rounding is for one table
    shape = (source.n_bands, grid.n_zenith, grid.n_azimuth)
    of_run = np.zeros_like(source.counts)
    of_run[chosen] = source.counts[chosen]
    on_degrees = np.zeros((source.n_bands, LAST_ZENITH_DEG, grid.n_azimuth), dtype=np.int64)
    on_degrees[:, : grid.n_zenith] = of_run.reshape(shape)[:, :LAST_ZENITH_DEG]
    rows = _wavelength_rows(source.plan.arrays["wavelength_nm"], on_degrees, chosen)
    raise_all(rows.refusals())
    iterations = int(source.plan.arrays["requested"][chosen].max())
    counts = on_degrees[rows.band_of_row]
    radiances = [np.zeros(n.shape, dtype=np.float32) for n in counts]
    for k, band in enumerate(rows.band_of_row.tolist()):
        if band in chosen:
            mass = source.mass(band).reshape(shape[1:])[:LAST_ZENITH_DEG]
            radiances[k] = program_radiances(mass, counts[k], iterations)
    totals = on_degrees[chosen].sum(axis=(1, 2))
    note = "" if np.all(totals == iterations) else _DRIFT.format(totals.min(), totals.max(), iterations)
    return _sky(rows, radiances, counts, chosen=chosen, iterations=iterations, notes=(note,))


def _sky(
    rows: _Rows,
    radiances: list[np.ndarray],
    counts: np.ndarray,
    *,
    chosen: Sequence[int],
    iterations: int,
    photons_of_run: np.ndarray | None = None,
    notes: tuple[str, ...],
) -> AomcSky:
    """Put together what the program finds for each waveband; `counts` are those of the rows."""
    launched = counts[rows.row_of_band]
    return AomcSky(
        table=SkyTable(wavelength_nm=rows.wavelength_nm, radiance=np.stack(radiances).astype(np.float64)),
        iterations=iterations,
        counts=launched,
        wavelength_nm=rows.of_bands_nm,
        sky_wavelength_nm=rows.wavelength_nm[rows.row_of_band],
        photons_of_run=photons_of_run,
        notes=tuple(n for n in (*notes, *_launch_notes(launched, chosen)) if n),
    )


def one_total(source: PhotonSource, n_photons: dict[int, int]) -> PhotonSource:
    """The same sky, seed and methods with the largest of the given totals in each of these wavebands."""
    plan = source.plan
    requested = np.zeros(source.n_bands, dtype=np.int64)
    requested[list(n_photons)] = max(n_photons.values())
    scene = Scene(
        wavebands=Wavebands(wavelength_nm=plan.arrays["wavelength_nm"]),
        n_photons=requested,
        components=source.components,
        row_of_band=plan.arrays["row_of_band"],
    )
    return scene.source(plan.seed, allocation=plan.options["allocation"], method=plan.options["method"])


@dataclass(frozen=True, kw_only=True, slots=True)
class _Rows:
    """Wavelengths of the table, the waveband that each shows, and the row that the program takes for each."""

    wavelength_nm: np.ndarray
    band_of_row: np.ndarray
    row_of_band: np.ndarray
    of_bands_nm: np.ndarray
    not_their_own: list[int]

    def refusals(self) -> list[Refusal]:
        return wavelength_refusals(self.of_bands_nm, self.not_their_own)


def _wavelength_rows(wavelength_nm: np.ndarray, counts: np.ndarray, chosen: Sequence[int]) -> _Rows:
    """Ascending wavelengths that differ in 32 bits; a row shows a waveband that was asked for, if it has one.

    The program takes the first j with wavelength < (w[j] + w[j+1]) / 2, which finds every wavelength of an
    ascending table that 32-bit floats hold apart from its neighbours.
    """
    single = wavelength_nm.astype(np.float32)
    is_chosen = np.zeros(wavelength_nm.size, dtype=bool)
    is_chosen[list(chosen)] = True
    order = np.lexsort((np.arange(single.size), ~is_chosen, single))
    _, first = np.unique(single[order], return_index=True)
    band_of_row = order[first]
    table = wavelength_nm[band_of_row]
    taken = midpoint_wavelength_index(wavelength_nm, table)
    wrong = [band for band in chosen if not np.array_equal(counts[band_of_row[taken[band]]], counts[band])]
    return _Rows(
        wavelength_nm=table,
        band_of_row=band_of_row,
        row_of_band=taken,
        of_bands_nm=wavelength_nm,
        not_their_own=wrong,
    )


def _total_note(photons_of_run: np.ndarray | None, iterations: int) -> str:
    if photons_of_run is None:
        return ""
    lit = photons_of_run[photons_of_run > 0]
    return (
        f"the wavebands of the run have {lit.min()} to {lit.max()} photons, but amc.inp holds one number: each "
        f"waveband was planned again with {iterations} photons, and {INTENSITIES} holds their intensities"
    )


def _launch_notes(launched: np.ndarray, chosen: Sequence[int]) -> Iterator[str]:
    is_lit = launched.sum(axis=(1, 2)) > 0
    others = [band for band in np.flatnonzero(is_lit).tolist() if band not in chosen]
    for bands, text in (
        (others, "wavebands that have the wavelength of a chosen waveband launch the same photons"),
        (np.flatnonzero(~is_lit).tolist(), "wavebands without photons, whose sky is dark"),
    ):
        named = ", ".join(str(band + 1) for band in bands[:20]) + (" ..." if len(bands) > 20 else "")
        yield f"{text}: {named}" if bands else ""


def write_amc_copy(scene: Path, target: Path, iterations: int) -> None:
    """Copy amc.inp with other iterations [1 to 999 999 999] and the light source from a file; all else stays."""
    config = read_quietly(scene)
    lines = read_lines(scene)
    lines[0] = _with_field(lines[0], str(iterations), _ITERATIONS_END)
    lines[1] = _with_field(lines[1], str(int(LightSource.FILE)), _FIRST_COLUMN + 1)
    # characters beyond ASCII are in labels and comments, which nobody reads
    text = "".join(f"{line}\n" for line in lines).encode("ascii", "replace").decode("ascii")
    write_atomically(target, text)
    if read_quietly(target) != dataclasses.replace(config, iterations=iterations, light_source=LightSource.FILE):
        raise SceneError(
            f"{target} is not the scene that it was copied from when it is read again; write amc.inp by hand"
        )


def _with_field(line: str, value: str, end: int) -> str:
    width = end - _FIRST_COLUMN
    return f"{line[:_FIRST_COLUMN]:<{_FIRST_COLUMN}}{value:<{width}}{line[end:]}"


def read_quietly(path: Path) -> AmcConfig:
    """Read amc.inp without the warnings that the run has already given."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)
        return read_amc(path, lenient=True)


SKYDIST = "skydist.inp"
COUNTS = "counts.csv"
_LEFT_OUT = (SKYDIST, "amc.inp", "difcol.inp")
"""Files of a scene that are not copied: two are written anew, the third belongs to the program's own source."""


def check_scene(amc_inp: Path, wavelength_nm: np.ndarray) -> None:
    """Raise unless the lambbot.inp beside amc.inp has the wavebands of the run. [nm]"""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)  # the run has reported them
        of_scene = read_lambbot(amc_inp.parent / "lambbot.inp", lenient=True).wavelength_nm
    if not np.array_equal(of_scene, wavelength_nm):
        raise SceneError(
            f"{amc_inp.parent / 'lambbot.inp'} has {of_scene.size} wavebands that are not the {wavelength_nm.size} of "
            "the run; name the scene that was run"
        )


def write_aomc_folder(sky: AomcSky, folder: RunFolder, amc_inp: Path | None) -> list[str]:
    """Write the sky and its counts, and with a scene all files beside it; return the names of the files.

    amc.inp is copied last, with the new iterations and light source 1; every other ``.inp`` file beside it
    as it is, except skydist.inp and difcol.inp.
    """
    write_skydist(sky.table, folder.path / SKYDIST, bins=Bins.DEGREES, values=Values.RADIANCE)
    names = [SKYDIST, COUNTS]
    folder.write(COUNTS, counts_text(sky))
    if sky.photons_of_run is not None:
        folder.write(INTENSITIES, intensities_text(sky, sky.photons_of_run))
        names.append(INTENSITIES)
    if amc_inp is None:
        return names
    others = sorted(p for p in amc_inp.parent.glob("*.inp") if p.is_file() and p.name not in _LEFT_OUT)
    for path in others:
        with folder.stream(path.name) as target, open_regular(path) as source:
            shutil.copyfileobj(source, target)
    write_amc_copy(amc_inp, folder.path / "amc.inp", sky.iterations)
    return [*names, "amc.inp", *(p.name for p in others)]


def counts_text(sky: AomcSky) -> bytes:
    """Photons that the program launches from each whole degree, a line for each that has any."""
    lines = ["waveband,wavelength_nm,sky_wavelength_nm,zenith_index,azimuth_index,photons"]
    for band, counts in enumerate(sky.counts):
        head = f"{band + 1},{float(sky.wavelength_nm[band])!r},{float(sky.sky_wavelength_nm[band])!r}"
        zenith, azimuth = np.nonzero(counts)
        rows = zip((zenith + 1).tolist(), azimuth.tolist(), counts[zenith, azimuth].tolist(), strict=True)
        lines += [f"{head},{z},{a},{n}" for z, a, n in rows]
    return "\n".join([*lines, ""]).encode("ascii")


def intensities_text(sky: AomcSky, photons_of_run: np.ndarray) -> bytes:
    """What a waveband's photons stand for: those of the run over those that the program launches."""
    lines = ["waveband,wavelength_nm,intensity,photons_of_the_run,photons_launched"]
    launched = sky.counts.sum(axis=(1, 2)).tolist()
    for band, (n_run, n_launched) in enumerate(zip(photons_of_run.tolist(), launched, strict=True)):
        intensity = n_run / n_launched if n_launched else 0.0
        lines.append(f"{band + 1},{float(sky.wavelength_nm[band])!r},{intensity!r},{n_run},{n_launched}")
    return "\n".join([*lines, ""]).encode("ascii")


def water_note(folder: RunFolder) -> str:
    """Which files of the water the program will look for in vain, with their rows; empty where all are there.

    The program opens all four whatever amc.inp says, and stops where the first number of one differs from amc.inp.
    """
    if folder.size_of("amc.inp") is None:
        return (
            "the AOMC program also reads amc.inp, lambbot.inp and the files of the water (conc.inp, abs.inp, scat.inp, "
            "spf.inp) from the folder of skydist.inp"
        )
    config = read_quietly(folder.path / "amc.inp")
    rows = {
        "conc.inp": config.n_concentration_layers,
        "abs.inp": config.n_wavebands,
        "scat.inp": config.n_wavebands,
        "spf.inp": config.n_spf_angles,
    }
    missing = [f"{name} ({n} row{'s' if n != 1 else ''})" for name, n in rows.items() if folder.size_of(name) is None]
    if not missing:
        return ""
    return (
        "the AOMC program still needs files of the water, which are not in the folder of the scene: "
        f"{', '.join(missing)}, for {config.n_constituents} constituent{'s' if config.n_constituents != 1 else ''}"
    )


_NEIGHBOURS = 3
"""Floats on each side of a first guess among which the four products of the program reach every weight they can."""

_STEPS = 24
_SCALES = 32
_PROGRAM_SCALES, _PROGRAM_EXPONENT = 256, 20


def exact_radiances(counts: np.ndarray) -> np.ndarray:
    """Radiances on whole degrees that make the AOMC program launch these photons, checked by its own rule; float32.

    Weights equal to the counts would do, since up to 1.6e7 photons the program's share of a total is good to
    half a photon; but its four products round, and cannot reach every weight. Where that matters (patches
    with a quarter of the photons and more), values move by units of the last place, and where no such move
    helps, all values are scaled a little, which changes which weights can be reached: about 10 ms for a full table
    of 89 x 360, ten times that where many scales are tried. AllocationError where no values were found.
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
        "no 32-bit radiances make the AOMC program launch exactly these counts; export another seed or photon number"
    )


def program_radiances(mass: np.ndarray, counts: np.ndarray, iterations: int) -> np.ndarray:
    """Radiances on whole degrees from which the program rounds these masses to these photons, drift included; float32.

    The masses of a run with ``--compat aomc`` are the program's 32-bit weights over their sum. Multiplied by
    some number they are weights again, to a rounding; the scale is chosen so that all roundings fall as in the run.
    AllocationError where none does. `mass` (n_zenith, n_azimuth) begins at zenith index 1 and has at most 89 rows,
    `counts` has 89.
    """
    table = np.zeros(counts.shape)
    table[: len(mass)] = mass
    if not table.any():
        return np.zeros(counts.shape, dtype=np.float32)
    for trial in range(_PROGRAM_SCALES):
        radiance = _nearest(table * np.ldexp(1.0 + trial / 4096.0, _PROGRAM_EXPONENT))
        if np.array_equal(allocate(aomc_weight(radiance), iterations, method=AllocationMethod.AOMC), counts):
            return radiance
    raise AllocationError(
        "no 32-bit radiances were found that the AOMC program rounds to the counts of this run; the scene's own "
        "skydist.inp gives them"
    )


def _refined(counts: np.ndarray, total: int, scale: float) -> np.ndarray | None:
    """Values of about `scale` times the counts as weights, or None where these counts cannot be had so."""
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
    """Weight of a photon that fits the program's sum once the wrong patches have it too."""
    summed = float(np.cumsum(weight.ravel("F"))[-1])  # one after the other, as the program adds
    right_photons = float(counts[~wrong].sum())
    if right_photons == 0:
        return summed / float(counts.sum())
    return (summed - float(weight[wrong].sum(dtype=np.float64))) / right_photons


def _nearest(weight: np.ndarray) -> np.ndarray:
    """Radiances, float32, whose weights under the program's rule are nearest to the given ones."""
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
