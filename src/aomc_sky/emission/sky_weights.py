"""The photons of one run under another sky: a weight for each, because light is linear.

A photon of direction d stands for light in proportion to the radiance L'(d) of the other sky over the density f(d) of
the run's diffuse photons per projected solid angle: mean of L'(d) / f(d) x tally = the tally under the other sky.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from aomc_sky.component import Law
from aomc_sky.directions import Frame, sky_angles
from aomc_sky.emission.radiance import band_radiance
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.grid import PatchGrid
from aomc_sky.plan.laws import law_of
from aomc_sky.plan.options import Placement

if TYPE_CHECKING:
    from aomc_sky.emission.photons import PhotonBatch

FEWEST = 1000
"""Fewer effective photons are refused: their mean says little, and its error even less."""
_MOST_UNSEEN = 1e-4
"""Largest share of the light in directions where the run has no photons."""


def sky_weights(source: Any, scene: Any, batch: PhotonBatch, band: int, *, absolute: bool) -> np.ndarray:
    """Weights of the photons of a `PhotonSource` for the diffuse light of a band of a `Scene`, float64 (n,)."""
    _refuse(source, scene, band, absolute=absolute)
    density = _density(source, batch.band)
    _refuse_unseen(source, scene, batch.band, band, density)
    is_beam = np.array([law_of(component.law).is_beam for component in source.components])
    diffuse = ~is_beam[source.component_of(batch.patch)]
    zenith, azimuth = _angles_in_patches(source, batch, diffuse)
    weights = np.zeros(len(batch))
    weights[diffuse] = scene.radiance(band, zenith, azimuth) / density(zenith, azimuth)
    total, squares = float(weights.sum()), float(np.sum(weights**2))
    if len(batch):
        effective = source.n_photons(batch.band) / len(batch) * (total**2 / squares if squares > 0 else 0.0)
        _refuse_few(effective)
    if scene.irradiance is not None and not absolute:
        weights /= float(scene.irradiance.of_component[band].sum())
    return weights


def _refuse(source: Any, scene: Any, band: int, *, absolute: bool) -> None:
    """Refuse what has no density: a beam of the sky, photons by solid angle, photons in the middle of patches."""
    row = int(scene.row_of_band[band])
    for component in scene.components:
        if law_of(component.law).is_beam and component.strength[row] > 0:
            raise UsageError(
                f"component {component.name!r} is a beam: taken as a patch it is wrong by up to its whole light",
                "give a scene with diffuse_only=True, and the beam as a table of suns (docs/howto/every_sky.md)",
            )
    if any(component.law is Law.CELL_MU for component in source.components):
        raise UsageError(
            "the photons of this run are launched by solid angle, and not as light crosses the surface",
            "make it with --weighting projected",
        )
    if source.plan.options["placement"] == Placement.CENTRE.value:
        raise UsageError("the photons of this run lie in the middle of patches", "make it with placement r2 or philox")
    if absolute and scene.irradiance is None:
        raise UsageError("absolute weights need a scene whose irradiance is known", "leave absolute out")


_EDGE_DEG = 1e-9
"""So far a direction that was rounded over the edge of its patch is moved inside. [deg]"""


def _angles_in_patches(source: Any, batch: PhotonBatch, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Zenith angle and azimuth of photons, each inside its own patch: float32 rounds some over the edge. [rad]"""
    direction = np.column_stack([batch.ux, batch.uy, batch.uz]).astype(np.float64)[chosen]
    zenith, azimuth = (np.rad2deg(angle) for angle in sky_angles(direction, Frame.UP))
    patch, start = batch.patch[chosen], source.plan.component_start
    for component, first, end in zip(source.components, start[:-1], start[1:], strict=True):
        own = np.flatnonzero((patch >= first) & (patch < end))
        if component.grid is None or not own.size:
            continue
        ring, column = np.divmod(patch[own] - first, component.grid.n_azimuth)
        low, high = component.grid.zenith_bounds_deg[ring].T
        zenith[own] = np.clip(zenith[own], low + _EDGE_DEG, high - _EDGE_DEG)
        left, right = component.grid.azimuth_bounds_deg[column].T
        middle, half = (left + right) / 2.0, (right - left) / 2.0 - _EDGE_DEG
        off = np.mod(azimuth[own] - middle + 180.0, 360.0) - 180.0
        azimuth[own] = middle + np.clip(off, -half, half)
    return np.minimum(np.deg2rad(zenith), np.pi / 2), np.deg2rad(np.mod(azimuth, 360.0))


def _density(source: Any, band: int) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """Share of the photons of a band per projected solid angle, of the diffuse components, by direction. [sr^-1]"""
    components, start = source.components_of(band), source.plan.component_start
    launch = source.launch(band)
    parts: list[Callable[[np.ndarray, np.ndarray], np.ndarray]] = []
    for k, component in enumerate(components):
        own = slice(start[k], start[k + 1])
        made = band_radiance([component], 0, [float(component.mass[0].sum())])
        factor = None if source.plan.bias is None else source.weights(band)[own]
        parts += [_launched(part, component.grid, factor) for part in made if launch[own].any()]
    if not parts:
        raise SceneError(f"waveband {band + 1} of the run has no diffuse photons", "run a scene with a sky")
    return lambda zenith, azimuth: np.sum([part(zenith, azimuth) for part in parts], axis=0)


def _launched(
    light: Callable[[np.ndarray, np.ndarray], np.ndarray], grid: PatchGrid | None, weight: np.ndarray | None
) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """The density of the photons from that of the light, and the weights of the cells."""
    if weight is None:
        return light
    if grid is None:
        return lambda zenith, azimuth: light(zenith, azimuth) / weight[0]
    return lambda zenith, azimuth: (
        light(zenith, azimuth)
        / weight[grid.patch_of(np.round(np.rad2deg(zenith), 12), np.round(np.rad2deg(azimuth), 12))]
    )


def _refuse_unseen(source: Any, scene: Any, run_band: int, band: int, density: Any) -> None:
    """Refuse a sky that has light where the run has no photons, or whose weights differ so much that few count."""
    grid = source.grid or PatchGrid.regular(45, 180)
    zenith, azimuth = (np.deg2rad(bounds.mean(axis=1)) for bounds in (grid.zenith_bounds_deg, grid.azimuth_bounds_deg))
    z, a = (x.ravel() for x in np.broadcast_arrays(zenith[:, None], azimuth[None, :]))
    area = grid.projected_solid_angle_sr
    light, photons = scene.radiance(band, z, a) * area, density(z, a) * area
    total, seen = float(light.sum()), photons > 0
    unseen = float(light[~seen].sum()) / total if total > 0 else 1.0
    if unseen > _MOST_UNSEEN:
        raise UsageError(
            f"{unseen:.3g} of the light of this sky comes from directions where the run has no photons",
            "run the mean of the skies that you want",
        )
    spread = float(np.sum(light[seen] ** 2 / photons[seen]))
    _refuse_few(source.n_photons(run_band) * total**2 / spread)


def _refuse_few(effective: float) -> None:
    if effective < FEWEST:
        raise UsageError(
            f"under this sky the photons of the run count as {effective:.0f}; at least {FEWEST} are needed",
            "take more photons, or run the mean of the skies that you want",
        )
