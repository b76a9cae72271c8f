"""Radiances in scattered directions, interpolated on the sphere by a thin-plate spline; and how well."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from aomc_sky.directions import sky_from_travel, travel_from_sky
from aomc_sky.errors import InputWarning

GLOBAL_POINTS = 1000  #: Up to so many directions one spline serves the sky; of more, each direction has its neighbours.
NEIGHBOURS = 32
_SMOOTHING = 1e-7  # keeps the spline solvable
_ONE_DEG = 0.2  #: Directions so near to each other are one, averaged: their noise would be a slope, and go on far away.
_THIN = 0.1  #: Spread across a plane, as a share of that along it, below which directions lie in one plane.
_STEP_DEG = 2.0  #: Step of the table that a cubic spline interpolates.
_PAD = 8  #: Steps by which the table goes on beyond zenith, horizon and the turn.
_DIGITS = 8  #: Digits of the table; the last ones of linear algebra differ between processors.
_SAMPLED = 300
_TREND_POINTS = 12
_MISFIT = 0.05  #: Of the trend's logarithm: no sky is exactly a trend.
_SIZE = 0.5  #: Standard deviation of the logarithm over the sky that each function of a trend may have.
_UNKNOWN = 0.3  #: Standard deviation of the logarithm where nothing was measured and no trend is known.
_SEEN_DEG = 15.0  #: Directions that are farther than this from all measured ones are extrapolated.
_FAR_DEG = 30.0  #: Distance at which the nearest measured direction tells nothing any more.
_MOST = 2.0  #: No radiance outside the sun's surroundings is above so many times the brightest one measured there.
_SURROUNDINGS_DEG = 10.0
_LEAST_CUT = 1e-4
_LARGEST = 100.0  #: Error of a logarithm that counts.
_CONTRAST = 4.0  #: Largest radiance over the mean, above which a sky wants more directions near the sun.
_NEAR_SUN_DEG = 20.0
_LARGE_ERROR = 0.05
MOST_EXTRAPOLATED = 0.05  #: Share of the light beyond the measured directions above which a person is warned.


class Interpolant(NamedTuple):
    """The interpolated radiance at one wavelength, and what is known of its error."""

    #: Spline coefficients of the logarithm, or of the root of the radiance where a measured one is 0.
    table: np.ndarray
    is_log: bool
    n_directions: int
    error: float  #: Root mean square over the light of the radiance's error, as a share; NaN of too few directions.
    worst_error: float  #: Of the measured directions, leave one out.
    worst_deg: tuple[float, float]  #: Zenith angle and azimuth of the latter.
    extrapolated: float  #: Share of the irradiance from beyond the measured directions.
    beyond_error: float  #: As `error`, there.
    cut: float  #: Share of the irradiance above `_MOST` times the brightest radiance, which is left out.
    wants_sun: bool  #: Whether directions near the sun are needed most.
    gap_deg: float  #: Angle between the direction that is farthest from all measured ones, and the nearest of these.

    def __call__(self, sky_zenith_rad: np.ndarray, sky_azimuth_rad: np.ndarray) -> np.ndarray:
        """Radiance of directions. [unit of the points]"""
        from scipy.ndimage import map_coordinates

        step = math.radians(_STEP_DEG)
        at = np.stack([sky_zenith_rad / step, np.mod(sky_azimuth_rad, 2 * np.pi) / step]) + _PAD
        value = map_coordinates(self.table, at.reshape(2, -1), prefilter=False, mode="nearest")
        return np.asarray((np.exp(value) if self.is_log else value * value).reshape(at.shape[1:]))


def interpolate(direction: np.ndarray, values: np.ndarray, sun: np.ndarray | None = None) -> tuple[Interpolant, ...]:
    """Interpolate radiances (n_wl, n) in directions (n, 3), three or more, all above 0 or each n_wl with a 0."""
    from scipy.ndimage import spline_filter
    from scipy.spatial import KDTree

    is_log, n = bool(np.all(values > 0)), len(direction)
    direction, level = _averaged(direction, (np.log(values) if is_log else np.sqrt(values)).T)
    values = values if len(direction) == n else (np.exp(level) if is_log else level * level).T
    steps = np.arange(_N_RINGS) * _STEP_DEG, np.arange(_N_COLUMNS) * _STEP_DEG
    zenith, azimuth = (angle.ravel() for angle in np.meshgrid(*steps, indexing="ij"))
    asked = -travel_from_sky(zenith, azimuth)
    trend = _Trend.of(direction, sun if n >= _TREND_POINTS and is_log else None, asked)
    shares = trend.fit @ level
    rest = level - trend.given @ shares
    inside, is_outside = _into_hull(direction, asked)
    points, splined = _spline(direction, rest, inside)
    tables = np.round(splined + trend.asked @ shares, _DIGITS).T
    distance = KDTree(direction).query(asked)[0]
    is_unseen = is_outside | (distance > 2 * math.sin(math.radians(_SEEN_DEG) / 2))
    chosen, errors = _leave_one_out(points, rest, trend)
    nearest = KDTree(direction[chosen]).query(asked)[1]
    root_error = ((level[chosen] - errors) ** 2 - level[chosen] ** 2) / np.maximum(values.mean(axis=1), 1e-300)
    off = np.abs(np.expm1(np.minimum(-errors, _LARGEST)) if is_log else root_error).T
    weight = np.sin(np.deg2rad(2 * zenith))
    made = []
    for k, (table, row) in enumerate(zip(tables, values, strict=True)):
        centre = direction[row.argmax()] if sun is None else sun
        bound = _bound(direction, row, sun, asked)
        cut_table = np.minimum(table, np.log(bound) if is_log else np.sqrt(bound))
        uncut, flux = ((np.exp(one) if is_log else one * one) * weight for one in (table, cut_table))
        known = np.where(np.isnan(off[k]), -1.0, off[k])
        worst, worst_error = chosen[known.argmax()], float(known.max()) if known.max() >= 0 else math.nan
        share = np.where(known < 0, worst_error, off[k])
        square = _largest_near(centre, direction[chosen], asked, share, share[nearest]) ** 2
        beyond = trend.variance(rest[:, k]) + max(float(rest[:, k].std()), _UNKNOWN * (trend.given.shape[1] == 1)) ** 2
        square += np.where(is_unseen, beyond * np.minimum(distance / math.radians(_FAR_DEG), 1.0), 0.0)
        suns = [direction[row.argmax()], centre]
        wants_sun = max(direction[worst] @ one for one in suns) > math.cos(math.radians(_NEAR_SUN_DEG))
        zenith_rad, azimuth_rad = sky_from_travel(-direction[worst])
        made.append(
            Interpolant(
                table=spline_filter(_padded(cut_table.reshape(_N_RINGS, _N_COLUMNS)), 3),
                is_log=is_log,
                n_directions=n,
                error=_mean_error(square, flux),
                worst_error=worst_error,
                worst_deg=(math.degrees(zenith_rad), math.degrees(azimuth_rad)),
                extrapolated=float(flux[is_unseen].sum() / flux.sum()) if flux.any() else 0.0,
                beyond_error=_mean_error(square[is_unseen], flux[is_unseen]),
                cut=float(1.0 - flux.sum() / uncut.sum()) if flux.any() else 0.0,
                wants_sun=bool(row.max() > _CONTRAST * row.mean() or (wants_sun and worst_error > _LARGE_ERROR)),
                gap_deg=math.degrees(2 * math.asin(min(distance.max() / 2, 1.0))),
            )
        )
    return tuple(made)


def _averaged(direction: np.ndarray, level: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions and levels (n, n_wl); up to `GLOBAL_POINTS` of them are averaged over those within `_ONE_DEG`."""
    from scipy.spatial import KDTree

    n, tree = len(direction), KDTree(direction)
    reach = 2 * math.sin(math.radians(_ONE_DEG) / 2)
    if n > GLOBAL_POINTS or not tree.query_pairs(reach):
        return direction, level
    first = np.full(n, -1)  # of those that are averaged with each
    for k, near in enumerate(tree.query_ball_point(direction, reach)):
        if first[k] < 0:
            first[[one for one in near if first[one] < 0]] = k
    _, group = np.unique(first, return_inverse=True)
    share = (group == np.arange(group.max() + 1)[:, None]) / np.bincount(group)[:, None]
    middle = share @ direction
    return middle / np.linalg.norm(middle, axis=1, keepdims=True), share @ level


def _spline(direction: np.ndarray, rest: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions on the axes along which they spread, and the values (n, n_wl) of their spline `at` other ones."""
    from scipy.interpolate import RBFInterpolator

    middle = direction.mean(axis=0)
    _, spread, axes = np.linalg.svd(direction - middle, full_matrices=False)
    axes = axes[: max(2, int(np.sum(spread > _THIN * spread[0])))].T  # directions in one plane know its axes alone
    points = (direction - middle) @ axes
    how: dict[str, Any] = {"kernel": "thin_plate_spline", "smoothing": _SMOOTHING}
    if len(direction) > GLOBAL_POINTS:  # neighbours may lie in one plane, which the distance alone allows
        how |= {"kernel": "linear", "neighbors": NEIGHBOURS}
    return points, RBFInterpolator(points, rest, **how)((at - middle) @ axes)


def _largest_near(
    centre: np.ndarray, direction: np.ndarray, asked: np.ndarray, share: np.ndarray, found: np.ndarray
) -> np.ndarray:
    """The errors `found` where asked; around a bright centre the largest `share` of the directions near it."""
    near = share[direction @ centre > math.cos(math.radians(_NEAR_SUN_DEG))]
    is_near = asked @ centre > math.cos(math.radians(_SURROUNDINGS_DEG))
    return np.where(is_near, near.max(initial=0.0), found)


def _mean_error(square: np.ndarray, flux: np.ndarray) -> float:
    return math.sqrt(float(square @ flux) / float(flux.sum())) if flux.any() else 0.0


def _bound(direction: np.ndarray, row: np.ndarray, sun: np.ndarray | None, asked: np.ndarray) -> np.ndarray:
    """Bound of the radiance where asked: `_MOST` times the brightest measured one.

    In the sun's surroundings that of all directions counts, elsewhere that of those outside of them.
    """
    if sun is None:
        return np.full(len(asked), _MOST * row.max())
    far = row[direction @ sun < math.cos(math.radians(_SURROUNDINGS_DEG))].max(initial=0.0)
    # a cubic spline joins the nodes, so that the nearest ones inside the edge have the bound of outside, too
    is_far = asked @ sun < math.cos(math.radians(_SURROUNDINGS_DEG - 1.5 * _STEP_DEG))
    return _MOST * np.where(is_far & (far > 0), far, row.max())


_N_RINGS, _N_COLUMNS = round(90 / _STEP_DEG) + 1, round(360 / _STEP_DEG)


def _padded(table: np.ndarray) -> np.ndarray:
    """The table with what lies across the zenith, the turn, and the horizon, where it goes on as it came."""
    across = np.roll(table[_PAD:0:-1], _N_COLUMNS // 2, axis=1)
    beyond = 2 * table[-1] - table[-2 : -2 - _PAD : -1]
    return np.pad(np.vstack([across, table, beyond]), ((0, 0), (_PAD, _PAD + 1)), mode="wrap")


class _Trend(NamedTuple):
    """A mean, and smooth functions of the zenith angle and of the angle to the sun, fitted by ridge regression.

    Functions have the standard deviation 1 over the sky, so that the penalty (`_MISFIT` / `_SIZE`)^2 keeps a function
    small of which the directions see little, as the zenith angle of an almucantar.
    """

    given: np.ndarray  #: Functions in the measured directions, shape (n, n_function), the constant first.
    asked: np.ndarray  #: The same where asked.
    inverse: np.ndarray  #: Of the penalised normal equations.

    @classmethod
    def of(cls, direction: np.ndarray, sun: np.ndarray | None, asked: np.ndarray) -> _Trend:
        """The trend around a sun, or the mean alone."""

        def functions(at: np.ndarray) -> np.ndarray:
            if sun is None:
                return np.zeros((len(at), 0))
            mu, cosine = at[:, 2].clip(0.0), (at @ sun).clip(-1.0, 1.0)
            angle = np.arccos(cosine)
            aureole, halo = np.exp(-angle / 0.17), np.exp(-angle / 0.5)  # 10 and 29 degrees wide
            return np.stack([mu, 1 / (mu + 0.2), angle, angle**2, aureole, halo, cosine**2], axis=1)

        given, everywhere = functions(direction), functions(asked)
        mean, scale = everywhere.mean(axis=0), everywhere.std(axis=0)
        given, everywhere = (np.column_stack([np.ones(len(one)), (one - mean) / scale]) for one in (given, everywhere))
        penalty = np.full(given.shape[1], (_MISFIT / _SIZE) ** 2)
        penalty[0] = 0.0
        return cls(given, everywhere, np.linalg.inv(given.T @ given + np.diag(penalty)))

    @property
    def fit(self) -> np.ndarray:
        """Coefficients of the functions for levels, shape (n_function, n)."""
        return self.inverse @ self.given.T

    def variance(self, rest: np.ndarray) -> np.ndarray:
        """Variance of the trend where asked, for the levels that it leaves."""
        size = max(_MISFIT**2, float(np.mean(rest**2)))
        return np.asarray(size * np.einsum("ij,jk,ik->i", self.asked, self.inverse, self.asked))


def _into_hull(direction: np.ndarray, asked: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For directions asked (n, 3): themselves, or the nearest of the measured hull; and which lie outside of it.

    The stereographic projection from below maps circles to circles and the horizon to the unit circle.
    """
    from scipy.spatial import ConvexHull, QhullError

    points, at = (x[:, :2] / (1 + x[:, 2:]) for x in (direction, asked))
    try:
        hull = ConvexHull(points)
        corners = points[hull.vertices]
        is_outside = (at @ hull.equations[:, :2].T + hull.equations[:, 2]).max(axis=1) > 1e-9
    except QhullError:  # on one line, as the principal plane
        middle = points.mean(axis=0)
        axis = np.linalg.svd(points - middle)[2][0]
        along = (points - middle) @ axis
        corners = middle + np.array([[along.min()], [along.max()]]) * axis
        is_outside = np.ones(len(at), bool)
    edge = np.roll(corners, -1, axis=0) - corners
    from_corner = at[is_outside, None] - corners
    part = np.clip((from_corner * edge).sum(-1) / (edge * edge).sum(-1), 0.0, 1.0)
    beyond = from_corner - part[..., None] * edge
    best = (beyond * beyond).sum(-1).argmin(axis=1)
    near = at[is_outside] - beyond[np.arange(len(best)), best]
    square = (near * near).sum(axis=1, keepdims=True)
    inside = asked.copy()
    inside[is_outside] = np.hstack([2 * near, 1 - square]) / (1 + square)
    return inside, is_outside


def _leave_one_out(points: np.ndarray, rest: np.ndarray, trend: _Trend) -> tuple[np.ndarray, np.ndarray]:
    """Points (at most `_SAMPLED`), and errors (n, n_wl) of their levels by the other points: Rippa (1999), eq. (17).

    The trend is fitted again without the point: its coefficients are less by `fit` of the point times its rest over
    1 - leverage. NaN where the other points are too few to tell.
    """
    from scipy.spatial import KDTree
    from scipy.spatial.distance import cdist
    from scipy.special import xlogy

    def errors(x: np.ndarray, y: np.ndarray, *, is_local: bool = False) -> np.ndarray:
        distance = cdist(x, x)
        ones = np.ones((len(x), 1)) if is_local else np.column_stack([np.ones(len(x)), x])
        kernel = -distance if is_local else xlogy(distance * distance, distance)
        kernel += _SMOOTHING * np.eye(len(x))
        matrix = np.block([[kernel, ones], [ones.T, np.zeros((ones.shape[1],) * 2)]])
        inverse = np.linalg.inv(matrix)[: len(x), : len(x)]
        diagonal = np.diag(inverse)[:, None]
        is_free = np.abs(diagonal) > 1e-6  # without this point the others have no plane of their own
        error = inverse @ y
        if not is_local:
            leverage = np.sum(trend.given * trend.fit.T, axis=1)[:, None]
            error += np.sum((inverse @ trend.given) * trend.fit.T, axis=1)[:, None] * (y / (1.0 - leverage))
        return np.divide(error, diagonal, out=np.full_like(y, np.nan), where=np.broadcast_to(is_free, y.shape))

    if len(rest) <= GLOBAL_POINTS:
        return np.arange(len(rest)), errors(points, rest)
    chosen = np.arange(_SAMPLED) * len(rest) // _SAMPLED  # one of so many points moves the trend little
    _, near = KDTree(points).query(points[chosen], k=NEIGHBOURS + 1)
    return chosen, np.stack([errors(points[some], rest[some], is_local=True)[0] for some in near])


def known_of(parts: Sequence[Interpolant]) -> str:
    """How well the light is known, in few words: the largest error and share of all wavelengths."""
    error = max((part.error for part in parts if not math.isnan(part.error)), default=math.nan)
    known = "errors unknown" if math.isnan(error) else f"radiances known to {percent(error)}"
    return f"{known}; {percent(max(part.extrapolated for part in parts))} of the light extrapolated"


def notes_of(parts: Sequence[Interpolant], *, has_sun: bool = False) -> tuple[str, ...]:
    """Method and errors of the interpolation, the largest of all wavelengths."""
    worst = max(parts, key=lambda part: -1.0 if math.isnan(part.error) else part.error)
    beyond = max(parts, key=lambda part: part.extrapolated)
    error = "their errors cannot be told from so few"
    if not math.isnan(worst.error):
        error = (
            f"a radiance is off by {percent(worst.error)} (root mean square, weighted by the light); "
            f"leave-one-out error: at most {percent(worst.worst_error)} (zenith angle "
            f"{worst.worst_deg[0]:.0f}, azimuth {worst.worst_deg[1]:.0f})"
        )
    if any(part.wants_sun for part in parts):
        error += "; directions near the sun are needed most"
    n = sorted({part.n_directions for part in parts})
    counts = f"{n[0]}" if len(n) == 1 else f"{n[0]} to {n[-1]}"
    return (
        f"{counts} directions, interpolated by a thin-plate spline of their unit vectors"
        f"{' on a trend around the sun' if has_sun else ''}; {error}",
        f"{percent(beyond.extrapolated)} of the light comes from beyond the measured directions, where it may be off "
        f"by {percent(beyond.beyond_error)}; the widest gap is {beyond.gap_deg:.0f} degrees from the nearest one",
    )


def percent(share: float) -> str:
    """Two digits, and never a power of ten."""
    return f"{float(f'{100 * share:.2g}'):g} %"


def warn_of_extrapolation(parts: Sequence[Interpolant], *, has_sun: bool = False) -> None:
    """Warn of light from beyond the measured directions, above `MOST_EXTRAPOLATED`."""
    cut = max(part.cut for part in parts)
    if cut > _LEAST_CUT:
        warnings.warn(
            f"measured sky: {percent(cut)} of the light that was interpolated is left out: no radiance is above "
            f"{_MOST:g} times the brightest one measured more than {_SURROUNDINGS_DEG:g} degrees from the sun",
            InputWarning,
            stacklevel=5,
        )
    share = max(part.extrapolated for part in parts)
    if share > MOST_EXTRAPOLATED:
        advice = (
            "; say where the sun is (--sun-zenith and --sun-azimuth, sun_zenith_deg= and sun_azimuth_deg=), and a "
            "trend around it serves there"
        )
        warnings.warn(
            f"measured sky: {percent(share)} of the light comes from beyond the measured directions, where it is "
            f"extrapolated and may be off by {percent(max(part.beyond_error for part in parts))}"
            + ("" if has_sun else advice),
            InputWarning,
            stacklevel=5,
        )
