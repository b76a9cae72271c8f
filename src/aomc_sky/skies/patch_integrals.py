"""Integrals of a radiance over the patches of a grid, and what it costs to take it as constant in each patch."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from aomc_sky.grid import PatchGrid
from aomc_sky.kernels.perez.law import HALF_PI, sin_cos
from aomc_sky.skies.quadrature import POINTS, Rule, at_points, weighted_sum

#: Radiance of directions, arrays of one shape: (sky_zenith_rad, sky_azimuth_rad).
Radiance = Callable[[np.ndarray, np.ndarray], np.ndarray]

TOLERANCE = 1e-10  #: Error of all masses together, as a share of the total, at which the rule ends.
_MAX_PARTS = 2**18  #: Parts of patches at which it ends.
_ORDER = 7
_PARTS_AT_ONCE = 2**12
_WEIGHTS = POINTS[_ORDER].weights


class PatchIntegrals(NamedTuple):
    """What the patches of a grid hold of a radiance."""

    mass: np.ndarray  #: Integral of L cos over each patch, shape (n_patch,). [radiance x sr]
    error: float  #: Estimated error of all masses together, as a share of their sum.
    variation: float  #: Total variation between L cos and its means over the patches, as a share. [0 to 1]
    ring_variation: float  #: That of the means over each patch's azimuths: what narrower rings would mend.
    column_variation: float  #: That of the means over its zenith angles: what narrower columns would mend.


def integrate_patches(radiance: Radiance, grid: PatchGrid) -> PatchIntegrals:
    """Integrate L cos over every patch by the rule of `skies.quadrature`, with orders 4 and 7 first.

    What is integrated is L less its value at the middle of the patch, so that a constant is exact. Where the radiance
    is smooth the difference of the orders overstates the error by far; what hides between the points of a patch is not
    seen. Parts that jumps cross are cut until there are `_MAX_PARTS`.
    """
    zenith, azimuth = grid.zenith_bounds_deg / 90.0, grid.azimuth_bounds_deg / 90.0
    n, area = grid.n_patches, grid.projected_solid_angle_sr
    ring, column = np.divmod(np.arange(n), grid.n_azimuth)
    tiles = np.stack([*zenith[ring].T, *azimuth[column].T])

    def at(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        angles = np.broadcast_arrays(x * HALF_PI, np.mod(y * HALF_PI, 2.0 * np.pi))
        return radiance(*(np.ascontiguousarray(angle) for angle in angles))

    def flux(x: np.ndarray, y: np.ndarray, level: np.ndarray) -> np.ndarray:
        sine, mu = sin_cos(x)
        return (at(x, y) - level) * (sine * mu)

    middle = at(0.5 * (tiles[0] + tiles[1]), 0.5 * (tiles[2] + tiles[3]))
    rule = Rule(
        light=lambda x, y, patch: flux(x[0], y[0], middle[patch]),
        share=0.0,
        floor=0.25 * TOLERANCE / n,
        first=(4, _ORDER),
        most_parts=_MAX_PARTS,
    )
    parts = rule.integrate(zenith, azimuth, middle * area / (HALF_PI * HALF_PI))
    mass = middle * area + parts.masses(n) * (HALF_PI * HALF_PI)
    total = _sum(mass)
    if not total > 0:
        return PatchIntegrals(mass, 0.0, 0.0, 0.0, 0.0)
    mean = middle + parts.masses(n) * (HALF_PI * HALF_PI) / area
    is_cut = np.bincount(parts.patch, minlength=n) > 1
    around = by_ring = by_column = 0.0
    for some, values, weight in _in_turn(at, tiles):
        alone = ~is_cut[some]
        beyond = values - mean[some]
        around += _sum(_mean(np.abs(beyond) * weight)[alone])
        beyond = (beyond - _mean(beyond * weight) / weighted_sum(weight[:, 0], _WEIGHTS)) * weight
        by_ring += _sum(weighted_sum(np.abs(weighted_sum(np.swapaxes(beyond, 0, 1), _WEIGHTS)), _WEIGHTS))
        by_column += _sum(weighted_sum(np.abs(weighted_sum(beyond, _WEIGHTS)), _WEIGHTS))
    of_cut = is_cut[parts.patch]
    level = mean[parts.patch[of_cut]]
    for some, values, weight in _in_turn(at, parts.tiles[:, of_cut]):
        around += _sum(_mean(np.abs(values - level[some]) * weight))
    error = _sum(parts.doubt) * (HALF_PI * HALF_PI)
    return PatchIntegrals(mass, error / total, *(part / total / 2.0 for part in (around, by_ring, by_column)))


def _in_turn(at: Radiance, tiles: np.ndarray) -> Iterator[tuple[slice, np.ndarray, np.ndarray]]:
    """Some tiles at a time, the radiance at their points, and the projected solid angle of a tile at these."""
    for k in range(0, tiles.shape[1], _PARTS_AT_ONCE):
        some = slice(k, k + _PARTS_AT_ONCE)
        part = tiles[:, some]
        index = np.zeros(part.shape[1], dtype=np.int64)
        values = at_points(lambda x, y, _: at(x, y), _ORDER, part, index)
        weight = at_points(lambda x, y, _: np.multiply(*sin_cos(x)), _ORDER, part, index)
        yield some, values, weight * ((part[1] - part[0]) * (part[3] - part[2]) * (HALF_PI * HALF_PI))


def _mean(values: np.ndarray) -> np.ndarray:
    return weighted_sum(weighted_sum(values, _WEIGHTS), _WEIGHTS)


def _sum(values: np.ndarray) -> float:
    """Sum in the order of the array; numpy's own differs between processors."""
    return float(np.cumsum(values)[-1]) if values.size else 0.0
