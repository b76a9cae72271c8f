"""The five quantities whose error is measured: their sums over emitted photons, and their exact values.

Photons follow the flux law (density proportional to radiance times cosine), so a share of the photons is a share of
the planar irradiance. None of the edges below is an edge of a patch, for stratified samplers are exact on those.
Exact values are sums over patches, or quadratures at two orders whose difference is the stated error.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.directions import sin_cos_deg
from aomc_sky.emission.photons import PhotonBatch
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.perez.sky import PerezSky

QUANTITIES = ("planar", "scalar", "cone", "histogram", "ring")

TITLES = {
    "planar": "planar irradiance (mean of mu)",
    "scalar": "scalar irradiance (mean of 1/mu)",
    "cone": "cone of 5 degrees",
    "histogram": "288 bins of the refracted direction",
    "ring": "ring at 87.3 to 88.7 degrees",
}

WAVELENGTH_NM = 500.0
"""Where continuous skies are evaluated; their radiance is relative."""
REFRACTIVE_INDEX = 1.34
CONE_ZENITH_DEG, CONE_AZIMUTH_DEG, CONE_HALF_ANGLE_DEG = 33.37, 217.71, 5.0
RING_ZENITH_DEG = (87.3, 88.7)
N_ROWS, N_SECTORS = 12, 24
FIRST_SECTOR_DEG = 3.7


def histogram_grid() -> PatchGrid:
    """The bins of the refracted direction as patches of the sky.

    12 rows, equal in the angle of refraction from 0 to the critical angle, times 24 sectors of 15 degrees of azimuth,
    the first from 3.7 degrees. A row of refracted angles is a ring of sky zenith angles (Snell's law).
    """
    critical = np.arcsin(1.0 / REFRACTIVE_INDEX)
    sine = REFRACTIVE_INDEX * np.sin(np.linspace(0.0, critical, N_ROWS + 1)[:-1])
    zenith = np.append(np.rad2deg(np.arcsin(sine)), 90.0)
    azimuth = FIRST_SECTOR_DEG + np.arange(N_SECTORS + 1) * (360.0 / N_SECTORS)
    return PatchGrid(
        zenith_bounds_deg=np.column_stack([zenith[:-1], zenith[1:]]),
        azimuth_bounds_deg=np.column_stack([azimuth[:-1], azimuth[1:]]),
    )


def cone_axis() -> np.ndarray:
    """Sky direction of the cone's axis: x, y, z."""
    (sine, east), (cosine, north) = sin_cos_deg(np.array([CONE_ZENITH_DEG, CONE_AZIMUTH_DEG]))
    return np.array([sine * north, sine * east, cosine])


def ring_mu() -> np.ndarray:
    """Lower and upper cosine of the ring."""
    return sin_cos_deg(np.array(RING_ZENITH_DEG[::-1]))[1]


@dataclass(frozen=True, kw_only=True, slots=True)
class Values:
    """The quantities, of photons or of a sky."""

    #: planar, scalar: Means of mu and of 1 / mu over the photons. [0 to 1; 1 to inf]
    planar: float
    scalar: float
    #: cone, ring: Shares of the photons. [0 to 1]
    cone: float
    ring: float
    #: Shares of the photons. [0 to 1, shape (288,)]
    histogram: np.ndarray

    def relative_error(self, truth: Values, quantity: str) -> float:
        """Signed relative error of a quantity; of the histogram the Euclidean norm of it over that of the truth."""
        if quantity == "histogram":
            return float(np.linalg.norm(self.histogram - truth.histogram) / np.linalg.norm(truth.histogram))
        true = float(getattr(truth, quantity))
        return (float(getattr(self, quantity)) - true) / true


class Tally:
    """Sums over photons, batch by batch.

    Edges of the histogram are taken in the precision of the photons, the rest in float64.
    """

    def __init__(self) -> None:
        from bench.tally import tally

        self._add = tally
        self._cone = np.append(cone_axis(), sin_cos_deg(np.array([CONE_HALF_ANGLE_DEG]))[1])
        self._ring = ring_mu()
        grid = histogram_grid()
        sine, cosine = sin_cos_deg(grid.azimuth_bounds_deg[: N_SECTORS // 2, 0])
        self._row_mu = np.ascontiguousarray(grid.mu_edges[1:-1])
        self._starts = np.column_stack([cosine, sine])
        self._sums = np.zeros(4)
        self._histogram = np.zeros((N_ROWS, N_SECTORS), np.int64)

    def add(self, ux: np.ndarray, uy: np.ndarray, uz: np.ndarray) -> None:
        """Count photons by their travel directions, z up, each array of shape (n,)."""
        row_mu, starts = self._row_mu.astype(ux.dtype), self._starts.astype(ux.dtype)
        self._add(ux, uy, uz, self._cone, self._ring, row_mu, starts, self._sums, self._histogram)

    def add_batch(self, batch: PhotonBatch) -> None:
        """Count the photons of a batch."""
        self.add(batch.ux, batch.uy, batch.uz)

    def values(self) -> Values:
        """The quantities of the photons so far; all 0 where there is none, as AOMC's rounding of few photons does."""
        n = max(int(self._histogram.sum()), 1)
        planar, scalar, cone, ring = (self._sums / n).tolist()
        return Values(planar=planar, scalar=scalar, cone=cone, ring=ring, histogram=self._histogram.ravel() / n)


MASS_ERROR = 1e-10
"""Relative error that `PerezSky.patch_mass` promises."""
ROUNDING = 1e-13
"""Bound of the rounding of sums over 32 400 patches."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Truth:
    """What a perfect sampler would give."""

    #: The quantities of the sky.
    values: Values
    #: Relative error of each: the difference of two orders of a quadrature, at least the rounding.
    error: Mapping[str, float]


def truth_of_table(grid: PatchGrid, mass: np.ndarray) -> Truth:
    """Values of a sky that is uniform in mu^2 and azimuth inside each patch, its masses of any scale.

    Exact sums; the cone by Gauss points between all edges that its rim crosses.
    """
    share = (mass / np.sum(mass)).reshape(grid.n_zenith, grid.n_azimuth)
    near, far = grid.ring_mu()
    rings = share.sum(axis=1)
    bins = histogram_grid()
    shares = _overlap_mu2(grid, bins).T @ share @ _overlap_azimuth(grid, bins)
    low, high = ring_mu()
    cut = np.clip(np.minimum(near, high) ** 2 - np.maximum(far, low) ** 2, 0.0, None)
    cone, cone_error = cone_of_table(grid, share, cone_axis(), np.deg2rad(CONE_HALF_ANGLE_DEG))
    values = Values(
        planar=float(rings @ ((2.0 / 3.0) * (near * near + near * far + far * far) / (near + far))),
        scalar=float(rings @ (2.0 / (near + far))),
        cone=cone,
        ring=float(rings @ (cut / grid.ring_sin2()[1])),
        histogram=shares.ravel(),
    )
    exact = dict.fromkeys(("planar", "scalar", "ring", "histogram"), ROUNDING)
    return Truth(values=values, error={**exact, "cone": cone_error})


def _overlap_mu2(grid: PatchGrid, bins: PatchGrid) -> np.ndarray:
    """Share of each ring of the grid that lies in each row of bins, in mu^2, shape (n_zenith, n_row)."""
    near, far = (mu**2 for mu in grid.ring_mu())
    top, bottom = (mu**2 for mu in bins.ring_mu())
    common = np.minimum.outer(near, top) - np.maximum.outer(far, bottom)
    return np.clip(common, 0.0, None) / grid.ring_sin2()[1][:, None]


def _overlap_azimuth(grid: PatchGrid, bins: PatchGrid) -> np.ndarray:
    """Share of each column of the grid that lies in each sector, shape (n_azimuth, n_sector)."""
    start, end = grid.azimuth_bounds_deg.T
    total = np.zeros((grid.n_azimuth, bins.n_azimuth))
    for turn in (-360.0, 0.0, 360.0):
        first, last = bins.azimuth_bounds_deg.T + turn
        total += np.clip(np.minimum.outer(end, last) - np.maximum.outer(start, first), 0.0, None)
    return total / (end - start)[:, None]


def truth_of_perez(model: PerezSky) -> Truth:
    """Values of the continuous Perez sky, positive everywhere, its sun neither overhead nor inside the cone.

    Planar and scalar irradiance in polar coordinates around the sun, the cone in its own, at two orders each; bins and
    ring from `PerezSky.patch_mass`.
    """
    (flux, with_mu, without_mu), error = hemisphere_of_model(model)
    cone, cone_error = cone_of_model(model, cone_axis(), np.deg2rad(CONE_HALF_ANGLE_DEG))
    around = PatchGrid(zenith_bounds_deg=np.array([RING_ZENITH_DEG]), azimuth_bounds_deg=np.array([[0.0, 360.0]]))
    values = Values(
        planar=with_mu / flux,
        scalar=without_mu / flux,
        cone=cone / flux,
        ring=float(model.patch_mass(around)[0]),
        histogram=model.patch_mass(histogram_grid()),
    )
    return Truth(
        values=values,
        error={
            "planar": error,
            "scalar": error,
            "cone": cone_error + error,
            "ring": MASS_ERROR,
            "histogram": MASS_ERROR,
        },
    )


_ORDERS = (20, 28)


def _points(edges: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points and weights of every panel between the edges, flat."""
    x, w = np.polynomial.legendre.leggauss(order)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (x + 1)).ravel(), (half * w).ravel()


def _graded(n: int) -> np.ndarray:
    """Edges from 0 to 1 that crowd towards 1, where a radiance over mu flattens out beyond all powers."""
    return np.append(1.0 - 0.4 ** np.arange(n), 1.0)


def _two_orders(work: Callable[[int], Any]) -> tuple[np.ndarray, float]:
    """Result of the higher order, and the largest relative difference from the lower one, at least the rounding."""
    low, high = (np.asarray(work(order)) for order in _ORDERS)
    return high, max(float(np.max(np.abs(high - low) / np.abs(high))), ROUNDING)


def hemisphere_of_model(model: PerezSky) -> tuple[tuple[float, float, float], float]:
    """Integrals of radiance times mu, mu^2 and 1 over the hemisphere, and the largest relative difference of two
    orders.

    In polar coordinates around the sun, which stands between zenith and horizon: the aureole is smooth in the distance
    from the sun, while any grid of zenith and azimuth sees its cusp. Circles that meet the horizon end there; square
    roots at the first and the last of them vanish in the variable t.
    """

    def integrals(order: int) -> np.ndarray:
        whole = np.pi / 2 - model.sun_zenith_rad
        gamma, weight = _points(np.array([0.0, 0.02, 0.06, 0.15, 0.4, 0.7, 0.85, 0.94, 0.98, 1.0]) * whole, order)
        inner = _circles(model, gamma, weight, np.full(gamma.size, np.pi), order)
        t, weight = _points(np.linspace(0.0, np.pi, 13), order)
        span = 2.0 * model.sun_zenith_rad
        gamma = whole + span * np.sin(t / 2) ** 2
        up = np.cos(model.sun_zenith_rad) * np.cos(gamma)
        across = np.sin(model.sun_zenith_rad) * np.sin(gamma)
        ends = np.arccos(np.clip(-up / across, -1.0, 1.0))
        return inner + _circles(model, gamma, weight * span * np.sin(t) / 2, ends, order)

    (flux, with_mu, without_mu), error = _two_orders(integrals)
    return (float(flux), float(with_mu), float(without_mu)), error


def _circles(model: PerezSky, gamma: np.ndarray, weight: np.ndarray, ends: np.ndarray, order: int) -> np.ndarray:
    """Sum over circles around the sun, each from the meridian towards the zenith to its end, and mirrored."""
    s, ws = _points(_graded(14), order)
    psi = ends[:, None] * s
    zenith, azimuth, mu = _seen_from(model.sun_zenith_rad, model.sun_azimuth_rad, gamma[:, None], psi)
    value = model.radiance(zenith, azimuth, WAVELENGTH_NM) * (2.0 * ends * weight * np.sin(gamma))[:, None] * ws
    return np.array([np.sum(value * mu), np.sum(value * mu * mu), np.sum(value)])


def _seen_from(
    axis_zenith: float, axis_azimuth: float, gamma: np.ndarray, psi: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Zenith angle, azimuth and mu of points at a distance from an axis, psi from the side of the zenith."""
    sine, cosine = np.sin(axis_zenith), np.cos(axis_zenith)
    along, across = np.cos(gamma), np.sin(gamma)
    mu = np.clip(cosine * along + sine * across * np.cos(psi), 0.0, 1.0)
    forward = sine * along - cosine * across * np.cos(psi)
    sideways = np.broadcast_to(across * np.sin(psi), mu.shape)
    return np.arctan2(np.hypot(forward, sideways), mu), axis_azimuth + np.arctan2(sideways, forward), mu


def cone_of_model(model: PerezSky, axis: np.ndarray, half_angle: float) -> tuple[float, float]:
    """Integral of radiance times mu over a cone above the horizon that does not hold the sun, and its relative error.

    The axis is a sky direction, the half angle in radians; the error is the difference of two orders.
    """
    zenith, azimuth = float(np.arccos(axis[2])), float(np.arctan2(axis[1], axis[0]))

    def integral(order: int) -> np.ndarray:
        gamma, weight = _points(np.array([0.0, half_angle]), order)
        psi, around = _points(np.linspace(-np.pi, np.pi, 5), order)
        where = _seen_from(zenith, azimuth, gamma[:, None], psi)
        value = model.radiance(where[0], where[1], WAVELENGTH_NM) * where[2]
        return np.array([np.sum(value * (weight * np.sin(gamma))[:, None] * around)])

    (value,), error = _two_orders(integral)
    return float(value), error


def cone_of_table(grid: PatchGrid, share: np.ndarray, axis: np.ndarray, half_angle: float) -> tuple[float, float]:
    """Share of the photons in a cone, of a law that is uniform in mu^2 and azimuth inside each patch, and its relative
    error.

    The cone touches neither zenith nor horizon. At each azimuth it is an interval of mu, and the patches under it add
    up exactly. What is left is one integral, smooth between the azimuths at which the rim crosses an edge. With
    sin(azimuth from the axis) = sin(largest) sin(t) the rim's square roots are smooth in t.
    """
    z, a = float(np.arccos(axis[2])), float(np.arctan2(axis[1], axis[0]))
    largest = np.sin(half_angle) / np.sin(z)  # sine of the largest azimuth from the axis
    breaks = _azimuths_of_breaks(grid, z, a, half_angle)
    t = np.arcsin(np.clip(np.sin(breaks) / largest, -1.0, 1.0))
    edges = np.unique(np.concatenate([[-np.pi / 2, np.pi / 2], t]))

    def integral(order: int) -> np.ndarray:
        nodes, weight = _points(edges, order)
        delta = np.arcsin(largest * np.sin(nodes))
        slope = largest * np.cos(nodes) / np.cos(delta)
        return np.array([np.sum(weight * slope * _under(grid, share, z, a, half_angle, delta))])

    (value,), error = _two_orders(integral)
    return float(value), error


def _azimuths_of_breaks(grid: PatchGrid, z: float, a: float, half_angle: float) -> np.ndarray:
    """Azimuths from the axis of all columns' edges, and of all points where the rim meets a ring's edge."""
    columns = np.deg2rad(grid.azimuth_bounds_deg.ravel()) - a
    columns = np.arctan2(np.sin(columns), np.cos(columns))
    mu = sin_cos_deg(grid.zenith_bounds_deg.ravel())[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = (np.cos(half_angle) - mu * np.cos(z)) / (np.sqrt(1 - mu * mu) * np.sin(z))
    met = np.arccos(cosine[np.abs(cosine) <= 1])
    limit = np.arcsin(np.sin(half_angle) / np.sin(z))
    found = np.concatenate([columns, met, -met])
    return found[np.abs(found) < limit]


def _under(grid: PatchGrid, share: np.ndarray, z: float, a: float, half_angle: float, delta: np.ndarray) -> np.ndarray:
    """Density in azimuth of the share inside the cone, at azimuths from its axis, shape (n,)."""
    # mu cos z + sqrt(1 - mu^2) sin z cos(delta) = cos(half_angle), as cos(zenith - middle) = height / length
    middle = np.arctan2(np.sin(z) * np.cos(delta), np.cos(z))
    length = np.hypot(np.cos(z), np.sin(z) * np.cos(delta))
    reach = np.arccos(np.clip(np.cos(half_angle) / length, -1.0, 1.0))
    high, low = np.cos(middle - reach) ** 2, np.cos(middle + reach) ** 2
    near, far = (mu**2 for mu in grid.ring_mu())
    common = np.minimum.outer(high, near) - np.maximum.outer(low, far)
    part = np.clip(common, 0.0, None) / grid.ring_sin2()[1]
    column = grid.patch_of(np.full(delta.shape, grid.zenith_bounds_deg[0].mean()), np.rad2deg(a + delta))
    width = np.deg2rad(np.diff(grid.azimuth_bounds_deg, axis=1)).ravel()
    density = share / width
    return np.einsum("nr,rn->n", part, density[:, column])
