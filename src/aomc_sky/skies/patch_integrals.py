"""Integrals of a radiance over the patches of a grid: masses by adaptive quadrature, and what constant patches cost."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from aomc_sky.grid import PatchGrid

#: Radiance of directions, arrays of one shape: (sky_zenith_rad, sky_azimuth_rad).
Radiance = Callable[[np.ndarray, np.ndarray], np.ndarray]

TOLERANCE = 1e-10  #: Error of all masses together, as a share of the total, that quadrature goes on to.
_MAX_BOXES = 2**18  #: Parts of patches at which it ends.
_MAX_HALVINGS = 40
_BOXES_AT_ONCE = 2**13

# Gauss-Legendre of 3 nodes inside Kronrod of 7 on [-1, 1]: Kronrod (1965); a test computes both rules again
_NODES = np.array([0.9604912687080203, 0.7745966692414834, 0.4342437493468026])
_KRONROD = np.array([0.1046562260264673, 0.2684880898683334, 0.4013974147759622, 0.4509165386584741])
_GAUSS = np.array([0.0, 5 / 9, 0.0, 8 / 9])
SHARE = np.concatenate([(1 - _NODES) / 2, [0.5], (1 + _NODES[::-1]) / 2])  #: Nodes on [0, 1].
WEIGHT = np.concatenate([_KRONROD, _KRONROD[2::-1]]) / 2  #: Their weights.
GAUSS_WEIGHT = np.concatenate([_GAUSS, _GAUSS[2::-1]]) / 2  #: Weights of those of Gauss, 0 at the others.


class PatchIntegrals(NamedTuple):
    """What the patches of a grid hold of a radiance."""

    mass: np.ndarray  #: Integral of L cos over each patch, shape (n_patch,). [radiance x sr]
    error: float  #: Estimated error of all masses together, as a share of their sum.
    variation: float  #: Total variation between L cos and its means over the patches, as a share. [0 to 1]
    ring_variation: float  #: That of the means over each patch's azimuths: what narrower rings would mend.
    column_variation: float  #: That of the means over its zenith angles: what narrower columns would mend.


class _Boxes(NamedTuple):
    """Parts of patches: [start, start + width] as shares of the zenith angles and azimuths of their patch."""

    patch: np.ndarray
    ring_start: np.ndarray
    ring_width: np.ndarray
    column_start: np.ndarray
    column_width: np.ndarray

    def take(self, chosen: np.ndarray | slice) -> _Boxes:
        """The chosen ones."""
        return _Boxes(*(array[chosen] for array in self))


class _Values(NamedTuple):
    """Of each box: projected solid angle, the mean of L, its differences by direction, mean absolute deviations."""

    area_sr: np.ndarray
    mean: np.ndarray
    ring_difference: np.ndarray
    column_difference: np.ndarray
    deviation: np.ndarray
    ring_deviation: np.ndarray
    column_deviation: np.ndarray


def integrate_patches(radiance: Radiance, grid: PatchGrid) -> PatchIntegrals:
    """Integrate L cos over every patch with 7 x 7 Kronrod nodes in both angles, halving where Gauss differs.

    The parts of patches with the largest differences are halved, in the direction that has them, until all differences
    together are below `TOLERANCE` of the total, or there are `_MAX_BOXES` parts. Where the radiance is smooth the
    difference overstates the error by far; what hides between the nodes of a patch is not seen. Where L is constant
    in a patch its mean is L, exactly.
    """
    n = grid.n_patches
    boxes = _Boxes(np.arange(n), np.zeros(n), np.ones(n), np.zeros(n), np.ones(n))
    first = values = _evaluate(radiance, grid, boxes)
    mass, error = np.zeros(n), 0.0
    leaves: list[_Boxes] = []
    for halvings in range(_MAX_HALVINGS + 1):
        differences = np.maximum(values.ring_difference, values.column_difference) * values.area_sr
        total = float(mass.sum() + values.mean @ values.area_sr)
        n_left = _MAX_BOXES - boxes.patch.size - sum(leaf.patch.size for leaf in leaves)
        is_split = _to_halve(differences, TOLERANCE * total - error, n_left // 3 if halvings < _MAX_HALVINGS else 0)
        error += float(differences[~is_split].sum())
        np.add.at(mass, boxes.patch[~is_split], (values.mean * values.area_sr)[~is_split])
        leaves.append(boxes.take(~is_split))
        if not is_split.any():
            break
        boxes = _halved(boxes.take(is_split), values.ring_difference[is_split], values.column_difference[is_split])
        values = _evaluate(radiance, grid, boxes)
    total = float(mass.sum())
    if not total > 0:
        return PatchIntegrals(mass, 0.0, 0.0, 0.0, 0.0)
    deviation = float(first.deviation[leaves[0].patch] @ first.area_sr[leaves[0].patch])
    for leaf in leaves[1:]:
        deviation += _deviation(radiance, grid, leaf, mass / first.area_sr)
    by_direction = [float(part @ first.area_sr) for part in (first.ring_deviation, first.column_deviation)]
    return PatchIntegrals(mass, error / total, *(part / 2 / total for part in (deviation, *by_direction)))


def _to_halve(differences: np.ndarray, allowed: float, room: int) -> np.ndarray:
    """Which boxes to halve, at most `room`: the others keep half of what is allowed; none where all have less."""
    chosen = np.zeros(differences.size, bool)
    if room > 0 and differences.sum() > allowed:
        order = np.argsort(differences, kind="stable")
        n_left = int(np.searchsorted(np.cumsum(differences[order]), max(allowed, 0.0) / 2, side="right"))
        chosen[order[max(n_left, differences.size - room) :]] = True
    return chosen


def _halved(boxes: _Boxes, ring_difference: np.ndarray, column_difference: np.ndarray) -> _Boxes:
    """Halves of boxes, or quarters where both directions have differences of one size."""
    is_halved = ring_difference >= column_difference / 8
    across = column_difference >= ring_difference / 8
    width = boxes.ring_width * np.where(is_halved, 0.5, 1.0)
    first = boxes._replace(ring_width=width)
    second = first._replace(ring_start=first.ring_start + width).take(is_halved)
    boxes = _Boxes(*(np.concatenate(pair) for pair in zip(first, second, strict=True)))
    across = np.concatenate([across, across[is_halved]])
    width = boxes.column_width * np.where(across, 0.5, 1.0)
    first = boxes._replace(column_width=width)
    second = first._replace(column_start=first.column_start + width).take(across)
    return _Boxes(*(np.concatenate(pair) for pair in zip(first, second, strict=True)))


def _evaluate(radiance: Radiance, grid: PatchGrid, boxes: _Boxes) -> _Values:
    chunks = [boxes.take(slice(k, k + _BOXES_AT_ONCE)) for k in range(0, boxes.patch.size, _BOXES_AT_ONCE)]
    parts = [_values(*_at_nodes(radiance, grid, chunk)) for chunk in chunks]
    return _Values(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def _deviation(radiance: Radiance, grid: PatchGrid, boxes: _Boxes, mean: np.ndarray) -> float:
    """Integral of |L - mean of the patch| cos over boxes."""
    deviation = 0.0
    for k in range(0, boxes.patch.size, _BOXES_AT_ONCE):
        chunk = boxes.take(slice(k, k + _BOXES_AT_ONCE))
        at_nodes, weight, area_sr = _at_nodes(radiance, grid, chunk)
        beyond = np.abs(at_nodes - mean[chunk.patch, None, None])
        deviation += float(np.einsum("bi,bij,j,b->", weight, beyond, WEIGHT, area_sr))
    return deviation


def _at_nodes(radiance: Radiance, grid: PatchGrid, boxes: _Boxes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """L at the nodes, shape (n_box, 7, 7); cos sin over its mean at the seven zenith angles (n_box, 7); the area."""
    ring, column = np.divmod(boxes.patch, grid.n_azimuth)
    near, far = (np.deg2rad(grid.zenith_bounds_deg[ring, k]) for k in (0, 1))
    width = (far - near) * boxes.ring_width
    start = near + (far - near) * boxes.ring_start
    zenith = start[:, None] + width[:, None] * SHARE
    growth = np.sin(width) * np.sin(2 * start + width)
    weight = WEIGHT * np.sin(2 * zenith) * (width / growth)[:, None]
    bounds = np.deg2rad(grid.azimuth_bounds_deg)[column]
    along = boxes.column_start[:, None] + boxes.column_width[:, None] * SHARE
    azimuth = np.mod(bounds[:, :1] + (bounds[:, 1:] - bounds[:, :1]) * along, 2 * np.pi)
    shape = (boxes.patch.size, SHARE.size, SHARE.size)
    at_nodes = radiance(
        np.ascontiguousarray(np.broadcast_to(zenith[:, :, None], shape)),
        np.ascontiguousarray(np.broadcast_to(azimuth[:, None, :], shape)),
    )
    part = growth / (np.sin(far - near) * np.sin(far + near)) * boxes.column_width
    return at_nodes, weight, grid.projected_solid_angle_sr[boxes.patch] * part


def _values(at_nodes: np.ndarray, weight: np.ndarray, area_sr: np.ndarray) -> _Values:
    beyond = at_nodes - at_nodes[:, 3:4, 3:4]  # 0 where L is constant, whose mean is then exact
    by_ring, by_column = beyond @ WEIGHT, np.einsum("bi,bij->bj", weight, beyond)
    mean = by_column @ WEIGHT
    of_gauss = weight * (GAUSS_WEIGHT / WEIGHT)
    return _Values(
        area_sr=area_sr,
        mean=at_nodes[:, 3, 3] + mean,
        ring_difference=np.abs(np.einsum("bi,bi->b", weight - of_gauss, by_ring)),
        column_difference=np.abs(by_column @ (WEIGHT - GAUSS_WEIGHT)),
        deviation=np.einsum("bi,bij,j->b", weight, np.abs(beyond - mean[:, None, None]), WEIGHT),
        ring_deviation=np.einsum("bi,bi->b", weight, np.abs(by_ring - mean[:, None])),
        column_deviation=np.abs(by_column - mean[:, None]) @ WEIGHT,
    )
