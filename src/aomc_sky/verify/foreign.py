"""Photons that another code made, tested against the sky of a scene."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from aomc_sky.directions import Frame
from aomc_sky.errors import UsageError
from aomc_sky.formats.mcpl.file import McplFile, read_mcpl
from aomc_sky.formats.mcpl.header import McplHeader, McplRuns, names_runs, runs_of
from aomc_sky.formats.photons_npy import PhotonsNpy, read_photons_npy
from aomc_sky.formats.text_file import refuse
from aomc_sky.kernels.backend import announce_photons
from aomc_sky.outputs.photons.mcpl import MEV_NM, PHOTON
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.scene import Scene
from aomc_sky.verify.counts import FAMILY_LEVEL
from aomc_sky.verify.report import Check, Pulls, VerifyReport, judged
from aomc_sky.verify.sky.direction_counts import PhotonRows
from aomc_sky.verify.sky.directions import DirectionTests, Tied

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
    #: Photons of each of these wavebands, where their energies differ.
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
        raise UsageError("--weights is for a .npy file; an MCPL file holds its own weights")
    return _open_mcpl(path, bands, wavelength_nm)


def _checked(waveband: int, n_bands: int) -> int:
    if not 1 <= waveband <= n_bands:
        raise UsageError(f"waveband {waveband} is not in this scene; it has wavebands 1 to {n_bands}")
    return waveband - 1


def _open_npy(path: Path, bands: tuple[int, ...] | None, n_bands: int, weights: str | Path | None) -> PhotonFile:
    photons = read_photons_npy(path)
    if bands is None and n_bands > 1:
        raise UsageError(f"the scene has {n_bands} wavebands: name the waveband of the photons with --waveband")
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
        notes.append(f"{len(file) - n_photons} of {len(file)} particles are not photons and were left out")
    if not found.any():
        if bands is None and wavelength_nm.size > 1:
            raise UsageError(
                f"no photon of {path} has the energy of a waveband of the scene: name their waveband with --waveband"
            )
        if bands is not None and len(bands) > 1:
            raise UsageError(f"no photon of {path} has the energy of a waveband: give one --waveband for all")
        notes.append("no photon has the energy of a waveband: all photons are used")
        return PhotonFile(path=path, bands=bands or (0,), notes=tuple(notes), header=file.header, _mcpl=file)
    chosen = bands if bands is not None else tuple(np.flatnonzero(found).tolist())
    left = n_photons - int(found[list(chosen)].sum())
    if left > 0:
        notes.append(f"{left} of {n_photons} photons belong to other wavebands, or to none, and were left out")
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


SceneOf = Callable[[int], Scene | None]
"""The scene read again with so many photons per waveband; None where the user has settled the number."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Origin:
    """What a file says of itself."""

    #: How its photons are tied together; `Tied.INDEPENDENT` of an unknown one.
    tied: Tied = Tied.INDEPENDENT
    #: The source of exactly these photons, where the scene gives it.
    plan: PhotonSource | None = None
    #: For a person.
    notes: tuple[str, ...] = ()


def origin_of(photons: PhotonFile, scene: Scene, scene_of: SceneOf) -> Origin:
    """Read the head of a file of photons; `scene_of` gives the scene with the number of photons that the file has."""
    header = photons.header
    runs = None if header is None else runs_of(header)
    if header is None or not names_runs(header):
        return Origin()
    if runs is None:
        note = f"the header names runs of aomc-sky, but not which part of them is in the file: {_TESTED[Tied.MIXED]}"
        return Origin(tied=Tied.MIXED, notes=(note,))
    named = (
        "the header names one run of aomc-sky"
        if runs.n_runs == 1
        else f"the header names {runs.n_runs} runs of aomc-sky"
    )
    if runs.n_photons != header.n_particles:
        note = f"{named} and {runs.n_photons} photons, the file holds {header.n_particles}: {_TESTED[Tied.MIXED]}"
        return Origin(tied=Tied.MIXED, notes=(note,))
    tied = _tied(runs)
    plan = _plan_of(photons, header, runs, scene, scene_of)
    if plan is not None:
        note = f"{named}, seed {runs.seed}, and its plan is the plan of this scene: every photon is compared with it"
        return Origin(tied=Tied.PLAN, plan=plan, notes=(note,))
    unlike = "; its plan is not the plan of this scene" if runs.plan else ""
    return Origin(tied=tied, notes=(f"{named}{unlike}: {_TESTED[tied]}",))


_TESTED = {
    Tied.INDEPENDENT: "photons are tested as independent ones",
    Tied.STRATIFIED: "photons are tested as stratified ones",
    Tied.MIXED: "photons may be spread evenly or not; only a spread that is too uneven fails",
}


def _tied(runs: McplRuns) -> Tied:
    if runs.n_iid == runs.n_photons:
        return Tied.INDEPENDENT
    return Tied.STRATIFIED if runs.n_stratified == runs.n_photons else Tied.MIXED


def _plan_of(
    photons: PhotonFile, header: McplHeader, runs: McplRuns, scene: Scene, scene_of: SceneOf
) -> PhotonSource | None:
    """The source that the plan in the head belongs to, made of the scene with the head's seed and precision."""
    if runs.seed is None:
        return None
    source = _source(scene, header, runs)
    numbers = set(photons.n_of.values())
    if (
        not runs.is_plan(source.plan.sha256)
        and len(numbers) == 1
        and (same_size := scene_of(numbers.pop())) is not None
    ):
        source = _source(same_size, header, runs)
    is_plan = runs.is_plan(source.plan.sha256) and photons.n_of
    return source if is_plan and all(source.n_photons(b) == n for b, n in photons.n_of.items()) else None


def _source(scene: Scene, header: McplHeader, runs: McplRuns) -> PhotonSource:
    assert runs.seed is not None
    return scene.source(
        runs.seed,
        method="iid" if _tied(runs) is Tied.INDEPENDENT else None,
        precision="float64" if header.is_double else "float32",
        weights=header.weight == 0.0,
    )


_PACKED = {"float32": 6e-7, "float64": 1.4e-15}
"""What packing may change a component by (docs/formats/mcpl.md)."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PhotonTestOptions:
    """How photons of another code are tested."""

    #: `Tied.INDEPENDENT`, or `Tied.STRATIFIED` for photons that are spread more evenly than chance.
    tied: Tied = Tied.INDEPENDENT
    #: Which way z grows in their directions.
    frame: Frame = Frame.UP
    #: Chance that correct photons fail any test. [above 0, below 1]
    family_level: float = FAMILY_LEVEL
    #: Of the thinning of stratified photons. [0 to 2^64 - 1]
    seed: int = 0
    #: 0 for one per CPU.
    threads: int = 0


def verify_photons(
    source: PhotonSource, photons: PhotonFile, options: PhotonTestOptions, origin: Origin | None = None
) -> VerifyReport:
    """Test photons against the sky of a scene, whose masses count, not its photons.

    Of each waveband of the file: exact checks of every direction, zones of mu^2, of azimuth and of both, and positions
    inside patches. The plan of `origin`, what the file says of itself, takes the place of `source`, its `tied` that of
    the options.
    """
    known = Origin(tied=options.tied) if origin is None else origin
    tests = DirectionTests(
        known.plan or source, tied=known.tied, frame=options.frame, seed=options.seed, threads=options.threads
    )
    checks: list[Check] = []
    pulls: list[Pulls] = []
    for band in photons.bands:
        again = None if known.plan is None else MadeAgain(known.plan, band)
        rows = photons.rows(band) if again is None else again.compared(photons.rows(band))
        of_band, found = tests.checks(band, rows)
        checks += of_band if again is None else [again.check(), *of_band]
        pulls += [found] if found is not None else []
    notes = [*photons.notes, *known.notes, *tests.notes]
    report = judged(checks, family_level=options.family_level, notes=notes, pulls=pulls)
    return replace(report, notes=(*report.notes, *_too_even(report)))


class MadeAgain:
    """The photons of a waveband of a plan, made again and compared with those of a file."""

    def __init__(self, source: PhotonSource, band: int) -> None:
        self._source, self._band = source, band
        self._n, self._n_wrong, self._first = 0, 0, -1
        announce_photons(source.n_photons(band))

    def compared(self, blocks: Iterable[PhotonRows]) -> Iterator[PhotonRows]:
        """The same blocks, compared on the way."""
        tolerance = _PACKED[self._source.dtype.name]
        for rows in blocks:
            expected = self._source.photons(self._band, rows.start, rows.start + len(rows.direction)).directions
            is_right = np.all(np.abs(rows.direction - expected) <= tolerance, axis=1)
            wrong = np.flatnonzero(~is_right)
            if wrong.size and self._first < 0:
                self._first = rows.start + int(wrong[0])
            self._n, self._n_wrong = self._n + len(is_right), self._n_wrong + wrong.size
            yield rows

    def check(self) -> Check:
        """What was found, after all blocks."""
        detail = f"all {self._n} photons agree with the plan"
        if self._n_wrong:
            detail = f"{self._n_wrong} of {self._n} photons differ from the plan; the first is photon {self._first}"
        return Check(
            name="photons made again",
            waveband=self._band + 1,
            passed=self._n_wrong == 0,
            found=float(self._n_wrong),
            allowed=0.0,
            detail=detail,
        )


def _too_even(report: VerifyReport) -> list[str]:
    """A sentence where tests for independent photons failed only from below."""
    even = [check for check in report.checks if check.is_even and not check.passed]
    if not even:
        return []
    worst = min(even, key=lambda check: (check.p_value or 0.0, check.found or 0.0))
    band = "" if worst.waveband is None else f" of waveband {worst.waveband}"
    return [
        f"{len(even)} tests failed because the photons are spread more evenly than independent photons can be "
        f"({worst.name}{band}: {worst.detail}); if their sampler is stratified or uses low-discrepancy numbers, write "
        "--method stratified"
    ]
