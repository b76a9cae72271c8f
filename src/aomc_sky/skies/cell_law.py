"""What a law answers besides directions, and the laws that belong to no slice.

`aomc_sky.plan.laws.law_of` finds the law of a number. Its directions stand in `aomc_sky.kernels.cells.laws`, those of a
slice in the kernels of the slice.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from aomc_sky.component import Component
from aomc_sky.directions import sin_cos_deg
from aomc_sky.grid import PatchGrid

_GAUSS_POINTS = 64

Moments = tuple[np.ndarray, np.ndarray]
Shapes = tuple[tuple[int, ...], tuple[int, ...]]


def _ends_at_horizon(cell: np.ndarray) -> np.ndarray:
    return np.asarray(cell[:, 2] <= 0)


def _sin2(zenith_deg: np.ndarray) -> np.ndarray:
    return np.asarray(np.sin(np.deg2rad(zenith_deg)) ** 2)


@dataclass(frozen=True, kw_only=True, slots=True)
class CellLaw:
    """One law. A function that is None, and an empty text, mean that the law has no such thing."""

    #: Mean of mu and of 1 / mu over each cell of a component, (n_cell,) each.
    moments: Callable[[Component], Moments]
    #: Which cells (n_cell, 6) send photons down to the horizon, so that the mean of 1 / mu^2 is infinite.
    reaches_horizon: Callable[[np.ndarray], np.ndarray] = _ends_at_horizon
    #: Function of the zenith angle in which the photons of a ring are counted, and spread evenly without `flux`. [deg]
    coordinate: Callable[[np.ndarray], np.ndarray] = _sin2
    #: Flux (n_ring, n_column) through rings and columns, where photons are uneven inside cells. [ends (n, 2) in deg]
    flux: Callable[[Component, np.ndarray, np.ndarray], np.ndarray] | None = None
    #: Share of the flux in each patch of a whole hemisphere, where one cell without centre covers the sky.
    shares: Callable[[Component, PatchGrid], np.ndarray] | None = None
    #: Smallest angle over which the light of such a cell changes. [rad]
    width_rad: Callable[[Component], float] | None = None
    #: Zenith angle and azimuth of its axis, and the angle about it that holds half of the light. [deg]
    axis_deg: Callable[[Component], tuple[float, float, float]] | None = None
    #: Zenith angle and azimuth of the sun of a sky. [deg]
    sun_deg: Callable[[Component], tuple[float, float]] | None = None
    is_beam: bool = False  #: Whether the light comes from one direction or a disc.
    needs_patches: bool = False  #: Whether a component must have a grid.
    instead: str = ""  #: What others can have, where a scene can have one component of the law.
    leave_out: str = ""  #: How a person takes it out of a scene for a program that does not know it.
    #: Shapes of `Component.shared` and `bounds`, from the numbers of cells and of rows of `bounds`.
    tables: Callable[[int, int], Shapes] | None = None
    #: The member of a plan that no kernel may read by, what was found there, and what is allowed; from the cells
    #: (n_cell, 6) and `bounds`.
    refused: Callable[[np.ndarray, np.ndarray | None], tuple[str, str, str] | None] = lambda cell, bounds: None

    @property
    def covers_sky(self) -> bool:
        """Whether its one cell covers the whole sky."""
        return self.shares is not None


def _cell_mu2(component: Component) -> Moments:
    _, growth, far2 = component.cell[:, :3].T
    far, near = np.sqrt(far2), np.sqrt(far2 + growth)
    total = near + far
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = (2.0 / 3.0) * (near * near + near * far + far * far) / total
        inverse = 2.0 / total
    return np.where(total > 0, mean, 0.0), inverse


def _cell_mu(component: Component) -> Moments:
    _, growth, far = component.cell[:, :3].T
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = growth / far
        inverse = np.where(far > 0, np.where(ratio > 0, np.log1p(ratio) / growth, 1.0 / far), np.inf)
    return far + growth / 2.0, inverse


def _disc(component: Component) -> Moments:
    sin_z, cos_z, sin_r, cos_r = component.cell[:, :4].T
    drop = sin_r**2 / (1.0 + cos_r)  # 1 - cos r without cancellation
    along = cos_z**2 * drop * (1 + cos_r + cos_r**2) / 3.0
    across = sin_z**2 / 2.0 * drop**2 * (1 - drop / 3.0)
    return 2.0 * (along + across) / (sin_r**2 * cos_z), 2.0 * drop / (sin_r**2 * cos_z)


def _disc_at_horizon(component: Component) -> Moments:
    """Gauss points in s with mu = top (1 - s^2), which takes the root at the upper rim away."""
    nodes, weights = np.polynomial.legendre.leggauss(_GAUSS_POINTS)
    s, weights = (nodes + 1) / 2, weights / 2
    mean, inverse = np.empty(component.n_cells), np.empty(component.n_cells)
    for k, (top2, _, chord2, cos_z) in enumerate(component.cell[:, :4]):
        top = np.sqrt(top2)
        mu = top * (1 - s * s)
        sin_z = np.sqrt(1 - cos_z**2)
        # chord^2 = (difference of heights)^2 + (difference of radii)^2 + 4 r r' sin^2(azimuth / 2)
        radius = np.sqrt(1 - mu * mu)
        rest = chord2 - (mu - cos_z) ** 2 - (radius - sin_z) ** 2
        width = 2 * np.arcsin(np.sqrt(np.clip(rest / (4 * radius * sin_z), 0.0, 1.0)))
        measure = weights * 2 * top * s * width
        flux = np.sum(measure * mu)
        mean[k], inverse[k] = np.sum(measure * mu * mu) / flux, np.sum(measure) / flux
    return mean, inverse


def _refused_disc_at_horizon(cell: np.ndarray, _: np.ndarray | None) -> tuple[str, str, str] | None:
    """Rim and width follow from centre and radius: six of ten tries hit the disc, and no loop goes on for ever."""
    top, half_width, chord2, cos_z, _, _ = cell.T
    largest = 4.0 * float(sin_cos_deg(5.0)[0]) ** 2 * (1.0 + 1e-12)
    holds = np.all(
        (chord2 > 0) & (chord2 <= largest) & (cos_z >= 0) & (cos_z <= 1) & (half_width > 0) & (half_width <= 1)
    )
    if holds:
        sin_z, sin_r = np.sqrt(1.0 - cos_z * cos_z), np.sqrt(chord2 * (1.0 - chord2 / 4.0))
        rim = cos_z * (1.0 - chord2 / 2.0) + sin_z * sin_r
        wide = sin_cos_deg(half_width * 90.0)[0] * sin_z
        holds = np.all((np.abs(top / rim**2 - 1.0) <= 1e-9) & (np.abs(wide / sin_r - 1.0) <= 1e-9))
    return None if holds else ("cell", "", "upper rim and width of a disc of at most 10 degrees that the horizon cuts")


CELL_MU2 = CellLaw(moments=_cell_mu2)

CELL_MU = CellLaw(moments=_cell_mu, coordinate=lambda zenith_deg: 2 * np.sin(np.deg2rad(zenith_deg) / 2) ** 2)

BEAM = CellLaw(moments=_cell_mu2, is_beam=True)

DISC = CellLaw(
    moments=_disc,
    reaches_horizon=lambda cell: np.asarray(cell[:, 1] <= cell[:, 2]),  # cos z <= sin r
    is_beam=True,
    leave_out="write disc = false in [sun] of sky.toml",
)

DISC_AT_HORIZON = CellLaw(
    moments=_disc_at_horizon,
    reaches_horizon=lambda cell: np.ones(len(cell), dtype=bool),
    is_beam=True,
    leave_out=DISC.leave_out,
    refused=_refused_disc_at_horizon,
)
