"""Photon counts on whole degrees, the only directions in the AOMC program's sky file, or reasons against them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from aomc_sky.component import Component, Law, beam_direction_deg, cells_of_grid
from aomc_sky.directions import sin_cos_deg
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.errors import AllocationError, SceneError
from aomc_sky.grid import PatchGrid
from aomc_sky.plan.laws import law_of
from aomc_sky.plan.sampling.allocation import AllocationMethod
from aomc_sky.source.scene import Scene
from aomc_sky.wavebands import Wavebands

LAST_ZENITH_DEG = 89

MOST_PHOTONS = 16_000_000
"""Most photons of a band for which 32-bit floats can hold every share of the total (below 2^24)."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Refusal:
    """A reason, and a remedy: options of `run`, options of `export`, or something to do by hand."""

    reason: str
    run: str = ""
    export: str = ""
    by_hand: str = ""
    is_allocation: bool = False


def raise_all(refusals: Sequence[Refusal], *, scene: str = "AMC_INP", run: str = "RUN") -> None:
    """Raise one error with all reasons, if there are any; `scene` and `run` are the names that the user knows."""
    if not refusals:
        return
    reasons = [refusal.reason for refusal in refusals]
    text = reasons[0] if len(reasons) == 1 else "; ".join(f"({k}) {r}" for k, r in enumerate(reasons, start=1))
    text += f". Solution: {_solution(refusals, scene, run)}"
    error = AllocationError if all(refusal.is_allocation for refusal in refusals) else SceneError
    raise error(text)


def _solution(refusals: Sequence[Refusal], scene: str, run: str) -> str:
    by_hand, again, export = (
        list(dict.fromkeys(filter(None, words)))  # each once, in order
        for words in zip(*((r.by_hand, r.run, r.export) for r in refusals), strict=True)
    )
    steps = list(by_hand)
    if again or (by_hand and not export):
        options = "".join(f" {words}" for words in again)
        steps.append(f"aomc-sky run {scene}{options} --out NEW, with the other options of this run")
    if export or again or by_hand:
        options = "".join(f" {words}" for words in export)
        steps.append(f"aomc-sky export {'NEW' if again or by_hand else run} --to aomc{options}")
    return "; then ".join(steps)


def photon_refusals(n_photons: dict[int, int]) -> list[Refusal]:
    """Refuse no photons at all, and too many; `n_photons` of each waveband that has any. [0-based]"""
    if not n_photons:
        reason = "no waveband of this run has photons, so there is nothing to export"
        return [Refusal(reason=reason, run="--iterations 1000000")]
    band, most = max(n_photons.items(), key=lambda item: item[1])
    if most <= MOST_PHOTONS:
        return []
    reason = f"waveband {band + 1} has {most} photons; the AOMC program counts in 32-bit floats, which are exact up to "
    reason += f"{MOST_PHOTONS} photons per waveband"
    return [Refusal(reason=reason, run=f"--iterations {MOST_PHOTONS}", is_allocation=True)]


def whole_degree(component: Component) -> tuple[int, int] | None:
    """Zenith angle and azimuth of a beam from whole degrees, or None for other components."""
    direction = beam_direction_deg(component)
    if direction is None or component.law is not Law.BEAM:
        return None
    zenith, azimuth = (round(angle) for angle in direction)
    is_there = 1 <= zenith <= LAST_ZENITH_DEG and np.allclose(direction, (zenith, azimuth), rtol=0, atol=1e-9)
    return (zenith, azimuth % 360) if is_there else None


def _beam_refusal(component: Component, n_photons: int) -> Refusal:
    direction = beam_direction_deg(component)
    where, options = "", ""
    if direction is not None:
        where = f" from zenith angle {direction[0]:g}, azimuth {direction[1]:g} degrees"
        zenith, azimuth = min(max(round(direction[0]), 1), LAST_ZENITH_DEG), round(direction[1]) % 360
        if not np.allclose(direction, (zenith, azimuth), rtol=0, atol=1e-9):
            options = f"--sun-zenith {zenith} --sun-azimuth {azimuth}"
    if component.law in (Law.DISC, Law.DISC_AT_HORIZON):
        where += ", with the disc of the sun"
    return Refusal(
        reason=f"component {component.name!r} (law {component.law.name}) sends {n_photons} photons{where}; the AOMC "
        "program's sky file holds only zenith angles of 1, 2 .. 89 degrees and whole azimuths",
        run=options,
        by_hand=law_of(component.law).leave_out,
    )


def wavelength_refusals(wavelength_nm: np.ndarray, bands: Iterable[int]) -> list[Refusal]:
    """Refuse wavebands [0-based] that would not find their own sky."""
    single, refusals = wavelength_nm.astype(np.float32), []
    for band in bands:
        named = f"waveband {band + 1} at {wavelength_nm[band]:.9g} nm"
        if np.count_nonzero(single == single[band]) > 1:
            reason = f"{named} has the same wavelength as another one and different counts; the AOMC program chooses a "
            refusals.append(Refusal(reason=f"{reason}sky by its wavelength", export=f"--waveband {band + 1}"))
        else:
            reason = f"{named} is too close to another one for the AOMC program's 32-bit floats to choose its own sky"
            by_hand = "give the wavebands of lambbot.inp wavelengths at least 0.001 nm apart"
            refusals.append(Refusal(reason=reason, by_hand=by_hand))
    return refusals


_N_ZENITH, _N_AZIMUTH = 89, 360

_SHARED_OUT = (
    "the patches of the run are not whole degrees, so its photons were distributed again over patches of one degree"
)


@dataclass(frozen=True, kw_only=True, slots=True)
class DegreeCounts:
    """Photons of each whole degree."""

    counts: np.ndarray  #: from zenith index 1, 0 for bands that are not chosen; int64 (n_band, 89, n_azimuth)
    note: str = ""  #: a line for the user if the run's own patches are not whole degrees


def degree_counts(source: PhotonSource, bands: Sequence[int]) -> DegreeCounts:
    """Photons of a run on whole degrees, as many in each band as the run has.

    A run on whole degrees (``--bins degrees``, or ``--compat aomc``) and a beam from a whole degree keep their counts.
    Other masses are carried over to cells of one degree, and shared out with the run's method and seed. The
    masses of a Perez sky are carried over by its own law, others by the law inside their patches. SceneError for the
    reasons of `degree_refusals`.
    """
    raise_all(degree_refusals(source, bands))
    parts = _parts(source, bands)
    patches = [(c, part) for c, part in parts if part.any() and c.grid is not None]
    tables = [_beam_table(c, part) for c, part in parts if part.any() and c.grid is None]
    note = ""
    if all(_is_on_degrees(c.grid) for c, _ in patches):
        tables += [_patch_table(c, part) for c, part in patches]
    else:
        n_photons = np.sum([part.sum(axis=1) for _, part in patches], axis=0)
        new = _shared_out_anew(source, [c for c, _ in patches], n_photons)
        tables.append(new.reshape(source.n_bands, _N_ZENITH, _N_AZIMUTH))
        note = _SHARED_OUT
    total = np.zeros((source.n_bands, _N_ZENITH, max((t.shape[2] for t in tables), default=1)), dtype=np.int64)
    for table in tables:
        total[:, :, : table.shape[2]] += table
    return DegreeCounts(counts=total, note=note)


def _beam_table(component: Component, counts: np.ndarray) -> np.ndarray:
    """Counts of a beam from a whole degree."""
    degree = whole_degree(component)
    assert degree is not None  # `degree_refusals` has looked
    table = np.zeros((len(counts), _N_ZENITH, _N_AZIMUTH), dtype=np.int64)
    table[:, degree[0] - 1, degree[1]] = counts[:, 0]
    return table


def degree_refusals(source: PhotonSource, bands: Sequence[int]) -> list[Refusal]:
    """All reasons why light of a run cannot be put on whole degrees."""
    lit = [(component, part) for component, part in _parts(source, bands) if part.any()]
    refusals = [
        _beam_refusal(component, int(part.sum()))
        for component, part in lit
        if component.grid is None and whole_degree(component) is None
    ]
    if not all(_is_on_degrees(c.grid) for c, _ in lit if c.grid is not None):
        refusals += [
            Refusal(
                reason=f"component {c.name!r} covers a part of the hemisphere, and its law does not say which part "
                "of a degree",
                by_hand="give it a grid of the whole hemisphere",
            )
            for c, _ in lit
            if law_of(c.law).flux is not None
            and c.slope is None
            and c.grid is not None
            and abs(c.grid.solid_angle_sr.sum() - 2 * np.pi) > 1e-9
        ]
    return refusals


def _parts(source: PhotonSource, bands: Sequence[int]) -> list[tuple[Component, np.ndarray]]:
    """The components with their counts, 0 for bands that are not chosen."""
    counts = np.zeros_like(source.counts)
    counts[list(bands)] = source.counts[list(bands)]
    first = source.plan.arrays["component_start"]
    return [(c, counts[:, first[k] : first[k + 1]]) for k, c in enumerate(source.components)]


def _is_on_degrees(grid: PatchGrid | None) -> bool:
    """Whether the patches are cells around whole degrees, or the points themselves."""
    if grid is None:
        return False
    return any(
        np.array_equal(grid.zenith_bounds_deg, known.zenith_bounds_deg)
        and np.array_equal(grid.azimuth_bounds_deg, known.azimuth_bounds_deg)
        for known in (PatchGrid.whole_degrees(), PatchGrid.lattice(grid.n_zenith, grid.n_azimuth))
    )


def _patch_table(component: Component, part: np.ndarray) -> np.ndarray:
    """Counts of a component on whole degrees, (n_band, 89, n_azimuth)."""
    grid = component.grid
    assert grid is not None
    counts = part.reshape(len(part), grid.n_zenith, grid.n_azimuth)
    if counts[:, _N_ZENITH:].any():
        raise SceneError("photons come from zenith index 90 and more, which is the horizon and below")
    table = np.zeros((len(part), _N_ZENITH, grid.n_azimuth), dtype=np.int64)
    table[:, : grid.n_zenith] = counts[:, :_N_ZENITH]
    return table


def _shared_out_anew(source: PhotonSource, components: list[Component], n_photons: np.ndarray) -> np.ndarray:
    plan, grid = source.plan, PatchGrid.whole_degrees()
    mass = sum(carried_over(component, grid) for component in components)
    component = Component(
        name="sky",
        law=Law.CELL_MU2,
        strength=np.asarray(mass).sum(axis=1),
        mass=np.asarray(mass),
        cell=cells_of_grid(grid),
        grid=grid,
    )
    scene = Scene(
        wavebands=Wavebands(wavelength_nm=plan.arrays["wavelength_nm"]),
        n_photons=n_photons,
        components=(component,),
        row_of_band=plan.arrays["row_of_band"],
    )
    method = plan.options["allocation"]
    if method == AllocationMethod.AOMC.value:  # it loses photons; the export promises the run's total
        method = AllocationMethod.SYSTEMATIC.value
    return scene.source(plan.seed, allocation=method, method=plan.options["method"]).counts


def carried_over(component: Component, grid: PatchGrid) -> np.ndarray:
    """Masses (n_row, n_patch) of a component on another grid of the hemisphere."""
    own = component.grid
    assert own is not None
    flux = law_of(component.law).flux
    if flux is not None:
        n_rows = 1 if component.slope is None else len(component.mass)
        rows = [component.of_row(row) for row in range(n_rows)]
        masses = [flux(row, grid.zenith_bounds_deg, grid.azimuth_bounds_deg).ravel() for row in rows]
        shares = np.stack([mass / (math.fsum(mass.tolist()) or 1.0) for mass in masses])
        return component.strength[:, None] * shares
    in_mu = component.law is Law.CELL_MU
    rings = _ring_shares(own.zenith_bounds_deg, grid.zenith_bounds_deg, in_mu=in_mu)
    columns = _column_shares(own.azimuth_bounds_deg, grid.azimuth_bounds_deg)
    table = component.mass.reshape(-1, own.n_zenith, own.n_azimuth)
    return (rings @ table @ columns.T).reshape(len(table), -1)


def _ring_shares(own: np.ndarray, new: np.ndarray, *, in_mu: bool) -> np.ndarray:
    """Share of each own ring's light in each new ring, (n_new, n_own); a ring without width lies in one of them."""

    def light(near: np.ndarray, far: np.ndarray) -> np.ndarray:
        if in_mu:
            return 2.0 * sin_cos_deg((far + near) / 2)[0] * sin_cos_deg((far - near) / 2)[0]
        return sin_cos_deg(far - near)[0] * sin_cos_deg(far + near)[0]

    near = np.maximum(own[None, :, 0], new[:, None, 0])
    far = np.minimum(own[None, :, 1], new[:, None, 1])
    common = np.where(far > near, light(near, np.maximum(near, far)), 0.0)
    return _as_shares(common, own, new[:, 0])


def _column_shares(own: np.ndarray, new: np.ndarray) -> np.ndarray:
    """Share of each own column's light in each new column, (n_new, n_own), azimuths modulo 360."""
    common = np.zeros((len(new), len(own)))
    for turn in (-360.0, 0.0, 360.0):
        near = np.maximum(own[None, :, 0] + turn, new[:, None, 0])
        far = np.minimum(own[None, :, 1] + turn, new[:, None, 1])
        common += np.maximum(far - near, 0.0)
    start = new[0, 0]
    return _as_shares(common, start + np.mod(own - start, 360.0), new[:, 0])


def _as_shares(common: np.ndarray, own: np.ndarray, new_starts: np.ndarray) -> np.ndarray:
    total = common.sum(axis=0)
    lines = np.flatnonzero(total == 0)
    common[np.searchsorted(new_starts, own[lines, 0], side="right") - 1, lines] = 1.0
    total[lines] = 1.0
    return common / total
