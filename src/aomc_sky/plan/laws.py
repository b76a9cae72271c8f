"""All that a law needs, by its number: laws outside the slices, and the modules of the others."""

from __future__ import annotations

import math
from functools import cache
from importlib import import_module

import numpy as np

from aomc_sky.component import CellLaw, Component, Law
from aomc_sky.directions import sin_cos_deg
from aomc_sky.kernels.cells.laws import DRAWN, discs, discs_at_horizon, in_mu, in_mu2

_GAUSS_POINTS = 128


def _cell_mu2(component: Component) -> tuple[np.ndarray, np.ndarray]:
    _, growth, far2 = component.cell[:, :3].T
    far, near = np.sqrt(far2), np.sqrt(far2 + growth)
    total = near + far
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = (2.0 / 3.0) * (near * near + near * far + far * far) / total
        inverse = 2.0 / total
    return np.where(total > 0, mean, 0.0), inverse


def _cell_sloped(component: Component) -> tuple[np.ndarray, np.ndarray]:
    """With near and far the cosines n and f of the edges, and w = 1 - u: mu^2 = f^2 + (n^2 - f^2) w.

    The integral int mu w dw is 2 (3 n^3 + 6 n^2 f + 4 n f^2 + 2 f^3) / (15 (n + f)^2). The integral
    int w / mu dw is 2 (n + 2 f) / (3 (n + f)^2).
    """
    mean, inverse = _cell_mu2(component)
    _, growth, far2 = component.cell[:, :3].T
    assert component.slope is not None
    slope, far, near = component.slope[0, :, 0], np.sqrt(far2), np.sqrt(far2 + growth)
    total2 = (near + far) ** 2
    cubic = ((3.0 * near + 6.0 * far) * near + 4.0 * far * far) * near + 2.0 * far**3
    with np.errstate(divide="ignore", invalid="ignore"):
        mean_w, inverse_w = (2.0 / 15.0) * cubic / total2, (2.0 / 3.0) * (near + 2.0 * far) / total2
    lit = total2 > 0
    mean = np.where(lit, mean + slope * (mean - 2.0 * mean_w), mean)
    return mean, np.where(lit, inverse + slope * (inverse - 2.0 * inverse_w), inverse)


def _sloped_flux(component: Component, zenith_deg: np.ndarray, azimuth_deg: np.ndarray) -> np.ndarray:
    """A cell of mass m and slopes s, t gives a part of it m (P + s Q) (P' + t Q').

    P is the part's extent in u, Q the integral of 2u - 1 over it, and P', Q' those in v.
    """
    grid = component.grid
    assert grid is not None
    assert component.slope is not None
    near, growth, _ = grid.ring_sin2()
    at = np.sin(np.deg2rad(zenith_deg))[:, :, None] ** 2
    ends = np.clip((at - near) / np.where(growth > 0, growth, 1.0), 0.0, 1.0)
    along = _extent_and_first_moment(ends)
    start, width = grid.azimuth_bounds_deg[:, 0], np.diff(grid.azimuth_bounds_deg, axis=1)[:, 0]
    turns = [azimuth_deg[:, :, None] + turn for turn in (-720.0, -360.0, 0.0, 360.0, 720.0)]
    parts = [_extent_and_first_moment(np.clip((at - start) / width, 0.0, 1.0)) for at in turns]
    extent, first_moment = (np.sum(x, axis=0) for x in zip(*parts, strict=True))
    mass = component.mass[0].reshape(grid.n_zenith, grid.n_azimuth)
    s, t = component.slope[0].reshape(grid.n_zenith, grid.n_azimuth, 2).transpose(2, 0, 1)
    columns = [part @ extent.T + (part * t) @ first_moment.T for part in (mass, mass * s)]
    return np.asarray(along[0] @ columns[0] + along[1] @ columns[1])


def _extent_and_first_moment(ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """From ends (n, 2, n_cell) of parts in [0, 1]: their lengths and the integrals of 2u - 1, (n, n_cell) each."""
    low, high = ends[:, 0], ends[:, 1]
    return high - low, high * (high - 1.0) - low * (low - 1.0)


def _cell_mu(component: Component) -> tuple[np.ndarray, np.ndarray]:
    _, growth, far = component.cell[:, :3].T
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = growth / far
        inverse = np.where(far > 0, np.where(ratio > 0, np.log1p(ratio) / growth, 1.0 / far), np.inf)
    return far + growth / 2.0, inverse


def _disc(component: Component) -> tuple[np.ndarray, np.ndarray]:
    sin_z, cos_z, sin_r, cos_r = component.cell[:, :4].T
    drop = sin_r**2 / (1.0 + cos_r)  # 1 - cos r without cancellation
    along = cos_z**2 * drop * (1 + cos_r + cos_r**2) / 3.0
    across = sin_z**2 / 2.0 * drop**2 * (1 - drop / 3.0)
    return 2.0 * (along + across) / (sin_r**2 * cos_z), 2.0 * drop / (sin_r**2 * cos_z)


def _disc_at_horizon(component: Component) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points in t with mu = top cos^2 t: smooth at the upper rim, and where the horizon only touches the disc."""
    nodes, weights = np.polynomial.legendre.leggauss(_GAUSS_POINTS)
    t, weights = (nodes + 1) * (np.pi / 4), weights * (np.pi / 4)
    mean, inverse = np.empty(component.n_cells), np.empty(component.n_cells)
    for k, (top2, _, chord2, cos_z) in enumerate(component.cell[:, :4]):
        top = np.sqrt(top2)
        mu = top * np.cos(t) ** 2
        sin_z = np.sqrt(1 - cos_z**2)
        # chord^2 = (difference of heights)^2 + (difference of radii)^2 + 4 r r' sin^2(azimuth / 2)
        radius = np.sqrt(1 - mu * mu)
        rest = chord2 - (mu - cos_z) ** 2 - (radius - sin_z) ** 2
        width = 2 * np.arcsin(np.sqrt(np.clip(rest / (4 * radius * sin_z), 0.0, 1.0)))
        measure = weights * top * np.sin(2 * t) * width
        flux = np.sum(measure * mu)
        mean[k], inverse[k] = np.sum(measure * mu * mu) / flux, np.sum(measure) / flux
    return mean, inverse


def _refused_disc_at_horizon(cell: np.ndarray, _: np.ndarray | None) -> tuple[str, str, str] | None:
    """Rim and width must follow from centre and radius: then six of ten tries hit the disc, and every loop ends."""
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


_NO_DISC = "write disc = false in [sun] of sky.toml"

#: The law of a number, or for a law of a slice "module:OBJECT".
_LAWS: dict[Law, CellLaw | str] = {
    Law.CELL_MU2: CellLaw(directions=in_mu2, moments=_cell_mu2),
    Law.CELL_MU: CellLaw(
        directions=in_mu,
        moments=_cell_mu,
        coordinate=lambda zenith_deg: 2 * np.sin(np.deg2rad(zenith_deg) / 2) ** 2,
    ),
    Law.BEAM: CellLaw(
        directions=in_mu2,
        moments=_cell_mu2,
        beam=lambda cell: (math.atan2(math.sqrt(cell[0]), math.sqrt(cell[2])), 0.0),
    ),
    Law.DISC: CellLaw(
        directions=discs,
        moments=_disc,
        reaches_horizon=lambda cell: cell[:, 1] <= cell[:, 2],  # cos z <= sin r
        beam=lambda cell: (math.atan2(cell[0], cell[1]), float(np.arctan2(cell[2], cell[3]))),
        leave_out=_NO_DISC,
    ),
    Law.DISC_AT_HORIZON: CellLaw(
        directions=discs_at_horizon,
        moments=_disc_at_horizon,
        reaches_horizon=lambda cell: np.ones(len(cell), dtype=bool),
        beam=lambda cell: (math.acos(cell[3]), 2.0 * float(np.arcsin(np.sqrt(cell[2]) / 2.0))),
        leave_out=_NO_DISC,
        refused=_refused_disc_at_horizon,
    ),
    Law.PEREZ: "aomc_sky.skies.perez.law:PEREZ",
    Law.HG: "aomc_sky.skies.lobes.law:LOBE",
    Law.GGX: "aomc_sky.skies.lobes.law:LOBE",
    Law.BECKMANN: "aomc_sky.skies.lobes.law:LOBE",
    Law.CELL_SLOPED: CellLaw(
        moments=_cell_sloped,
        flux=_sloped_flux,
        needs_patches=True,
        has_slopes=True,
        starts_as=Law.CELL_MU2,
    ),
}


@cache
def law_of(number: Law) -> CellLaw:
    """The law of a number; the module of a slice is imported when the first plan or scene has its law."""
    law = _LAWS.get(number)
    if isinstance(law, str):
        module, _, name = law.partition(":")
        law = getattr(import_module(module), name)
        assert isinstance(law, CellLaw)
    if law is None:
        raise NotImplementedError(f"law {number!r} is not known: add its entry to _LAWS of plan/laws.py")
    start = number if law.directions else law.starts_as
    if start is None and not law.hook:
        raise NotImplementedError(f"law {number!r} has no directions: add directions, starts_as or hook to its entry")
    if start is not None and start not in DRAWN:
        place = "kernels/cells/laws.py, and its formula to direction_of in emission/kernels/emit.py and to aomc_sky.h"
        raise NotImplementedError(f"no kernel draws law {start!r}: add its number to DRAWN in {place}")
    return law


def beam_deg(component: Component) -> tuple[float, float, float] | None:
    """Zenith angle, azimuth and radius of a beam or a disc, within 1e-9 degrees; patches and lobes give None. [deg]"""
    beam = law_of(component.law).beam
    if beam is None or component.grid is not None or component.n_cells != 1:
        return None
    cell = component.cell[0].tolist()
    zenith, radius = beam(cell)
    return math.degrees(zenith), math.degrees(math.atan2(cell[4], cell[5])) % 360.0, float(np.rad2deg(radius))
