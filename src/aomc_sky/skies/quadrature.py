"""Integrals of a sky over patches by one adaptive Gauss rule, in plain numpy.

The flux through a horizontal plane from a patch is the integral of L(x, y) sin x cos x dx dy, with the zenith angle x
and the azimuth y. Two orders of Gauss points integrate a patch. If they disagree, orders 5 and 8 follow, and then the
patch is cut in halves or quarters until those agree. Only sums, products and roots are used: BLAS, einsum and
numpy's own reductions may have other last digits on another processor.

Angles are in quarter turns and count from a centre, the sun or the axis of a lobe, so that they keep all their digits
beside it. Patches are cut there: a sharp feature lies in a corner. A sky may end, or have a kink, at circles about the
centre. Patches that a circle crosses are cut along it: their azimuths end at the circle.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from aomc_sky.grid import PatchGrid
from aomc_sky.kernels.arithmetic.elementary import HALF_PI, arc, half_sine2, sin_cos

#: Least and greatest x, least and greatest y of tiles: four arrays that broadcast, or one of shape (4, n).
Edges = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray] | np.ndarray
Terms = tuple[np.ndarray, ...]
#: Integrand over x and y from terms of x, terms of y and the indices of patches, which broadcast.
Integrand = Callable[[Terms, Terms, np.ndarray], np.ndarray]
#: Integrand at points (x, y) seen from the centre, of what has these indices.
Values = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
#: The terms at angles seen from the centre.
TermsOf = Callable[[np.ndarray], Terms]

_POINTS_AT_ONCE = 2**13  # the temporary arrays stay in the cache
_MAX_ROUNDS = 60
_EVEN = 8.0  # a part is quartered if its two directions differ less, else halved
_NOTHING = 1e-15  # the shortest side of a part [quarter turns]

_LOOSE = 100.0
"""The difference of orders 3 and 4 is the error of order 3: it may be larger than what is allowed to order 4."""

_FAR = 5.0
"""Order 4 is only taken this many lengths away from a sharp centre: nearer to it two low orders agree by accident."""

_PILOT = 1e-3
"""Share to which the orders agree on the pilot of a sky."""

_CORNER = 2e-6
"""Error of order 8 for the distance from a corner of a square, as a share of the third power of its side."""

# Gauss points and weights on (0, 1) from 40 digits, the first halves: numpy computes them with LAPACK, which may differ
_FIRST_HALVES = {
    3: ((0.11270166537925831, 0.5), (0.2777777777777778, 0.4444444444444444)),
    4: ((0.06943184420297371, 0.33000947820757187), (0.17392742256872692, 0.32607257743127305)),
    5: (
        (0.04691007703066800, 0.23076534494715845, 0.5),
        (0.11846344252809454, 0.23931433524968324, 0.28444444444444444),
    ),
    7: (
        (0.025446043828620736, 0.12923440720030277, 0.2970774243113014, 0.5),
        (0.06474248308443485, 0.13985269574463835, 0.19091502525255946, 0.20897959183673468),
    ),
    8: (
        (0.019855071751231884, 0.10166676129318664, 0.2372337950418355, 0.4082826787521751),
        (0.05061426814518813, 0.11119051722668724, 0.15685332293894363, 0.181341891689181),
    ),
}


class _Points(NamedTuple):
    nodes: np.ndarray
    weights: np.ndarray
    highest: np.ndarray  #: Weights of the coefficient of the highest Legendre polynomial that the points can tell.


def _points(order: int) -> _Points:
    nodes, weights = (np.array(half) for half in _FIRST_HALVES[order])
    nodes = np.concatenate([nodes, 1.0 - nodes[: order // 2][::-1]])
    weights = np.concatenate([weights, weights[: order // 2][::-1]])
    t = 2.0 * nodes - 1.0
    before, highest = np.ones(order), t
    for k in range(2, order):
        before, highest = highest, ((2 * k - 1) * t * highest - (k - 1) * before) / k
    return _Points(nodes, weights, weights * highest)


POINTS = {order: _points(order) for order in _FIRST_HALVES}


def weighted_sum(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Sum over the first axis, in the order of the axis."""
    total = weights[0] * values[0]
    for k in range(1, len(weights)):
        total = total + weights[k] * values[k]
    return total


def quarter_turns(grid: PatchGrid) -> tuple[np.ndarray, np.ndarray]:
    """Edges of rings (n_zenith, 2) and columns (n_azimuth, 2). [quarter turns]"""
    return grid.zenith_bounds_deg / 90.0, grid.azimuth_bounds_deg / 90.0


def centres_deg(grid: PatchGrid) -> np.ndarray:
    """Zenith angles and azimuths of the centres of patches, shape (2, n_zenith, n_azimuth). [deg]"""
    middles = (bounds.mean(axis=1) for bounds in (grid.zenith_bounds_deg, grid.azimuth_bounds_deg))
    return np.stack(np.meshgrid(*middles, indexing="ij"))


def zeniths_at(grid: PatchGrid, share: np.ndarray) -> np.ndarray:
    """Zenith angles at shares of the growth of sin^2 in each ring, shape (n_zenith, n). [rad]"""
    near, growth, far = (each[:, None] for each in grid.ring_sin2())
    return np.asarray(np.arctan2(np.sqrt(near + growth * share), np.sqrt(far + growth * (1 - share))))


def angles_at(bounds_rad: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Angles at shares of the way between bounds (n, 2), shape (n, n_share)."""
    return np.asarray(bounds_rad[:, :1] + (bounds_rad[:, 1:] - bounds_rad[:, :1]) * share)


class Parts(NamedTuple):
    """Parts of patches, and their integrals."""

    tiles: np.ndarray  #: Least and greatest x, least and greatest y, shape (4, n_part).
    patch: np.ndarray
    mass: np.ndarray
    error_estimate: np.ndarray  #: Difference of the two orders.

    @classmethod
    def joined(cls, parts: Iterable[Parts]) -> Parts:
        """All of them, one after the other."""
        return cls(*(np.concatenate(columns, axis=-1) for columns in zip(*parts, strict=True)))

    def masses(self, n_patches: int) -> np.ndarray:
        """The integral over each patch, part after part."""
        total = np.zeros(n_patches)
        np.add.at(total, self.patch, self.mass)
        return total


@dataclass(frozen=True, kw_only=True, slots=True)
class Rule:
    """How the light of a sky is integrated."""

    integrand: Integrand
    x_terms: TermsOf = lambda x: (x,)
    y_terms: TermsOf = lambda y: (y,)
    #: A light with long tails: a part is cut until its orders agree roughly on this, so that no narrow ridge is missed.
    pilot: Integrand | None = None
    centre: tuple[float, float] = (0.0, 0.0)  #: Zenith angle and azimuth that points count from. [quarter turns]
    #: Width of what is sharp at the centre. A longer part must be farther away than its length. [rad]
    width: float = np.inf
    cusp: float = 0.0  #: Slope of the light at the centre, where it is a cone. [per rad]
    circles: Sequence[float] = ()  #: sin^2 of half the radii of circles about the centre, ascending.
    marks: Sequence[float] | np.ndarray = ()  #: Zenith angles where all patches are cut. [quarter turns]
    y_marks: Sequence[float] | np.ndarray = ()  #: Azimuths, from the centre, where all patches are cut. [0 to 8]
    share: float = 1e-11  #: Error of a patch: a share of itself,
    floor: float = 1e-15  #: one of all patches together,
    error: float = 0.0  #: and this.
    first: tuple[int, int] = (3, 4)  #: Orders of the first look at a patch.
    most_parts: int = 2**20

    def integrate(self, zenith: np.ndarray, azimuth: np.ndarray, known: np.ndarray | float = 0.0) -> Parts:
        """Integrate over rings x columns, edges (n, 2) in quarter turns; patches count ring after ring.

        `known` is a part of their masses that is not in the light; errors are shares of the whole.
        """
        x, ring = cut(zenith - self.centre[0], np.concatenate([[0.0], np.asarray(self.marks) - self.centre[0]]))
        start = azimuth[:, :1] - self.centre[1]
        turned = azimuth - self.centre[1] - 4.0 * np.floor(0.25 * start)
        y, column = cut(turned, np.concatenate([np.arange(9.0), self.y_marks]))
        y -= 4.0 * np.rint(0.125 * (y[:, :1] + y[:, 1:]))
        edges = x[:, :1], x[:, 1:], y[:, 0], y[:, 1]
        patch = ring[:, None] * len(azimuth) + column
        mass, error_estimate = self._first_look(edges, patch)
        rough = np.zeros(len(zenith) * len(azimuth))
        np.add.at(rough, patch, mass)
        rough = np.abs(rough + known)
        allowed = self.share * rough + self.floor * (float(np.cumsum(rough)[-1]) if rough.size else 0.0) + self.error
        is_crossed = self._is_crossed(edges)
        good = (
            ~is_crossed
            & (self.pilot is None)
            & (error_estimate <= _LOOSE * allowed[patch])
            & self._may_agree(edges, allowed[patch], 1.0 / _FAR)
        )
        tiles = np.stack(np.broadcast_arrays(*edges))
        done = [Parts(tiles[:, good], patch[good], mass[good], error_estimate[good])]
        rest = ~good & ~is_crossed
        done.append(self.refined(tiles[:, rest], patch[rest], allowed))
        if is_crossed.any():
            done.append(self._along_circles(tiles[:, is_crossed], patch[is_crossed], allowed))
        return Parts.joined(done)

    def _first_look(self, edges: Edges, patch: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Integrals over rings x columns by the higher order, and how far the lower one is away."""
        both = np.zeros((2, *patch.shape))
        for order, mass in zip(self.first, both, strict=True):
            x, y = _at_nodes(order, edges[0], edges[1]), _at_nodes(order, edges[2], edges[3])
            x_terms, y_terms = self.x_terms(x), tuple(term[None, :, None] for term in self.y_terms(y))
            n_rows = max(1, _POINTS_AT_ONCE // (order * order * max(patch.shape[1], 1)))
            for k in range(0, len(patch), n_rows):
                rows = slice(k, k + n_rows)
                values = self.integrand(tuple(term[:, None, rows] for term in x_terms), y_terms, patch[rows])
                mass[rows] = _mean(values, order)
        both *= (edges[1] - edges[0]) * (edges[3] - edges[2])
        return both[1], np.abs(both[1] - both[0])

    def values_of(self, integrand: Integrand) -> Values:
        """The integrand at points seen from the centre."""
        return lambda x, y, patch: integrand(self.x_terms(x), self.y_terms(y), patch)

    def refined(
        self,
        tiles: np.ndarray,
        patch: np.ndarray,
        allowed: np.ndarray,
        *,
        index: np.ndarray | None = None,
        mapped: Callable[[Values], Values] = lambda values: values,
    ) -> Parts:
        """Integrate parts of patches by orders 5 and 8, and cut where they disagree; `allowed` is the error of a patch.

        Parts are seen from the centre. With `mapped`, which turns values at angles into those of an `index` here, they
        are in other coordinates.
        """
        in_angles = index is None
        index = patch if index is None else index
        done = [Parts(tiles[:, :0], patch[:0], np.zeros(0), np.zeros(0))]
        n_left = self.most_parts
        for k in range(_MAX_ROUNDS):
            mass, error_estimate, roughness = _by_two_orders(mapped(self.values_of(self.integrand)), tiles, index)
            good = error_estimate <= allowed[patch]
            if self.pilot is not None:
                whole, rest, roughness_of_pilot = _by_two_orders(mapped(self.values_of(self.pilot)), tiles, index)
                is_seen = rest <= np.maximum(_PILOT * whole, allowed[patch])
                good &= is_seen
                roughness = np.where(is_seen, roughness, roughness_of_pilot)
            if in_angles:
                may_agree = self._may_agree(tiles, allowed[patch], 1.0)
                good &= may_agree
                roughness = np.where(may_agree, roughness, self._sides(tiles))
            n_left -= int(np.count_nonzero(good))
            if 4 * np.count_nonzero(~good) > n_left or k == _MAX_ROUNDS - 1:
                good[:] = True
            done.append(Parts(tiles[:, good], patch[good], mass[good], error_estimate[good]))
            if good.all():
                break
            tiles, owner = _halved(tiles[:, ~good], roughness[:, ~good])
            index, patch = index[~good][owner], patch[~good][owner]
            if in_angles:  # parts that may not agree for sure are cut at once
                near = ~self._may_agree(tiles, allowed[patch], 1.0)
                halves, owner = _halved(tiles[:, near], np.stack(self._sides(tiles[:, near])))
                tiles = np.concatenate([tiles[:, ~near], halves], axis=1)
                index = np.concatenate([index[~near], index[near][owner]])
                patch = np.concatenate([patch[~near], patch[near][owner]])
        return Parts.joined(done)

    def _may_agree(self, edges: Edges, allowed: np.ndarray, reach: float) -> np.ndarray:
        """Whether tiles are so short, or so far from the centre, that nothing sharp hides between their points."""
        if self.width == np.inf and not self.cusp:
            return np.ones(allowed.shape, dtype=bool)
        x, y = 0.5 * (edges[0] + edges[1]), 0.5 * (edges[2] + edges[3])
        length = np.maximum(*self._sides(edges))
        h = half_sine2(x) + (sin_cos(x + self.centre[0])[0] * self._sine()) * half_sine2(y)
        if self.cusp:  # which is at the opposite point, too
            h = np.minimum(h, 1.0 - h)
        is_short = (length <= self.width) & (_CORNER * self.cusp * (length * length * length) <= allowed)
        near = (0.5 / reach) * length
        return is_short | (h >= near * near)

    def _sides(self, edges: Edges) -> tuple[np.ndarray, np.ndarray]:
        """Lengths of tiles along zenith angle and azimuth. [rad]"""
        x0, x1, y0, y1 = edges
        sines = [sin_cos(x + self.centre[0])[0] for x in (x0, x1)]
        return (x1 - x0) * HALF_PI, np.maximum(*sines) * (y1 - y0) * HALF_PI

    def _sine(self) -> float:
        return float(sin_cos(np.array([self.centre[0]]))[0][0])

    def _is_crossed(self, edges: Edges) -> np.ndarray:
        """Whether a circle may cross a tile."""
        x, y = np.stack([edges[0], edges[1]]), np.stack([edges[2], edges[3]])
        near, far = np.sort(half_sine2(x), axis=0), np.sort(half_sine2(y), axis=0)
        growth = np.sort(sin_cos(x + self.centre[0])[0], axis=0) * self._sine()
        low, high = near[0] + growth[0] * far[0], near[1] + growth[1] * far[1]
        crossed = np.zeros(low.shape, dtype=bool)
        for circle in self.circles:
            crossed |= (low <= circle) & (circle <= high)
        return crossed

    def _along_circles(self, tiles: np.ndarray, patch: np.ndarray, allowed: np.ndarray) -> Parts:
        """Integrate tiles that circles cross, band after band between the circles, cut where those cross an edge."""
        n_bands = len(self.circles) + 1
        ends = self._crossings(tiles)
        owner, k = np.nonzero(np.diff(ends, axis=1) > _NOTHING)
        x0, x1 = np.repeat(ends[owner, k], n_bands), np.repeat(ends[owner, k + 1], n_bands)
        owner, band = np.repeat(owner, n_bands), np.tile(np.arange(n_bands), owner.size)
        y0, y1 = np.sort(np.abs(tiles[2:, owner]), axis=0)
        side = np.where(tiles[2, owner] + tiles[3, owner] < 0.0, -1.0, 1.0)
        radii = np.array([0.0, *self.circles, 1.0])

        def mapped(values: Values) -> Values:
            def along(t: np.ndarray, share: np.ndarray, seed: np.ndarray) -> np.ndarray:
                width = x1[seed] - x0[seed]
                x = x0[seed] + width * (t * t * (3.0 - 2.0 * t))  # powers 3/2 at the ends become whole ones
                growth = np.maximum(sin_cos(x + self.centre[0])[0] * self._sine(), 1e-300)
                # azimuths where both circles cross the ring x; 0 or 2 where all of it is outside or inside
                shares = (np.clip((radii[band[seed] + i] - half_sine2(x)) / growth, 0.0, 1.0) for i in (0, 1))
                inner, outer = (np.clip(arc(each) / HALF_PI, y0[seed], y1[seed]) for each in shares)
                value = values(x, side[seed] * (inner + (outer - inner) * share), patch[owner[seed]])
                return value * (outer - inner) * (width * 6.0 * t * (1.0 - t))

            return along

        n = owner.size
        unit = np.stack([np.zeros(n), np.ones(n), np.zeros(n), np.ones(n)])
        return self.refined(unit, patch[owner], allowed, index=np.arange(n), mapped=mapped)

    def _crossings(self, tiles: np.ndarray) -> np.ndarray:
        """Zenith angles from the first to the last of each tile where a circle begins, ends or crosses a side.

        On a line of constant azimuth the cosine of the distance is r cos(x - x_r), so that its crossings are known.
        """
        x0, x1, y0, y1 = tiles
        at = [x0, x1]
        sine, cosine = sin_cos(np.array([self.centre[0]]))
        for circle in self.circles:
            angle = float(arc(np.array([circle]))[0]) / HALF_PI
            tops = (angle, -angle, angle - 2.0 * self.centre[0])
            at += [np.full(x0.size, top) for top in tops]
            for y in (y0, y1):
                cos_y = sin_cos(y)[1]
                sideways = sine * cos_y
                r = np.maximum(np.sqrt(cosine * cosine + sideways * sideways), 1e-300)
                x_r = np.copysign(arc(0.5 * (1.0 - cosine / r)), cos_y) / HALF_PI - self.centre[0]
                reach = arc(np.clip(0.5 * (1.0 - (1.0 - 2.0 * circle) / r), 0.0, 1.0)) / HALF_PI
                at += [x_r + reach, x_r - reach]
        return np.sort(np.clip(np.stack(at, axis=1), x0[:, None], x1[:, None]), axis=1)


def _at_nodes(order: int, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The points between edges, along a new first axis."""
    return low + (high - low) * POINTS[order].nodes.reshape(order, *(1,) * low.ndim)


def points_of(order: int, edges: Edges) -> tuple[np.ndarray, np.ndarray]:
    """The order x order points of tiles, x and y, which broadcast to (order, order, ...): first along x."""
    x0, x1, y0, y1 = edges
    return _at_nodes(order, x0, x1)[:, None], _at_nodes(order, y0, y1)[None]


def _mean(values: np.ndarray, order: int) -> np.ndarray:
    weights = POINTS[order].weights
    return weighted_sum(weighted_sum(values, weights), weights)


def _by_two_orders(values: Values, tiles: np.ndarray, index: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Integrals by order 8, how far order 5 is away, and how much may be unseen along x and y, shape (2, n)."""
    mass, error_estimate, roughness = np.zeros(index.size), np.zeros(index.size), np.zeros((2, index.size))
    _, weights, highest = POINTS[8]
    for k in range(0, index.size, _POINTS_AT_ONCE // 64):
        some = slice(k, k + _POINTS_AT_ONCE // 64)
        at_5, at_8 = (values(*points_of(order, tiles[:, some]), index[some]) for order in (5, 8))
        mass[some] = _mean(at_8, 8)
        error_estimate[some] = np.abs(mass[some] - _mean(at_5, 5))
        for axis in (0, 1):
            roughness[axis, some] = np.abs(weighted_sum(weighted_sum(np.moveaxis(at_8, axis, 1), weights), highest))
    area = (tiles[1] - tiles[0]) * (tiles[3] - tiles[2])
    return mass * area, error_estimate * area, roughness


def cut(edges: np.ndarray, marks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges (n, 2) cut at marks: the parts with an extent, and whose parts they are."""
    ends = np.sort(np.concatenate([edges, np.clip(marks, edges[:, :1], edges[:, 1:])], axis=1), axis=1)
    owner, k = np.nonzero(np.diff(ends, axis=1) > _NOTHING)
    return np.stack([ends[owner, k], ends[owner, k + 1]], axis=1), owner


def _halved(tiles: np.ndarray, roughness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Halves of tiles across the direction in which they are rougher, or quarters; and whose parts they are."""
    owner = np.arange(tiles.shape[1])
    for axis, is_cut in enumerate((_EVEN * roughness[0] >= roughness[1], _EVEN * roughness[1] >= roughness[0])):
        chosen = is_cut[owner]
        middle = 0.5 * (tiles[2 * axis] + tiles[2 * axis + 1])
        first, second = tiles.copy(), tiles[:, chosen]
        first[2 * axis + 1, chosen] = second[2 * axis] = middle[chosen]
        tiles, owner = np.concatenate([first, second], axis=1), np.concatenate([owner, owner[chosen]])
    return tiles, owner
