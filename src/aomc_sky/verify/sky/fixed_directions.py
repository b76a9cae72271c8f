"""Where photons come from single directions or from a small disc: edges of zones keep clear of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.directions import sky_from_travel

MARGIN_DEG = 1e-4
"""Distance of an edge from such a direction: thirty times the rounding of a direction in single precision."""

WHOLE_TURN = 360.0


@dataclass(frozen=True, kw_only=True, slots=True)
class FixedDirections:
    """Rectangles in zenith angle and azimuth, each around a direction or a disc."""

    #: zenith_deg, azimuth_deg: Ends of each, margins not included. A width of 360 in azimuth: a disc around the zenith.
    #: [shape (n, 2)]
    zenith_deg: np.ndarray
    azimuth_deg: np.ndarray

    def with_margins(self) -> FixedDirections:
        """The same, widened by what rounding of a direction may move a photon."""
        lowest = np.sin(np.deg2rad(np.maximum(self.zenith_deg[:, 0], 0.01)))
        around = (MARGIN_DEG + MARGIN_DEG / lowest)[:, None] * np.array([-1.0, 1.0])
        return FixedDirections(
            zenith_deg=self.zenith_deg + np.array([-MARGIN_DEG, MARGIN_DEG]), azimuth_deg=self.azimuth_deg + around
        )


def fixed_directions(components: Sequence[Component], *, at_centres: bool) -> FixedDirections:
    """The fixed directions of all components; `at_centres`: photons lie in the centres of patches."""
    parts = [_of_component(component, at_centres) for component in components]
    zenith = np.concatenate([part[0] for part in parts] or [np.zeros((0, 2))])
    azimuth = np.concatenate([part[1] for part in parts] or [np.zeros((0, 2))])
    return FixedDirections(zenith_deg=zenith, azimuth_deg=azimuth)


def _of_component(component: Component, at_centres: bool) -> tuple[np.ndarray, np.ndarray]:
    head, sine, cosine = component.cell[:, :4], component.cell[:, 4], component.cell[:, 5]
    if component.law in (Law.DISC, Law.DISC_AT_HORIZON):
        return _disc(component.law, head[0].tolist(), float(sky_azimuth_deg(sine, cosine)[0]))
    points = np.zeros(0, dtype=np.int64)
    if component.law is Law.BEAM:
        points = np.arange(component.n_cells)
    elif component.grid is not None:
        lit = component.mass.max(axis=0) > 0
        extent = component.grid.solid_angle_sr > 0
        points = np.flatnonzero(lit & (np.full(extent.shape, at_centres) | ~extent))
    zenith, azimuth = cell_centre_deg(component, points)
    return np.column_stack([zenith, zenith]), np.column_stack([azimuth, azimuth])


def cell_centre_deg(component: Component, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sky direction of the middle of cells of a beam or a patch, halfway in the law's own coordinates. [deg]"""
    h0, h1, h2 = component.cell[cells, :3].T
    if component.law is Law.CELL_MU:
        one_minus_mu, mu = h0 + h1 / 2, h2 + h1 / 2
        sin2, mu2 = one_minus_mu * (1 + mu), mu * mu
    else:
        sin2, mu2 = h0 + h1 / 2, h2 + h1 / 2
    zenith = np.rad2deg(np.arctan2(np.sqrt(sin2), np.sqrt(mu2)))
    return zenith, sky_azimuth_deg(component.cell[cells, 4], component.cell[cells, 5])


def sky_azimuth_deg(sine: np.ndarray, cosine: np.ndarray) -> np.ndarray:
    """Azimuth of sky directions from its sine and cosine. [deg, 0 to 360)"""
    travel = -np.stack([cosine, sine, np.zeros_like(sine)], axis=-1)
    return np.rad2deg(sky_from_travel(travel)[1])


def _disc(law: Law, head: list[float], azimuth: float) -> tuple[np.ndarray, np.ndarray]:
    if law is Law.DISC:
        sin_z, cos_z, sin_r, cos_r = head
        centre, radius = np.rad2deg(np.arctan2(sin_z, cos_z)), np.rad2deg(np.arctan2(sin_r, cos_r))
        zenith = max(centre - radius, 0.0), min(centre + radius, 90.0)
        half = np.rad2deg(np.arcsin(sin_r / sin_z)) if sin_r < sin_z else WHOLE_TURN / 2
    else:
        top2, half_width = head[0], head[1]
        zenith = np.rad2deg(np.arctan2(np.sqrt(1 - top2), np.sqrt(top2))), 90.0
        half = 90.0 * half_width
    return np.array([zenith]), np.array([[azimuth - half, azimuth + half]])
