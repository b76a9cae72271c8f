"""Integrals of a radiance over the patches of a grid: masses, slopes, and the error of a law linear in each patch."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from aomc_sky.component import MAX_SLOPE
from aomc_sky.grid import PatchGrid
from aomc_sky.kernels.arithmetic.constants import SLOPE_STEP
from aomc_sky.kernels.arithmetic.elementary import HALF_PI, sin_cos
from aomc_sky.skies.jumps import CLOSE, jumps
from aomc_sky.skies.quadrature import POINTS, Parts, Rule, cut, points_of, quarter_turns, weighted_sum

#: Radiance of directions, arrays of one shape: (sky_zenith_rad, sky_azimuth_rad).
Radiance = Callable[[np.ndarray, np.ndarray], np.ndarray]

TOLERANCE = 1e-10  #: Error of all masses together, as a share of the total, at which the rule ends.
_MAX_PARTS = 2**18  #: Parts of patches at which it ends.
_PARTS_AT_ONCE = 2**12
_ORDER = 8  #: Order of the second look; its points lie between those of the first.
_WEIGHTS = POINTS[_ORDER].weights
_SEEN = 25.0  #: A patch is looked at again where both looks differ by so many times what it may be wrong.
_SIXTEENTHS = 16
_MOST_CLOSE = 0.1  #: Share of the patches that are looked at closely.
_AREA = HALF_PI * HALF_PI  #: Area of a square of one quarter turn.

SURE_SPOT = 0.19
"""A disc of light this wide, in widths of a patch, holds a point of orders 4, 7 or 8: their largest gap is 0.186."""


class PatchIntegrals(NamedTuple):
    """Integrals of a radiance over patches."""

    mass: np.ndarray  #: Integral of L cos over each patch, shape (n_patch,). [radiance x sr]
    error: float  #: Estimated error of all masses together, as a share of their sum.
    slope: np.ndarray  #: Slopes of `Law.CELL_SLOPED` with the means of L cos in each patch, shape (n_patch, 2).
    variation: float  #: Total variation between L cos and these laws, as a share. [0 to 1]
    ring_variation: float  #: That of the means over each patch's azimuths: what narrower rings would mend.
    column_variation: float  #: That of the means over its zenith angles: what narrower columns would mend.


def integrate_patches(radiance: Radiance, grid: PatchGrid) -> PatchIntegrals:
    """Integrate L cos over every patch by the rule of `skies.quadrature`, with orders 4 and 7 first.

    The integrand is L less its value at the middle of the patch, so a constant is exact. For a smooth radiance the
    difference of the orders overstates the error by far. Order 8 then looks between their points for spots. Parts that
    jumps cross are cut until there are `_MAX_PARTS`.
    """
    sky = _Patches(radiance, grid)
    parts = sky.parts()
    mass = sky.masses(parts)
    if not _sum(mass) > 0:
        return PatchIntegrals(mass, 0.0, np.zeros((grid.n_patches, 2)), 0.0, 0.0, 0.0)
    look = sky.second_look(mass)
    parts = sky.cut_again(parts, mass, look.mass)
    mass = sky.masses(parts)
    slope, around = sky.laws(parts, mass, look)
    total = _sum(mass)
    left = around, look.by_ring, look.by_column
    return PatchIntegrals(
        mass, _sum(parts.error_estimate) * _AREA / total, slope, *(part / total / 2.0 for part in left)
    )


class _Look(NamedTuple):
    """Results of order 8 for whole patches."""

    mass: np.ndarray  #: (n_patch,)
    slope: np.ndarray  #: (2, n_patch)
    around: np.ndarray  #: Integrals of |L cos - their laws|, (n_patch,).
    by_ring: float  #: Sums of those of means over azimuths,
    by_column: float  #: and over zenith angles.


class _Patches:
    """The patches of a grid in quarter turns, and the radiance there."""

    def __init__(self, radiance: Radiance, grid: PatchGrid) -> None:
        self._radiance, self._grid, self._n = radiance, grid, grid.n_patches
        self._zenith, self._azimuth = quarter_turns(grid)
        ring, column = np.divmod(np.arange(self._n), grid.n_azimuth)
        self._tiles = np.stack([*self._zenith[ring].T, *self._azimuth[column].T])
        self._area, self._sin2 = grid.projected_solid_angle_sr, grid.ring_sin2()
        self._middle = self._at(0.5 * (self._tiles[0] + self._tiles[1]), 0.5 * (self._tiles[2] + self._tiles[3]))
        self._most_parts = max(_MAX_PARTS, 2 * self._n)
        self._cut_at(*jumps(self._at, self._zenith, self._azimuth, self._most_parts))

    def _cut_at(self, zeniths: np.ndarray, azimuths: np.ndarray) -> None:
        """Take the rule that cuts all patches at these zenith angles and azimuths. [quarter turns]"""
        self._jumps = zeniths, azimuths
        marks = zeniths, np.concatenate([azimuths % 4.0, azimuths % 4.0 + 4.0])  # both turns that columns may reach
        columns = self._azimuth - 4.0 * np.floor(0.25 * self._azimuth[:, :1])
        owners = cut(self._zenith, marks[0])[1], cut(columns, np.concatenate([np.arange(9.0), marks[1]]))[1]
        #: parts of a patch that the rule makes at once, at quarter turns of azimuth and at jumps
        self._n_aligned = np.outer(*(np.bincount(owner) for owner in owners)).ravel()
        self._rule = Rule(
            integrand=lambda x, y, patch: self._flux(x[0], y[0], self._middle[patch]),
            share=0.0,
            floor=0.25 * TOLERANCE / self._n,
            marks=marks[0],
            y_marks=marks[1],
            first=(4, 7),
            most_parts=_MAX_PARTS,
        )

    def _at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        angles = np.broadcast_arrays(x * HALF_PI, np.mod(y * HALF_PI, 2.0 * np.pi))
        return self._radiance(*(np.ascontiguousarray(angle) for angle in angles))

    def _flux(self, x: np.ndarray, y: np.ndarray, level: np.ndarray) -> np.ndarray:
        sine, mu = sin_cos(x)
        return (self._at(x, y) - level) * (sine * mu)

    def masses(self, parts: Parts) -> np.ndarray:
        """Integrals of L cos over the patches."""
        return self._middle * self._area + parts.masses(self._n) * _AREA

    def parts(self) -> Parts:
        """Parts of the patches that orders 4 and 7 agree on; jumps are looked for once more where they do not."""
        parts = self._integrated()
        near = self._with_neighbours(self._n_parts(parts) > self._n_aligned)
        rings, columns = self._zenith[near.any(axis=1)], self._azimuth[near.any(axis=0)]
        if 0 < len(rings) * len(columns) <= _MOST_CLOSE * self._n:
            found = jumps(self._at, rings, columns, self._most_parts, CLOSE)
            if any(one.size for one in found):
                self._cut_at(*(np.concatenate(pair) for pair in zip(self._jumps, found, strict=True)))
                parts = self._integrated()
        return parts

    def _integrated(self) -> Parts:
        return self._rule.integrate(self._zenith, self._azimuth, self._middle * self._area / _AREA)

    def cut_again(self, parts: Parts, mass: np.ndarray, seen: np.ndarray) -> Parts:
        """Cut patches whose integral by order 8 differs, and neighbours of cut ones, into which a spot may reach.

        Orders 4 and 7 have agreed on them: a narrow spot, or a part of one, lay between their points.
        """
        total, is_cut = _sum(mass), self._n_parts(parts) > 1
        found = np.abs(seen - mass) > _SEEN * TOLERANCE * total / self._n
        is_refined = self._n_parts(parts) > self._n_aligned
        again = self._with_neighbours(found | is_refined).ravel() & ~is_cut
        if not again.any():
            return parts
        chosen = np.flatnonzero(again)
        x, y = (np.linspace(self._tiles[k, chosen], self._tiles[k + 1, chosen], 5) for k in (0, 2))
        i, j = np.divmod(np.arange(_SIXTEENTHS), 4)
        tiles = np.stack([x[i], x[i + 1], y[j], y[j + 1]]).transpose(0, 2, 1).reshape(4, -1)
        owner = np.repeat(chosen, _SIXTEENTHS)
        finer = self._rule.refined(tiles, owner, np.full(self._n, self._rule.floor * total / _AREA))
        kept = Parts(*(column[..., ~again[parts.patch]] for column in parts))
        return Parts.joined([kept, finer])

    def _with_neighbours(self, chosen: np.ndarray) -> np.ndarray:
        """Those patches and the ones around them, shape (n_zenith, n_azimuth)."""
        near = chosen.reshape(self._grid.n_zenith, self._grid.n_azimuth)
        near = near | np.roll(near, 1, axis=1) | np.roll(near, -1, axis=1)
        padded = np.pad(near, ((1, 1), (0, 0)))
        return np.asarray(padded[:-2] | padded[1:-1] | padded[2:])

    def _n_parts(self, parts: Parts) -> np.ndarray:
        return np.bincount(parts.patch, minlength=self._n)

    def second_look(self, mass: np.ndarray) -> _Look:
        """Order 8 on whole patches: the masses that it sees, and the laws of all patches that are not cut."""
        seen, around, slope, mean = np.zeros(self._n), np.zeros(self._n), np.zeros((2, self._n)), mass / self._area
        by_ring = by_column = 0.0
        for some, values, weight in self._in_turn(self._tiles):
            places = self._places(self._tiles[:, some], np.arange(self._n)[some])
            seen[some] = _mean(values * weight)
            slope[:, some] = slopes_of(np.stack([_mean(values * weight * x) for x in places]), mass[some])
            beyond = _beyond(values, mean[some], slope[:, some], places) * weight
            around[some] = _mean(np.abs(beyond))
            by_ring += _sum(weighted_sum(np.abs(weighted_sum(np.swapaxes(beyond, 0, 1), _WEIGHTS)), _WEIGHTS))
            by_column += _sum(weighted_sum(np.abs(weighted_sum(beyond, _WEIGHTS)), _WEIGHTS))
        return _Look(seen, slope, around, by_ring, by_column)

    def laws(self, parts: Parts, mass: np.ndarray, look: _Look) -> tuple[np.ndarray, float]:
        """Slopes (n_patch, 2), and the integral of |L cos - their laws|; those of cut patches from their parts."""
        is_cut, slope, mean = self._n_parts(parts) > 1, look.slope, mass / self._area
        around = _sum(look.around[~is_cut])
        is_in_cut = is_cut[parts.patch]
        pieces, owner, first_moment = parts.tiles[:, is_in_cut], parts.patch[is_in_cut], np.zeros((2, self._n))
        for some, values, weight in self._in_turn(pieces):
            for axis, x in enumerate(self._places(pieces[:, some], owner[some])):
                np.add.at(first_moment[axis], owner[some], _mean(values * weight * x))
        slope[:, is_cut] = slopes_of(first_moment[:, is_cut], mass[is_cut])
        for some, values, weight in self._in_turn(pieces):
            own = owner[some]
            beyond = _beyond(values, mean[own], slope[:, own], self._places(pieces[:, some], own))
            around += _sum(_mean(np.abs(beyond) * weight))
        return slope.T, around

    def _places(self, tiles: np.ndarray, patch: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """2u - 1 and 2v - 1 of `Law.CELL_SLOPED` at the points of parts of patches, which broadcast."""
        ring, column = np.divmod(patch, self._grid.n_azimuth)
        near, growth = self._sin2[0][ring], self._sin2[1][ring]
        start, end = self._azimuth[column].T
        turns = 4.0 * np.floor(0.25 * (0.5 * (tiles[2] + tiles[3]) - start))  # parts may lie whole turns away
        x, y = points_of(_ORDER, tiles)
        return 2.0 * (sin_cos(x)[0] ** 2 - near) / growth - 1.0, 2.0 * (y - turns - start) / (end - start) - 1.0

    def _in_turn(self, tiles: np.ndarray) -> Iterator[tuple[slice, np.ndarray, np.ndarray]]:
        """Some tiles at a time, the radiance at their points, and the projected solid angle of a tile at these."""
        for k in range(0, tiles.shape[1], _PARTS_AT_ONCE):
            some = slice(k, k + _PARTS_AT_ONCE)
            part = tiles[:, some]
            x, y = points_of(_ORDER, part)
            yield some, self._at(x, y), np.multiply(*sin_cos(x)) * ((part[1] - part[0]) * (part[3] - part[2]) * _AREA)


def slopes_of(first_moment: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Slopes (2, ...) from integrals of L cos (2u - 1) and L cos (2v - 1) over patches: u has the mean 1/2 + s/6."""
    slope = 3.0 * np.divide(first_moment, mass, out=np.zeros_like(first_moment), where=mass > 0)
    return np.asarray(np.rint(np.clip(slope, -MAX_SLOPE, MAX_SLOPE) / SLOPE_STEP) * SLOPE_STEP)


def _beyond(
    values: np.ndarray, mean: np.ndarray, slope: np.ndarray, places: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """Radiance less that of the patches' laws."""
    return np.asarray(values - mean * (1.0 + slope[0] * places[0]) * (1.0 + slope[1] * places[1]))


def _mean(values: np.ndarray) -> np.ndarray:
    return weighted_sum(weighted_sum(values, _WEIGHTS), _WEIGHTS)


def _sum(values: np.ndarray) -> float:
    """Sum in the order of the array; numpy's own differs between processors."""
    return float(np.cumsum(values)[-1]) if values.size else 0.0
