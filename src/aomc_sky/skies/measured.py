"""A measured sky: radiances in scattered directions, interpolated on the sphere by a thin-plate spline."""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component
from aomc_sky.directions import given_angle, sky_from_travel, travel_from_sky
from aomc_sky.errors import InputWarning, SceneError
from aomc_sky.float_mode import in_default_mode
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.function_sky import FunctionSky
from aomc_sky.skies.model import Share, check_share, with_share

GLOBAL_POINTS = 1000  #: Up to so many directions one spline serves the sky; of more, each direction has its neighbours.
NEIGHBOURS = 32
_SMOOTHING = 1e-7  # two measurements of almost one direction are averaged
_THIN = 0.02  #: Spread across a plane, as a share of that along it, below which directions lie in one plane.
_STEP_DEG = 2.0  #: Of the table from which radiances are taken, by a cubic spline.
_PAD = 8  #: Steps by which the table goes on beyond zenith, horizon and the turn.
_DIGITS = 8  #: Of the table: the last digits of linear algebra differ between processors.
_SAMPLED = 300
_TREND_POINTS = 12
MOST_EXTRAPOLATED = 0.05  #: Share of the light beyond the measured directions above which a person is warned.


class Interpolant(NamedTuple):
    """The interpolated radiance at one wavelength, and what is known of its error."""

    table: np.ndarray  #: Spline coefficients of the logarithm, or of the radiance where a measured one is 0.
    is_log: bool
    n_directions: int
    error: float  #: Root mean square of the leave-one-out errors, as shares of the radiance.
    worst_error: float
    worst_deg: tuple[float, float]  #: Zenith angle and azimuth of the latter.
    extrapolated: float  #: Share of the irradiance from beyond the measured directions.
    gap_deg: float  #: Angle between the direction that is farthest from all measured ones, and the nearest of these.

    def __call__(self, sky_zenith_rad: np.ndarray, sky_azimuth_rad: np.ndarray) -> np.ndarray:
        """Radiance of directions. [unit of the points]"""
        from scipy.ndimage import map_coordinates

        step = math.radians(_STEP_DEG)
        at = np.stack([sky_zenith_rad / step, np.mod(sky_azimuth_rad, 2 * np.pi) / step]) + _PAD
        value = map_coordinates(self.table, at.reshape(2, -1), prefilter=False, mode="nearest")
        return np.asarray((np.exp(value) if self.is_log else value.clip(0.0)).reshape(at.shape[1:]))


@dataclass(eq=False, frozen=True, slots=True)
class RadianceField(Share):
    """A sky of radiances in measured directions, as scattered as they are: `from_points` or `read_radiance_csv`.

    The logarithm of the radiance is interpolated by a thin-plate spline of the unit vectors of the directions
    (`scipy.interpolate.RBFInterpolator`; the radiance itself, cut at 0, at a wavelength with a measured 0). Unit
    vectors know neither a pole nor a turn, so the zenith and azimuth 0 are directions like all others, and no radiance
    is negative. Where the sun is known, a trend is fitted first: functions of the zenith angle and of the angle to the
    sun. Beyond the measured directions (their hull in the stereographic projection, to the horizon as a rule) the trend
    goes on, and what remains keeps its value at the nearest point of the hull. Between two measured wavelengths
    radiances are linear, beyond them constant with a warning.

    Parameters
    ----------
    wavelength_nm : ndarray, float64, shape (n_wl,)
        Wavelengths that were measured, rising; one value serves all wavelengths. [nm]
    direction : tuple of n_wl ndarrays, float64, shape (n, 3)
        Unit vectors towards the sky, three or more at each wavelength.
    values : tuple of n_wl ndarrays, float64, shape (n,)
        Radiances. [W m-2 nm-1 sr-1, or any unit; 0 to inf]
    is_absolute : bool
        Whether they are in W m-2 nm-1 sr-1, so that a scene of them has irradiances in W m-2 nm-1.
    sun : ndarray, float64, shape (3,), optional
        Unit vector towards the sun.
    grid : PatchGrid, optional
        Patches for sampling; 45 x 180 by default.
    remarks : tuple of str
        Further notes of a scene.
    strength, irradiance_W_m2_nm : array_like, optional
        Share of the light in a scene of several models, as for `UniformSky`. [>= 0]

    Notes
    -----
    Accuracy: of Perez skies seen in 300 irregular directions the irradiance is within 0.5 % up to clearness 3 and
    within 1 % of the clearest; the surroundings of the sun need the most directions. A scene notes the leave-one-out
    error: what each radiance is foretold by the others. The direct beam is no part of it.
    """

    wavelength_nm: np.ndarray
    direction: tuple[np.ndarray, ...]
    values: tuple[np.ndarray, ...]
    _: KW_ONLY
    is_absolute: bool = False
    sun: np.ndarray | None = None
    grid: PatchGrid | None = None
    name: str = "measured"
    remarks: tuple[str, ...] = ()
    _made: dict[int, Interpolant] = field(init=False, repr=False, default_factory=dict)
    _sky: FunctionSky = field(init=False, repr=False)

    def __post_init__(self) -> None:
        check_share(self)
        for nm, direction, values in zip(self.wavelength_nm, self.direction, self.values, strict=True):
            if len(values) < 3:
                raise SceneError(f"{len(values)} directions at {nm:g} nm; a measured sky needs 3 or more")
            if not np.all(np.isfinite(values) & (values >= 0)) or direction.shape != (len(values), 3):
                raise SceneError(f"radiances at {nm:g} nm must be finite and not negative, one for each direction")
        grid = PatchGrid.regular(45, 180) if self.grid is None else self.grid
        object.__setattr__(self, "_sky", FunctionSky(self._values, grid=grid, name=self.name))

    @classmethod
    def from_points(
        cls,
        sky_zenith_deg: ArrayLike | None = None,
        sky_azimuth_deg: ArrayLike | None = None,
        radiance: ArrayLike | None = None,
        wavelength_nm: ArrayLike | None = None,
        *,
        sky_zenith_rad: ArrayLike | None = None,
        sky_azimuth_rad: ArrayLike | None = None,
        sun_zenith_deg: float | None = None,
        sun_azimuth_deg: float | None = None,
        sun_zenith_rad: float | None = None,
        sun_azimuth_rad: float | None = None,
        is_absolute: bool = False,
        grid: PatchGrid | None = None,
        remarks: tuple[str, ...] = (),
        strength: ArrayLike | None = None,
        irradiance_W_m2_nm: ArrayLike | None = None,
    ) -> RadianceField:
        """Sky of points in any order; NaN is a gap, and a direction that comes again has its mean radiance.

        Parameters
        ----------
        sky_zenith_deg, sky_azimuth_deg, or sky_zenith_rad, sky_azimuth_rad : array_like, shape (n,)
            Directions that light comes from, azimuth from +x towards +y; beyond 90 degrees they are left out. [deg]
        radiance : array_like, shape (n,) or (n_wl, n)
            One for each direction, at each wavelength in the second form. [any unit, >= 0]
        wavelength_nm : array_like, optional
            Wavelength of each point, or of each row of radiances; without it, the sky of all wavelengths. [nm]
        sun_zenith_deg, sun_azimuth_deg, or sun_zenith_rad, sun_azimuth_rad : float, optional
            Where the sun is. [deg]
        is_absolute, grid, remarks, strength, irradiance_W_m2_nm : optional
            As for the class.

        Raises
        ------
        SceneError
            Arrays that do not fit, negative radiances, fewer than three directions at a wavelength.
        """
        zenith, azimuth = (
            np.asarray(given_angle(name, value, twin), dtype=np.float64).ravel()
            for name, value, twin in (
                ("sky_zenith_deg", sky_zenith_deg, sky_zenith_rad),
                ("sky_azimuth_deg", sky_azimuth_deg, sky_azimuth_rad),
            )
        )
        values = np.asarray(radiance, dtype=np.float64)
        nm = np.array([550.0]) if wavelength_nm is None else np.atleast_1d(np.asarray(wavelength_nm, np.float64))
        if wavelength_nm is None:
            remarks = (*remarks, "the points have no wavelength, so the sky is the same at all wavelengths")
        shape = values.shape
        if values.ndim == 2 and values.shape == (nm.size, zenith.size):
            zenith, azimuth = np.tile(zenith, nm.size), np.tile(azimuth, nm.size)
            values, nm = values.ravel(), np.repeat(nm, values.shape[1])
        nm = np.broadcast_to(nm, values.shape) if nm.size == 1 else nm
        if not zenith.shape == azimuth.shape == values.shape == nm.shape:
            raise SceneError(
                f"{zenith.size} zenith angles, {azimuth.size} azimuths and {nm.size} wavelengths do not fit radiances "
                f"of shape {shape}"
            )
        sun_angles: list[float] = [
            given_angle(f"sun_{name}", value, twin, math.nan)
            for name, value, twin in (
                ("zenith_deg", sun_zenith_deg, sun_zenith_rad),
                ("azimuth_deg", sun_azimuth_deg, sun_azimuth_rad),
            )
        ]
        sun = None if np.isnan(sun_angles).any() else -travel_from_sky(sun_angles[0], sun_angles[1])
        is_above, is_gap = np.abs(zenith) <= 90, np.isnan(values)
        for n, what in ((np.sum(~is_above), "directions below the horizon"), (np.sum(is_above & is_gap), "gaps")):
            remarks = (*remarks, *([f"{n} of {values.size} radiances are {what}, and left out"] if n else []))
        is_given = is_above & ~is_gap
        points = _sorted_points(zenith[is_given], azimuth[is_given], nm[is_given], values[is_given])
        return cls(
            *points,
            is_absolute=is_absolute,
            sun=sun,
            grid=grid,
            remarks=remarks,
            strength=strength,
            irradiance_W_m2_nm=irradiance_W_m2_nm,
        )

    @property
    def sun_deg(self) -> tuple[float, float] | None:
        """Zenith angle and azimuth of the sun, where it is known."""
        if self.sun is None:
            return None
        zenith, azimuth = np.rad2deg(sky_from_travel(-self.sun))
        return round(float(zenith), 9), round(float(azimuth), 9)

    def radiance(self, sky_zenith_rad: ArrayLike, sky_azimuth_rad: ArrayLike, wavelength_nm: ArrayLike) -> np.ndarray:
        """Interpolated radiance, in the unit of the points; arguments broadcast, angles up to pi/2 and any turn."""
        return self._sky.radiance(sky_zenith_rad, sky_azimuth_rad, wavelength_nm)

    def irradiance(self, wavelength_nm: ArrayLike) -> np.ndarray:
        """Irradiance of the horizontal plane, shape (n_wl,). [unit of the radiances x sr]"""
        return self._sky.irradiance(wavelength_nm)

    def interpolant(self, row: int) -> Interpolant:
        """The interpolated sky at one of the measured wavelengths, computed once."""
        if row not in self._made:
            direction = self.direction[row]
            alike = [k for k, other in enumerate(self.direction) if np.array_equal(other, direction)]
            values = np.stack([self.values[k] for k in alike])
            self._made.update(zip(alike, interpolate(direction, values, self.sun), strict=True))
        return self._made[row]

    def rows_of(self, wavelength_nm: float) -> list[tuple[int, float]]:
        """The measured wavelengths that make up this one, and the share of each."""
        known = self.wavelength_nm
        place = float(np.interp(wavelength_nm, known, np.arange(known.size)))
        low = min(int(place), max(known.size - 2, 0))
        shares = {low: 1.0 - (place - low), low + 1: place - low}
        return [(row, share) for row, share in shares.items() if share > 0]

    def _values(self, zenith: np.ndarray, azimuth: np.ndarray, wavelength_nm: float) -> np.ndarray:
        parts = [share * self.interpolant(row)(zenith, azimuth) for row, share in self.rows_of(wavelength_nm)]
        return parts[0] if len(parts) == 1 else parts[0] + parts[1]

    @in_default_mode
    def lower(self, wavelength_nm: ArrayLike) -> tuple[Component, ...]:
        """One component of patches; its strength is the irradiance, in W m-2 nm-1 where the radiances are absolute."""
        nm = np.atleast_1d(np.asarray(wavelength_nm, dtype=np.float64)).ravel()
        self._warn(nm)
        components = self._sky.lower(nm)
        if self.is_absolute and self.strength is None and self.irradiance_W_m2_nm is None:
            return tuple(dataclasses.replace(one, irradiance_W_m2_nm=one.strength) for one in components)
        return with_share(self, components)

    def _warn(self, nm: np.ndarray) -> None:
        """Warn of wavelengths that were not measured, and of light from where nothing was."""
        known = self.wavelength_nm
        outside = nm[(nm < known[0]) | (nm > known[-1])]
        if known.size > 1 and outside.size:
            warnings.warn(
                f"{outside.size} of {nm.size} wavebands, such as {outside[0]:g} nm, lie outside the measured "
                f"wavelengths {known[0]:g} to {known[-1]:g} nm; they have the sky of the nearest one",
                InputWarning,
                stacklevel=5,
            )
        warn_of_extrapolation(self._parts(nm), has_sun=self.sun is not None)

    def _parts(self, nm: np.ndarray) -> list[Interpolant]:
        return [self.interpolant(row) for row in sorted({row for one in nm for row, _ in self.rows_of(one)})]

    def notes(self, wavelength_nm: ArrayLike) -> tuple[str, ...]:
        """How the sky was made, the leave-one-out error, and the share of the light that is extrapolated."""
        nm = np.atleast_1d(np.asarray(wavelength_nm, dtype=np.float64))
        notes = (*notes_of(self._parts(nm), has_sun=self.sun is not None), *self.remarks)
        return (*(f"measured sky: {note}" for note in notes), *self._sky.notes(nm))

    def missing_beam(self) -> str:
        """What a scene of this sky alone leaves out."""
        return "measured sky: the direct beam of the sun is no part of it; add DirectBeam(...) with its share"


def notes_of(parts: Sequence[Interpolant], *, has_sun: bool = False) -> tuple[str, ...]:
    """What interpolation did, and its errors, the largest of all wavelengths."""
    worst, beyond = max(parts, key=lambda part: part.error), max(parts, key=lambda part: part.extrapolated)
    n = sorted({part.n_directions for part in parts})
    counts = f"{n[0]}" if len(n) == 1 else f"{n[0]} to {n[-1]}"
    return (
        f"{counts} directions, interpolated by a thin-plate spline of their unit vectors"
        f"{' on a trend around the sun' if has_sun else ''}; foretold by the others, a radiance is off by "
        f"{100 * worst.error:.2g} % (root mean square), at most {100 * worst.worst_error:.2g} % (zenith angle "
        f"{worst.worst_deg[0]:.0f}, azimuth {worst.worst_deg[1]:.0f})",
        f"{100 * beyond.extrapolated:.2g} % of the light comes from beyond the measured directions; the widest gap is "
        f"{beyond.gap_deg:.0f} degrees from the nearest one",
    )


def warn_of_extrapolation(parts: Sequence[Interpolant], *, has_sun: bool = False) -> None:
    """Warn of light from beyond the measured directions, above `MOST_EXTRAPOLATED`."""
    share = max(part.extrapolated for part in parts)
    if share > MOST_EXTRAPOLATED:
        warnings.warn(
            f"{100 * share:.2g} % of the light comes from beyond the measured directions, where it is extrapolated"
            + ("" if has_sun else "; say where the sun is, and a trend around it serves there"),
            InputWarning,
            stacklevel=5,
        )


def _sorted_points(
    zenith_deg: np.ndarray, azimuth_deg: np.ndarray, wavelength_nm: np.ndarray, values: np.ndarray
) -> tuple[np.ndarray, tuple[np.ndarray, ...], tuple[np.ndarray, ...]]:
    """Wavelengths, directions and radiances, the same for any order of the points; equal directions are averaged."""
    if not values.size:
        raise SceneError("there is no radiance from above the horizon")
    # rounded, so that all azimuths of the zenith are one direction
    direction = np.round(-travel_from_sky(np.abs(zenith_deg), azimuth_deg + 180.0 * (zenith_deg < 0)), 6) + 0.0
    order = np.lexsort((values, *direction.T, wavelength_nm))
    keys, values = np.column_stack([wavelength_nm, direction])[order], values[order]
    first = np.flatnonzero(np.append(True, np.any(np.diff(keys, axis=0) != 0, axis=1)))
    means = np.add.reduceat(values, first) / np.diff(np.append(first, values.size))
    known, start = np.unique(keys[first, 0], return_index=True)
    return known, tuple(np.split(keys[first, 1:], start[1:])), tuple(np.split(means, start[1:]))


@in_default_mode
def interpolate(direction: np.ndarray, values: np.ndarray, sun: np.ndarray | None = None) -> tuple[Interpolant, ...]:
    """Interpolate radiances (n_wl, n) in directions (n, 3), three or more, none of n_wl dark everywhere."""
    from scipy.interpolate import RBFInterpolator
    from scipy.ndimage import spline_filter
    from scipy.spatial import KDTree

    is_log, n = np.all(values > 0, axis=1), len(direction)
    level = np.where(is_log[:, None], np.log(np.where(values > 0, values, 1.0)), values).T
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
    shares = np.abs(np.where(is_log, np.expm1(-errors), errors / np.maximum(values.mean(axis=1), 1e-300))).T
    made = []
    for table, has_log, share in zip(tables, is_log.tolist(), shares, strict=True):
        worst = chosen[share.argmax()]
        zenith_rad, azimuth_rad = sky_from_travel(-direction[worst])
        flux = (np.exp(table) if has_log else table.clip(0.0)) * np.sin(np.deg2rad(2 * zenith))
        made.append(
            Interpolant(
                table=spline_filter(_padded(table.reshape(_N_RINGS, _N_COLUMNS)), 3),
                is_log=has_log,
                n_directions=n,
                error=float(np.sqrt(np.mean(share * share))),
                worst_error=float(share.max()),
                worst_deg=(math.degrees(zenith_rad), math.degrees(azimuth_rad)),
                extrapolated=float(flux[is_outside].sum() / flux.sum()) if flux.any() else 0.0,
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
    """Errors (n, n_wl) of foretelling levels by those of the other points: Rippa (1999), equation (17).

    And which points: all, or `_SAMPLED` of many.
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
        is_free = np.abs(diagonal) > 1e-6  # a plane through as many points has no error
        return np.divide(inverse @ y, diagonal, out=np.zeros_like(y), where=np.broadcast_to(is_free, y.shape))

    if len(level) <= GLOBAL_POINTS:
        return np.arange(len(level)), errors(points, level)
    chosen = np.arange(_SAMPLED) * len(level) // _SAMPLED
    _, near = KDTree(points).query(points[chosen], k=NEIGHBOURS + 1)
    return chosen, np.stack([errors(points[some], level[some], is_local=True)[0] for some in near])
