"""Where an MCPL file says that its photons come from, and what that settles: the tests, and whether a plan is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from aomc_sky.formats.mcpl.header import McplHeader, McplRuns, names_runs, runs_of
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.scene import Scene
from aomc_sky.verify.foreign.photon_file import PhotonFile
from aomc_sky.verify.sky.directions import Tied

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
        note = f"the head comes from runs of aomc-sky and does not say which part the file holds: {_TESTED[Tied.MIXED]}"
        return Origin(tied=Tied.MIXED, notes=(note,))
    named = (
        "the head names one run of aomc-sky" if runs.n_runs == 1 else f"the head names {runs.n_runs} runs of aomc-sky"
    )
    if runs.n_photons != header.n_particles:
        note = f"{named} and {runs.n_photons} photons, the file holds {header.n_particles}: {_TESTED[Tied.MIXED]}"
        return Origin(tied=Tied.MIXED, notes=(note,))
    tied = _tied(runs)
    plan = _plan_of(photons, header, runs, scene, scene_of)
    if plan is not None:
        note = f"{named}, seed {runs.seed}, whose plan is that of this scene: every photon is compared with it"
        return Origin(tied=Tied.PLAN, plan=plan, notes=(note,))
    unlike = "; its plan is not that of the scene as it is read here" if runs.plan else ""
    return Origin(tied=tied, notes=(f"{named}{unlike}: {_TESTED[tied]}",))


_TESTED = {
    Tied.INDEPENDENT: "photons are tested as independent ones",
    Tied.STRATIFIED: "photons are tested as stratified ones",
    Tied.MIXED: "photons may be spread evenly or not, and only too uneven ones fail",
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
    if not runs.is_plan(source.plan.sha256) and len(numbers) == 1 and (more := scene_of(numbers.pop())) is not None:
        source = _source(more, header, runs)
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
