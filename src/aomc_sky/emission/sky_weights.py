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
from aomc_sky.emission.radiance import band_radiance, point_cells
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.grid import PatchGrid
from aomc_sky.plan.laws import law_of

if TYPE_CHECKING:
    from aomc_sky.emission.photons import PhotonBatch

FEWEST = 1000
"""Fewer effective photons are refused: their mean says little, and its error even less."""
_MOST_UNSEEN = 1e-4
"""Largest share of the light in directions where the run has no photons."""


def sky_weights(source: Any, scene: Any, batch: PhotonBatch, band: int, *, absolute: bool) -> np.ndarray:
    """Weights of the photons of a `PhotonSource` for the diffuse light of a band of a `Scene`, float64 (n,)."""
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
    if absolute and scene.irradiance is None:
        raise UsageError("absolute weights need a scene whose irradiance is known", "leave absolute out")
    density = _density(source, batch.band)
    _refuse_poor(source, scene, batch.band, band, density)
    zenith, azimuth = sky_angles(np.column_stack([batch.ux, batch.uy, batch.uz]).astype(np.float64), Frame.UP)
    zenith = np.minimum(zenith, np.pi / 2)
    is_beam = np.array([law_of(component.law).is_beam for component in source.components])
    diffuse = ~is_beam[source.component_of(batch.patch)]
    weights = np.zeros(len(batch))
    light = scene.radiance(band, zenith[diffuse], azimuth[diffuse])
    weights[diffuse] = light / density(zenith[diffuse], azimuth[diffuse])
    if scene.irradiance is not None and not absolute:
        weights /= float(scene.irradiance.of_component[band].sum())
    return weights


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


def _refuse_poor(source: Any, scene: Any, run_band: int, band: int, density: Any) -> None:
    """Refuse a sky that has light where the run has no photons, or whose weights differ so much that few count."""
    grid = source.grid or PatchGrid.regular(45, 180)
    if not np.any(grid.solid_angle_sr > 0):
        grid = point_cells(grid)
    zenith, azimuth = (np.deg2rad(bounds.mean(axis=1)) for bounds in (grid.zenith_bounds_deg, grid.azimuth_bounds_deg))
    z, a = (x.ravel() for x in np.broadcast_arrays(zenith[:, None], azimuth[None, :]))
    area = grid.projected_solid_angle_sr
    light, photons = scene.radiance(band, z, a) * area, density(z, a) * area
    total = float(light.sum())
    unseen = float(light[photons <= 0].sum()) / total if total > 0 else 1.0
    if unseen > _MOST_UNSEEN:
        raise UsageError(
            f"{unseen:.3g} of the light of this sky comes from directions where the run has no photons",
            "run the mean of the skies that you want",
        )
    seen = photons > 0
    spread = float(np.sum(light[seen] ** 2 / photons[seen]))
    effective = source.n_photons(run_band) * total**2 / spread
    if effective < FEWEST:
        raise UsageError(
            f"under this sky the photons of the run count as {effective:.0f}; at least {FEWEST} are needed",
            "take more photons, or run the mean of the skies that you want",
        )
