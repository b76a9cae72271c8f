"""Photons that another code made: their files, the origin that a file states, and tests against a scene."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from aomc_sky.directions import Frame
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.errors import UsageError
from aomc_sky.formats.mcpl.header import McplHeader, McplRuns, names_runs, runs_of
from aomc_sky.kernels.backend import announce_photons
from aomc_sky.outputs.photon_formats import PHOTON_FORMATS, photon_writer
from aomc_sky.outputs.photons.files import PhotonFile, PhotonRows, PhotonWriter
from aomc_sky.outputs.photons.mcpl import McplWriter
from aomc_sky.plan.options import MethodWord, PrecisionWord
from aomc_sky.source.scene import Scene
from aomc_sky.verify.counts import FAMILY_LEVEL
from aomc_sky.verify.directions import Dependence, verify_directions
from aomc_sky.verify.report import Check, VerifyReport

_PACKED = {"float32": 6e-7, "float64": 1.4e-15}
"""Largest change of a component by packing (docs/formats/mcpl.md)."""


def open_photons(
    path: str | Path,
    wavelength_nm: np.ndarray,
    *,
    wavebands: Sequence[int] | None = None,
    weights: str | Path | None = None,
) -> PhotonFile:
    """Open a file of photons; the format follows from its ending, and is MCPL for unknown endings.

    `weights` is a file with the weights of a ``.npy`` file. `wavebands` are 1-based. UsageError if the waveband does
    not exist, or if neither the file nor the user gives it.
    """
    n_bands, bands = wavelength_nm.size, tuple(dict.fromkeys(waveband - 1 for waveband in wavebands or ()))
    for band in bands:
        if not 0 <= band < n_bands:
            raise UsageError(f"waveband {band + 1} is not in this scene; it has wavebands 1 to {n_bands}")
    ending, writers = Path(path).suffix.lower(), map(photon_writer, PHOTON_FORMATS)
    fitting = (writer for writer in writers if Path(writer.names[0]).suffix == ending)
    writer: type[PhotonWriter] = next(fitting, photon_writer("mcpl"))
    return writer.read(Path(path), wavelength_nm, bands, weights)


@dataclass(frozen=True, kw_only=True, slots=True)
class Origin:
    """The origin of photons, from the head of their file."""

    dependence: Dependence = Dependence.INDEPENDENT  #: how the photons depend on each other
    plan: PhotonSource | None = None  #: the source of exactly these photons, if the scene gives it
    notes: tuple[str, ...] = ()


_TESTED = {
    Dependence.INDEPENDENT: "photons are tested as independent ones",
    Dependence.STRATIFIED: "photons are tested as stratified ones",
    Dependence.MIXED: "photons may be spread evenly or not; only a spread that is too uneven fails",
}


def origin_of(photons: PhotonFile, scene: Scene, *, own_numbers: bool = False) -> Origin:
    """The origin of a file of photons; unless `own_numbers`, a scene may take its numbers of photons from the file."""
    header = photons.header
    if header is None or not names_runs(header):
        return Origin()
    runs, dependence, plan = runs_of(header), Dependence.MIXED, None
    if runs is None:
        note = "the header names runs of aomc-sky, but not which part of them is in the file"
    else:
        named = "one run" if runs.n_runs == 1 else f"{runs.n_runs} runs"
        note = f"the header names {named} of aomc-sky"
        if runs.n_photons != header.n_particles:
            note += f" and {runs.n_photons} photons, the file holds {header.n_particles}"
        else:
            dependence, plan = _dependence(runs), _plan_of(photons, header, runs, scene, own_numbers)
            note += "; its plan is not the plan of this scene" if runs.plan and plan is None else ""
        if plan is not None:
            note += f", seed {runs.seed}, and its plan is the plan of this scene: every photon is compared with it"
            return Origin(dependence=Dependence.PLAN, plan=plan, notes=(note,))
    return Origin(dependence=dependence, notes=(f"{note}: {_TESTED[dependence]}",))


def _dependence(runs: McplRuns) -> Dependence:
    if runs.n_iid == runs.n_photons:
        return Dependence.INDEPENDENT
    return Dependence.STRATIFIED if runs.n_stratified == runs.n_photons else Dependence.MIXED


def _plan_of(
    photons: PhotonFile, header: McplHeader, runs: McplRuns, scene: Scene, own_numbers: bool
) -> PhotonSource | None:
    """The source with the plan of the head, made from the scene with the head's seed and precision."""
    seed = runs.seed
    if seed is None:
        return None
    method: MethodWord | None = "iid" if _dependence(runs) is Dependence.INDEPENDENT else None
    precision: PrecisionWord = "float64" if header.is_double else "float32"
    for numbers in (scene.n_photons, *(() if own_numbers else _numbers_of(photons, scene.n_photons.size))):
        changed = replace(scene, n_photons=numbers)
        source = changed.source(seed, method=method, precision=precision, weights=header.weight == 0.0)
        if runs.is_plan(source.plan.sha256):
            return source
    return None


def _numbers_of(photons: PhotonFile, n_bands: int) -> Iterator[np.ndarray]:
    """Possible photons of each waveband in the run of a file, which may hold only some of its bands."""
    numbers = np.zeros(n_bands, np.int64)
    numbers[list(photons.n_of)] = list(photons.n_of.values())
    yield numbers
    for size in {*photons.n_of.values(), photons.header.n_particles // n_bands if photons.header else 0}:
        yield np.full(n_bands, size)


def verify_photons(
    source: PhotonSource,
    photons: PhotonFile,
    origin: Origin,
    *,
    frame: Frame = Frame.UP,
    family_level: float = FAMILY_LEVEL,
    seed: int = 0,
    threads: int = 0,
) -> VerifyReport:
    """Test photons against the masses of a scene's sky.

    If `origin` has a plan, every photon is compared with that of the plan. Other arguments are those of
    `verify_directions`.
    """
    again, numbers = {}, []
    if origin.plan is not None:
        writer, n_of = McplWriter(origin.plan), photons.n_of  # only an MCPL file names its plan
        numbers = [_number_check(origin.plan, band, n_of.get(band, 0)) for band in range(origin.plan.n_bands)]
        again = {band: MadeAgain(origin.plan, band, writer) for band in photons.rows if numbers[band].passed}
    rows = {band: again[band].compared(own()) if band in again else own() for band, own in photons.rows.items()}
    report = verify_directions(
        origin.plan or source,
        rows,
        dependence=origin.dependence,
        frame=frame,
        family_level=family_level,
        seed=seed,
        threads=threads,
    )
    wrong = [check for check in numbers if not check.passed]
    checks = (*wrong, *(made.check() for made in again.values()), *report.checks)
    columns = [f"compared with the plan: {made.columns}" for made in list(again.values())[:1]]
    notes = (*photons.notes, *origin.notes, *columns, *report.notes, *_too_even(report))
    return replace(report, checks=checks, notes=notes)


def _number_check(plan: PhotonSource, band: int, n: int) -> Check:
    expected = plan.n_photons(band)
    detail = f"{n} photons have its energy, the plan has {expected}; an energy or a kind of particle was changed"
    return Check(name="numbers of photons", waveband=band + 1, passed=n == expected, detail=detail)


class MadeAgain:
    """The photons of a waveband of a plan, made again and compared with those of a file in all its columns."""

    def __init__(self, source: PhotonSource, band: int, writer: PhotonWriter) -> None:
        self._source, self._band, self._writer = source, band, writer
        self._n, self._n_wrong, self._first = 0, 0, -1
        self._differs: dict[str, bool] = {}  #: Columns that were compared, and whether any photon differs in them.
        announce_photons(source.n_photons(band))

    def compared(self, blocks: Iterable[PhotonRows]) -> Iterator[PhotonRows]:
        """The same blocks, compared on the way."""
        tolerance = _PACKED[self._source.dtype.name]
        for rows in blocks:
            batch = self._source.photons(self._band, rows.start, rows.start + len(rows.direction))
            is_right = {"direction": np.all(np.abs(rows.direction - batch.directions) <= tolerance, axis=1)}
            weight = np.ones(len(batch)) if batch.weight is None else batch.weight
            expected = {"weight": weight, **self._writer.others(batch)}
            found = {"weight": weight if rows.weight is None else rows.weight, **rows.others}
            for name in found:
                is_equal = np.asarray(found[name] == expected[name])
                is_right[name] = is_equal.all(axis=1) if is_equal.ndim == 2 else is_equal
            for name, is_right_column in is_right.items():
                self._differs[name] = self._differs.get(name, False) or not is_right_column.all()
            wrong = np.flatnonzero(~np.all(list(is_right.values()), axis=0))
            if wrong.size and self._first < 0:
                self._first = rows.start + int(wrong[0])
            self._n, self._n_wrong = self._n + len(batch), self._n_wrong + wrong.size
            yield rows

    @property
    def columns(self) -> str:
        """Names of what was compared, after all blocks."""
        return ", ".join(self._differs)

    def check(self) -> Check:
        """The check, after all blocks."""
        detail = f"all {self._n} photons agree with the plan"
        if self._n_wrong:
            wrong = " and ".join(name for name, is_wrong in self._differs.items() if is_wrong)
            detail = f"{self._n_wrong} of {self._n} photons differ from the plan in {wrong}; "
            detail += f"the first is photon {self._first}"
        return Check(
            name="photons made again",
            waveband=self._band + 1,
            passed=self._n_wrong == 0,
            found=float(self._n_wrong),
            allowed=0.0,
            detail=detail,
        )


def _too_even(report: VerifyReport) -> list[str]:
    """Advice if tests for independent photons failed because the photons are too even."""
    even = [check for check in report.checks if check.is_even and not check.passed]
    if not even:
        return []
    worst = min(even, key=lambda check: (check.p_value or 0.0, check.found or 0.0))
    return [
        f"{len(even)} tests failed because the photons are spread more evenly than independent photons can be "
        f"({worst.name} of waveband {worst.waveband}: {worst.detail}); if their sampler is stratified or uses "
        "low-discrepancy numbers, write --method stratified"
    ]
