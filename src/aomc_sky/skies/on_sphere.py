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
_SMOOTHING = 1e-7  # two measurements of almost one direction are averaged
_THIN = 0.02  #: Spread across a plane, as a share of that along it, below which directions lie in one plane.
_STEP_DEG = 2.0  #: Step of the table that a cubic spline interpolates.
_PAD = 8  #: Steps by which the table goes on beyond zenith, horizon and the turn.
_DIGITS = 8  #: Digits of the table; the last ones of linear algebra differ between processors.
_SAMPLED = 300
_TREND_POINTS = 12
_CONTRAST = 4.0  #: Largest radiance over the mean, above which a sky wants more directions near the sun.
_NEAR_SUN_DEG = 20.0
_LARGE_ERROR = 0.05
MOST_EXTRAPOLATED = 0.05  #: Share of the light beyond the measured directions above which a person is warned.


class Interpolant(NamedTuple):
    """The interpolated radiance at one wavelength, and what is known of its error."""

    table: (
        np.ndarray
    )  #: Spline coefficients of the logarithm, or of the root of the radiance where a measured one is 0.
    is_log: bool
    n_directions: int
    error: float  #: Root mean square of the leave-one-out errors, as shares of the radiance; NaN of too few directions.
    worst_error: float
    worst_deg: tuple[float, float]  #: Zenith angle and azimuth of the latter.
    extrapolated: float  #: Share of the irradiance from beyond the measured directions.
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
    """Interpolate radiances (n_wl, n) in directions (n, 3), three or more, none of n_wl dark everywhere."""
    from scipy.interpolate import RBFInterpolator
    from scipy.ndimage import spline_filter
    from scipy.spatial import KDTree

    is_log, n = np.all(values > 0, axis=1), len(direction)
    level = np.where(is_log[:, None], np.log(np.where(values > 0, values, 1.0)), np.sqrt(values)).T
    steps = np.arange(_N_RINGS) * _STEP_DEG, np.arange(_N_COLUMNS) * _STEP_DEG
    zenith, azimuth = (angle.ravel() for angle in np.meshgrid(*steps, indexing="ij"))
    asked = -travel_from_sky(zenith, azimuth)
    trend, asked_trend = np.zeros_like(level), np.zeros((len(asked), len(values)))
    if sun is not None and n >= _TREND_POINTS:
        trend, asked_trend = (part * is_log for part in _trend(direction, level, sun, asked))
    middle = direction.mean(axis=0)
    _, spread, axes = np.linalg.svd(direction - middle, full_matrices=False)
    axes = axes[: max(2, int(np.sum(spread > _THIN * spread[0])))].T  # directions in one plane know its axes alone
    points = (direction - middle) @ axes
    inside, is_outside = _into_hull(direction, asked)
    how: dict[str, Any] = {"kernel": "thin_plate_spline", "smoothing": _SMOOTHING}
    if n > GLOBAL_POINTS:  # neighbours may lie in one plane, which the distance alone allows
        how |= {"kernel": "linear", "neighbors": NEIGHBOURS}
    spline = RBFInterpolator(points, level - trend, **how)
    tables = np.round(spline((inside - middle) @ axes) + asked_trend, _DIGITS).T
    gap = math.degrees(2 * math.asin(min(KDTree(direction).query(asked)[0].max() / 2, 1.0)))
    chosen, errors = _leave_one_out(points, level - trend)
    of_root = ((level[chosen] - errors) ** 2 - level[chosen] ** 2) / np.maximum(values.mean(axis=1), 1e-300)
    shares = np.abs(np.where(is_log, np.expm1(-errors), of_root)).T
    made = []
    for table, has_log, share, row in zip(tables, is_log.tolist(), shares, values, strict=True):
        is_known = ~np.isnan(share)
        worst_error = float(share[is_known].max()) if is_known.any() else math.nan
        worst = chosen[np.where(is_known, share, -1.0).argmax()]
        brightest = [direction[row.argmax()], *([] if sun is None else [sun])]
        is_near = max(direction[worst] @ one for one in brightest) > math.cos(math.radians(_NEAR_SUN_DEG))
        zenith_rad, azimuth_rad = sky_from_travel(-direction[worst])
        flux = (np.exp(table) if has_log else table * table) * np.sin(np.deg2rad(2 * zenith))
        made.append(
            Interpolant(
                table=spline_filter(_padded(table.reshape(_N_RINGS, _N_COLUMNS)), 3),
                is_log=has_log,
                n_directions=n,
                error=float(np.sqrt(np.mean(share[is_known] ** 2))) if is_known.any() else math.nan,
                worst_error=worst_error,
                worst_deg=(math.degrees(zenith_rad), math.degrees(azimuth_rad)),
                extrapolated=float(flux[is_outside].sum() / flux.sum()) if flux.any() else 0.0,
                wants_sun=bool(row.max() > _CONTRAST * row.mean() or (is_near and worst_error > _LARGE_ERROR)),
                gap_deg=gap,
            )
        )
    return tuple(made)


_N_RINGS, _N_COLUMNS = round(90 / _STEP_DEG) + 1, round(360 / _STEP_DEG)


def _padded(table: np.ndarray) -> np.ndarray:
    """The table with what lies across the zenith, the turn, and the horizon, where it goes on as it came."""
    across = np.roll(table[_PAD:0:-1], _N_COLUMNS // 2, axis=1)
    beyond = 2 * table[-1] - table[-2 : -2 - _PAD : -1]
    return np.pad(np.vstack([across, table, beyond]), ((0, 0), (_PAD, _PAD + 1)), mode="wrap")


def _trend(
    direction: np.ndarray, level: np.ndarray, sun: np.ndarray, asked: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Least squares of smooth functions of zenith angle and angle to the sun, at the directions and where asked."""

    def functions(at: np.ndarray) -> np.ndarray:
        mu, cosine = at[:, 2].clip(0.0), (at @ sun).clip(-1.0, 1.0)
        angle = np.arccos(cosine)
        aureole, halo = np.exp(-angle / 0.17), np.exp(-angle / 0.5)  # 10 and 29 degrees wide
        return np.stack([mu, 1 / (mu + 0.2), angle, angle**2, aureole, halo, cosine**2], axis=1)

    given = functions(direction)
    mean, scale = given.mean(axis=0), given.std(axis=0) + 1e-3
    # what the directions cannot tell apart, as the zenith angles of an almucantar, is left to the others
    shares = np.linalg.lstsq((given - mean) / scale, level - level.mean(axis=0), rcond=3e-3)[0]
    return (given - mean) / scale @ shares, (functions(asked) - mean) / scale @ shares


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


def _leave_one_out(points: np.ndarray, level: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points (at most `_SAMPLED`), and errors (n, n_wl) of their levels by the other points: Rippa (1999), eq. (17).

    NaN where the other points are too few to tell.
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
        return np.divide(inverse @ y, diagonal, out=np.full_like(y, np.nan), where=np.broadcast_to(is_free, y.shape))

    if len(level) <= GLOBAL_POINTS:
        return np.arange(len(level)), errors(points, level)
    chosen = np.arange(_SAMPLED) * len(level) // _SAMPLED
    _, near = KDTree(points).query(points[chosen], k=NEIGHBOURS + 1)
    return chosen, np.stack([errors(points[some], level[some], is_local=True)[0] for some in near])


def notes_of(parts: Sequence[Interpolant], *, has_sun: bool = False) -> tuple[str, ...]:
    """Method and errors of the interpolation, the largest of all wavelengths."""
    worst = max(parts, key=lambda part: -1.0 if math.isnan(part.error) else part.error)
    beyond = max(parts, key=lambda part: part.extrapolated)
    error = "their errors cannot be told from so few"
    if not math.isnan(worst.error):
        error = (
            f"foretold by the others, a radiance is off by {percent(worst.error)} (root mean square), at most "
            f"{percent(worst.worst_error)} (zenith angle {worst.worst_deg[0]:.0f}, azimuth {worst.worst_deg[1]:.0f})"
        )
    if any(part.wants_sun for part in parts):
        error += "; directions near the sun are needed most"
    n = sorted({part.n_directions for part in parts})
    counts = f"{n[0]}" if len(n) == 1 else f"{n[0]} to {n[-1]}"
    return (
        f"{counts} directions, interpolated by a thin-plate spline of their unit vectors"
        f"{' on a trend around the sun' if has_sun else ''}; {error}",
        f"{percent(beyond.extrapolated)} of the light comes from beyond the measured directions; the widest gap is "
        f"{beyond.gap_deg:.0f} degrees from the nearest one",
    )


def percent(share: float) -> str:
    """Two digits, and never a power of ten."""
    return f"{float(f'{100 * share:.2g}'):g} %"


def warn_of_extrapolation(parts: Sequence[Interpolant], *, has_sun: bool = False) -> None:
    """Warn of light from beyond the measured directions, above `MOST_EXTRAPOLATED`."""
    share = max(part.extrapolated for part in parts)
    if share > MOST_EXTRAPOLATED:
        advice = (
            "; say where the sun is (--sun-zenith and --sun-azimuth, sun_zenith_deg= and sun_azimuth_deg=), and a "
            "trend around it serves there"
        )
        warnings.warn(
            f"measured sky: {percent(share)} of the light comes from beyond the measured directions, where it is "
            "extrapolated" + ("" if has_sun else advice),
            InputWarning,
            stacklevel=5,
        )
