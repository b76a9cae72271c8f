"""Photon counts on whole degrees, the only directions in the AOMC program's sky file, or reasons against them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.directions import sin_cos_deg
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.errors import SceneError
from aomc_sky.grid import PatchGrid
from aomc_sky.plan.laws import beam_deg, law_of
from aomc_sky.source.scene import Scene
from aomc_sky.wavebands import Wavebands

LAST_ZENITH_DEG = 89

MOST_PHOTONS = 16_000_000
"""Most photons of a band for which 32-bit floats can hold every share of the total (below 2^24)."""


def refuse(reasons: Sequence[str]) -> None:
    """Raise one error with all reasons why the program cannot have a run, if there are any."""
    if reasons:
        raise SceneError("the AOMC program cannot launch this run: " + "; ".join(reasons))


def photon_reasons(n_photons: dict[int, int]) -> list[str]:
    """No photons at all, or too many; `n_photons` of each waveband that has any. [0-based]"""
    if not n_photons:
        return ["no waveband of it has photons; run it with --iterations 1000000"]
    band, most = max(n_photons.items(), key=lambda item: item[1])
    if most <= MOST_PHOTONS:
        return []
    return [
        f"waveband {band + 1} has {most} photons, but 32-bit floats count {MOST_PHOTONS}; run it with --iterations "
        f"{MOST_PHOTONS}"
    ]


def whole_degree(component: Component) -> tuple[int, int] | None:
    """Zenith angle and azimuth of a beam from whole degrees, or None for other components."""
    beam = beam_deg(component)
    if beam is None or beam[2] > 0.0:
        return None
    zenith, azimuth = (round(angle) for angle in beam[:2])
    is_there = 1 <= zenith <= LAST_ZENITH_DEG and np.allclose(beam[:2], (zenith, azimuth), rtol=0, atol=1e-9)
    return (zenith, azimuth % 360) if is_there else None


def _beam_reason(component: Component, n_photons: int) -> str:
    beam, cure = beam_deg(component), law_of(component.law).leave_out
    if beam is not None and beam[2] == 0.0:
        zenith, azimuth = min(max(round(beam[0]), 1), LAST_ZENITH_DEG), round(beam[1]) % 360
        cure = f"run it with --sun-zenith {zenith} --sun-azimuth {azimuth}"
    return (
        f"component {component.name!r} (law {component.law.name}) sends {n_photons} photons, but the program's sky "
        f"holds only zenith angles of 1, 2 .. 89 degrees and whole azimuths; {cure}"
    )


def wavelength_reasons(wavelength_nm: np.ndarray, bands: Iterable[int]) -> list[str]:
    """Wavebands [0-based] that would not find their own sky."""
    return [
        f"waveband {band + 1} at {wavelength_nm[band]:.9g} nm has the wavelength of another one to 32 bits, and other "
        f"counts; export it alone with --waveband {band + 1}, or give them wavelengths at least 0.001 nm apart"
        for band in bands
    ]


_N_ZENITH, _N_AZIMUTH = 89, 360

_SHARED_OUT = (
    "the patches of the run are not whole degrees, so its photons were distributed again over patches of one degree"
)


def degree_counts(source: PhotonSource, bands: Sequence[int]) -> tuple[np.ndarray, str]:
    """Photons of a run on whole degrees, int64 (n_band, 89, n_azimuth), and a note if they were shared out again.

    A run on whole degrees (``--bins degrees``) and a beam from a whole degree keep their counts. Other masses are
    carried over to cells of one degree, and shared out with the run's method and seed. The masses of a Perez sky are
    carried over by its own law, others by the law inside their patches. The caller has looked at `degree_reasons`.
    """
    lit = _lit_parts(source, bands)
    patches = [(c, part) for c, part in lit if c.grid is not None]
    note, photons = "", np.zeros((source.n_bands, _N_ZENITH, _N_AZIMUTH), dtype=np.int64)
    for component, part in lit:
        degree = whole_degree(component)
        if degree is not None:
            photons[:, degree[0] - 1, degree[1]] += part[:, 0]
    tables = [part for _, part in patches]
    if not all(_is_on_degrees(c.grid) for c, _ in patches):
        n_photons = np.sum([part.sum(axis=1) for part in tables], axis=0)
        tables, note = [_shared_out_anew(source, [c for c, _ in patches], n_photons)], _SHARED_OUT
    for table in tables:
        photons += table.reshape(photons.shape)
    return photons, note


def degree_reasons(source: PhotonSource, bands: Sequence[int]) -> list[str]:
    """All reasons why light of a run cannot be put on whole degrees."""
    lit = _lit_parts(source, bands)
    reasons = [
        _beam_reason(component, int(part.sum()))
        for component, part in lit
        if component.grid is None and whole_degree(component) is None
    ]
    if not all(_is_on_degrees(c.grid) for c, _ in lit if c.grid is not None):
        reasons += [
            f"component {c.name!r} covers a part of the hemisphere; give it a grid of the whole hemisphere"
            for c, _ in lit
            if law_of(c.law).flux is not None
            and c.slope is None
            and c.grid is not None
            and abs(c.grid.solid_angle_sr.sum() - 2 * np.pi) > 1e-9
        ]
    return reasons


def _lit_parts(source: PhotonSource, bands: Sequence[int]) -> list[tuple[Component, np.ndarray]]:
    """The components that have photons, with their counts, 0 for bands that are not chosen."""
    counts = np.zeros_like(source.counts)
    counts[list(bands)] = source.counts[list(bands)]
    first = source.plan.component_start
    parts = [(c, counts[:, first[k] : first[k + 1]]) for k, c in enumerate(source.components)]
    return [(component, part) for component, part in parts if part.any()]


def _is_on_degrees(grid: PatchGrid | None) -> bool:
    """Whether the patches are cells around whole degrees."""
    known = PatchGrid.whole_degrees()
    return grid is not None and all(
        np.array_equal(getattr(grid, name), getattr(known, name))
        for name in ("zenith_bounds_deg", "azimuth_bounds_deg")
    )


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
        wavebands=Wavebands(wavelength_nm=plan.wavelength_nm),
        n_photons=n_photons,
        components=(component,),
        row_of_band=np.array([band.row for band in plan.bands]),
    )
    return scene.source(plan.seed, allocation=plan.options["allocation"], method=plan.options["method"]).counts


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
