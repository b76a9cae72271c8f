"""Mass of a lobe in cells of zenith angle and azimuth, from integrals along the edges of the cells.

Every lobe is a radial law in a stretched plane: with psi = atan2(m_y / alpha_y, m_x / alpha_x) and F the share of
the lobe nearer to the axis, the mass of a region is the integral of F d(psi) around it over 2 pi (Stokes), as long
as the anti-axis, where F = 1, is not inside. So the sphere is cut along a great circle between axis and anti-axis:
on the far side -(1 - F) takes the place of F, and the cut itself adds the psi that it sweeps inside the region.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from aomc_sky.phase import henyey_greenstein
from aomc_sky.skies.lobes.laws import one_minus_mu

# Any circle serves that is not an edge of a grid as well: an odd direction next to the axis.
_CUT = np.array([0.2863, 0.1637, 0.9440])
_CUT_AXIS = _CUT / np.sqrt(_CUT @ _CUT)
_REACH = 3.25

Path = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True, kw_only=True, slots=True)
class TiltedLobe:
    """One lobe in the world."""

    kind: str
    param0: float  #: g, or the roughness along x.
    param1: float  #: Nothing, or the roughness along y.
    rotation: np.ndarray  #: Local to world, shape (3, 3).

    @property
    def stretch(self) -> tuple[float, float]:
        """Scales of the stretched plane."""
        return (1.0, 1.0) if self.kind == "hg" else (self.param0, self.param1)

    @property
    def width(self) -> float:
        """Smallest angle over which the lobe changes, up to a factor of order 1. [rad, up to 0.5]"""
        if self.kind == "hg":
            return min(1.0 - self.param0, 0.5)
        low, high = sorted(self.stretch)
        return min(low, 1.0 / high, low / high, 0.5)


def cell_masses(lobe: TiltedLobe, zenith_rad: np.ndarray, azimuth_rad: np.ndarray) -> np.ndarray:
    """Mass of each cell between rising edges, azimuths within one turn; the sum over all cells of the sphere is 1."""
    rings = np.array([_ring(lobe, zenith, azimuth_rad) for zenith in zenith_rad])
    meridians = np.array([_meridian(lobe, azimuth, zenith_rad) for azimuth in azimuth_rad])
    around = rings[1:] - rings[:-1] + (meridians[:-1] - meridians[1:]).T
    return (around + _cut_sweep(lobe, zenith_rad, azimuth_rad)) / (2 * np.pi)


def _ring(lobe: TiltedLobe, zenith: float, edges: np.ndarray) -> np.ndarray:
    """Integral of F d(psi) along each arc of a ring."""
    sine, cosine = np.sin(zenith), np.cos(zenith)
    if sine == 0.0:
        return np.zeros(edges.size - 1)

    def path(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        zero = np.zeros_like(t)
        direction = np.stack([sine * np.cos(t), sine * np.sin(t), np.full_like(t, cosine)], axis=-1)
        return direction, np.stack([-sine * np.sin(t), sine * np.cos(t), zero], axis=-1)

    breaks: list[float] = []
    for x, y, z in _planes(lobe):
        away = -z * cosine / (sine * np.hypot(x, y)) if x or y else 2.0
        if abs(away) < 1.0:
            breaks += [np.arctan2(y, x) + np.arccos(away), np.arctan2(y, x) - np.arccos(away)]
    x, y, z = _narrow(lobe)
    roots = np.roots([(x - 1j * y) * sine / 2, z * cosine, (x + 1j * y) * sine / 2])
    breaks += list(np.angle(roots[roots != 0.0]))
    turns = edges[0] + np.mod(np.array(breaks) - edges[0], 2 * np.pi)
    return _along(lobe, path, edges, turns)


def _meridian(lobe: TiltedLobe, azimuth: float, edges: np.ndarray) -> np.ndarray:
    """Integral of F d(psi) along each piece of a meridian, downwards."""
    cos, sin = np.cos(azimuth), np.sin(azimuth)

    def path(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        s, c = np.sin(t), np.cos(t)
        return np.stack([s * cos, s * sin, c], axis=-1), np.stack([c * cos, c * sin, -s], axis=-1)

    breaks = [float(np.arctan2(-z, x * cos + y * sin)) for x, y, z in _planes(lobe)]
    x, y, z = _narrow(lobe)
    with np.errstate(divide="ignore", invalid="ignore"):
        angle = np.arctan(-z / (x * cos + y * sin)).real
    return _along(lobe, path, edges, np.mod(np.array([*breaks, angle]), np.pi))


def _planes(lobe: TiltedLobe) -> tuple[np.ndarray, np.ndarray]:
    """World normals of the great circles where F changes its formula: the lobe's horizon and the cut."""
    return lobe.rotation[:, 2], lobe.rotation @ _CUT_AXIS


def _narrow(lobe: TiltedLobe) -> np.ndarray:
    """Complex vector whose product with a direction vanishes at the axis: X + iY of the stretched plane."""
    alpha_x, alpha_y = lobe.stretch
    return lobe.rotation[:, 0] / alpha_x + 1j * lobe.rotation[:, 1] / alpha_y


def _along(lobe: TiltedLobe, path: Path, edges: np.ndarray, breaks: np.ndarray) -> np.ndarray:
    """Integral between neighbouring edges: double exponential between the breaks, where the integrand is sharp."""
    inside = breaks[(breaks > edges[0]) & (breaks < edges[-1])]
    ends = np.unique(np.concatenate([edges, inside]))
    start, length = ends[:-1], np.diff(ends)
    share, weight = _nodes(lobe.width)
    is_near = (lobe.rotation @ _CUT_AXIS) @ path(start + length / 2)[0].T > 0.0
    direction, slope = path(np.minimum(start[:, None] + length[:, None] * share, ends[1:, None]))
    value = _integrand(lobe, direction @ lobe.rotation, slope @ lobe.rotation, is_near[:, None])
    pieces = np.sum(value * weight, axis=1) * length
    owner = np.searchsorted(edges, start + length / 2, side="right") - 1
    return np.bincount(owner, pieces, minlength=edges.size - 1)[: edges.size - 1]


def _nodes(width: float) -> tuple[np.ndarray, np.ndarray]:
    """Double exponential nodes and weights on 0 to 1 for a singularity at i `width`: error e^-37."""
    step = np.pi / (37.0 * np.hypot(1.0, np.log(width) / np.pi))
    t = np.arange(-_REACH, _REACH + step / 2, step)
    e = np.exp(np.pi * np.sinh(t))
    return e / (1.0 + e), step * np.pi * np.cosh(t) * e / (1.0 + e) ** 2


def _integrand(lobe: TiltedLobe, m: np.ndarray, slope: np.ndarray, is_near: np.ndarray) -> np.ndarray:
    """F, or -(1 - F) on the far side, times the derivative of psi along the path."""
    alpha_x, alpha_y = lobe.stretch
    square = (m[..., 0] / alpha_x) ** 2 + (m[..., 1] / alpha_y) ** 2
    turn = (m[..., 0] * slope[..., 1] - m[..., 1] * slope[..., 0]) / (alpha_x * alpha_y)
    near, far = _shares(lobe, m, square)
    with np.errstate(divide="ignore", invalid="ignore"):
        value = np.where(is_near, near, -far) * (turn / square)
    return np.where(square > 0.0, value, 0.0)


def _shares(lobe: TiltedLobe, m: np.ndarray, square: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Shares of the lobe nearer to its axis than m, and farther."""
    if lobe.kind == "hg":
        omm = np.minimum(one_minus_mu(m), 2.0)
        return henyey_greenstein.survival(omm, lobe.param0), henyey_greenstein.cdf(omm, lobe.param0)
    z2 = np.square(np.maximum(m[..., 2], 0.0))
    if lobe.kind == "ggx":
        total = square + z2
        return square / total, z2 / total
    with np.errstate(divide="ignore", under="ignore", over="ignore"):
        exponent = square / z2
        return -np.expm1(-exponent), np.exp(-exponent)


def _cut_sweep(lobe: TiltedLobe, zenith: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """The psi that the cut sweeps inside each cell."""
    first = np.array([_CUT_AXIS[2], 0.0, -_CUT_AXIS[0]]) / np.hypot(_CUT_AXIS[0], _CUT_AXIS[2])
    second = np.cross(_CUT_AXIS, first)
    world_1, world_2 = lobe.rotation @ first, lobe.rotation @ second
    height = np.hypot(world_1[2], world_2[2])
    away = np.cos(zenith[np.abs(np.cos(zenith)) < height]) / height if height > 0.0 else np.zeros(0)
    top = np.arctan2(world_2[2], world_1[2])
    normal = np.stack([-np.sin(azimuth), np.cos(azimuth), np.zeros_like(azimuth)])
    across = np.arctan2(world_2 @ normal, world_1 @ normal) + np.pi / 2
    quarters = np.arange(8) * np.pi / 4
    t = np.concatenate([top + np.arccos(away), top - np.arccos(away), across, across + np.pi, quarters])
    t = np.unique(np.mod(t, 2 * np.pi))
    t = np.append(t, t[0] + 2 * np.pi)
    x, y, _ = (first[:, None] * np.cos(t) + second[:, None] * np.sin(t)) / np.array([[*lobe.stretch, 1.0]]).T
    swept = np.arctan2(x[:-1] * y[1:] - y[:-1] * x[1:], x[:-1] * x[1:] + y[:-1] * y[1:])
    middle = (t[:-1] + t[1:]) / 2
    direction = world_1[:, None] * np.cos(middle) + world_2[:, None] * np.sin(middle)
    turn = azimuth[0] + np.mod(np.arctan2(direction[1], direction[0]) - azimuth[0], 2 * np.pi)
    ring = np.searchsorted(zenith, np.arctan2(np.hypot(direction[0], direction[1]), direction[2]), side="right") - 1
    column = np.searchsorted(azimuth, turn, side="right") - 1
    n, m = zenith.size - 1, azimuth.size - 1
    inside = (ring >= 0) & (ring < n) & (column >= 0) & (column < m)
    return np.bincount((ring * m + column)[inside], swept[inside], minlength=n * m).reshape(n, m)
