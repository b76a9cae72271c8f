"""A measured sky: radiances in directions as scattered as an instrument gives them."""

from __future__ import annotations

import dataclasses
import math
import warnings
from dataclasses import KW_ONLY, dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component
from aomc_sky.directions import (
    AzimuthConvention,
    ConventionWord,
    given_angle,
    one_angle,
    sky_from_travel,
    travel_from_sky,
    within_sky_deg,
)
from aomc_sky.errors import InputWarning, SceneError, floats, member_of, require_kind
from aomc_sky.formats.quote import SAYS, UNUSED
from aomc_sky.grid import PatchGrid
from aomc_sky.record import same_content, short_repr
from aomc_sky.skies.function_sky import FunctionSky
from aomc_sky.skies.model import Share, check_share, polarised, with_share
from aomc_sky.skies.on_sphere import Interpolant, interpolate, known_of, notes_of, warn_of_extrapolation
from aomc_sky.skies.witnesses import brightest_note, warn_of_light

if TYPE_CHECKING:
    from aomc_sky.skies.polarisation import RayleighPattern

_SAME = 0.01  #: So far radiances of one direction differ without a word, as a share.
_OTHER_SKY = 0.2  #: Where half of the directions differ by more, the radiances are those of several skies.


@dataclass(eq=False, frozen=True, slots=True)
class RadianceField(Share):
    """A sky of radiances in measured directions, as scattered as they are: `from_points` or `read_radiance_csv`.

    A thin-plate spline of unit vectors interpolates the logarithm of the radiance
    (`scipy.interpolate.RBFInterpolator`), or its root at a wavelength with a measured 0. Unit vectors know neither a
    pole nor a turn, so the zenith and azimuth 0 are directions like all others. No radiance is negative. If the sun is
    known, a trend is fitted first, by ridge regression: functions of the zenith angle and of the angle to the sun. The
    trend goes on beyond the measured directions: outside their hull in the stereographic projection, and farther than
    15 degrees from all of them. The rest keeps its value at the nearest point of the hull. No radiance is above twice
    the brightest measured one; more than 10 degrees from the sun the brightest one there counts. Between two measured
    wavelengths radiances are linear, beyond them constant with a warning.

    Parameters
    ----------
    wavelength_nm : ndarray, float64, shape (n_wl,)
        Wavelengths that were measured, rising. [nm]
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
    has_wavelength : bool
        False: the radiances serve all wavelengths, without a warning.
    convention : AzimuthConvention, or its name in small letters
        That of the azimuths where they were read, for a warning of light that is not at the sun.
    polarisation : RayleighPattern, optional
        Linear polarisation of the light, which wants `sun`; without it photons carry none.
    strength, irradiance_W_m2_nm : array_like, optional
        Share of the light in a scene of several models, as for `UniformSky`. [>= 0]

    Notes
    -----
    Accuracy: of Perez skies seen in 300 irregular directions (23 sets, four suns) the irradiance is within 1.4 % up to
    clearness 3 and 2.8 % at 8, with the sun known within 1.0 and 1.8 %; its surroundings need the most directions. A
    scene notes the error of the radiances. It warns where more than 5 % of the light comes from beyond the measured
    directions: of 26 000 random skies none without a warning was off by more than 7 %. The direct beam is no part of
    it. Cost: half a second for a wavelength.

    Examples
    --------
    >>> zenith, azimuth = (
    ...     np.array([0.0, 30.0, 60.0, 60.0, 60.0, 80.0]),
    ...     np.array([0.0, 90.0, 0.0, 120.0, 240.0, 45.0]),
    ... )
    >>> measured = 0.2 + 0.1 * np.cos(np.radians(zenith))
    >>> field = sky.RadianceField.from_points(
    ...     zenith, azimuth, measured, wavelength_nm=550.0
    ... )
    >>> print(field.radiance(0.0, 0.0, 550.0).round(3))
    0.3
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
    has_wavelength: bool = True
    convention: AzimuthConvention = AzimuthConvention.ENU_FROM_EAST
    polarisation: RayleighPattern | None = None
    _made: dict[int, Interpolant] = field(init=False, repr=False, compare=False, default_factory=dict)
    _sky: FunctionSky = field(init=False, repr=False, compare=False)

    if TYPE_CHECKING:  # what may be given; the fields above are what it becomes

        def __init__(
            self,
            wavelength_nm: np.ndarray,
            direction: tuple[np.ndarray, ...],
            values: tuple[np.ndarray, ...],
            *,
            strength: ArrayLike | None = None,
            irradiance_W_m2_nm: ArrayLike | None = None,
            is_absolute: bool = False,
            sun: np.ndarray | None = None,
            grid: PatchGrid | None = None,
            name: str = "measured",
            remarks: tuple[str, ...] = (),
            has_wavelength: bool = True,
            convention: AzimuthConvention | ConventionWord = AzimuthConvention.ENU_FROM_EAST,
            polarisation: RayleighPattern | None = None,
        ) -> None: ...

    __eq__ = same_content
    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_share(self)
        object.__setattr__(self, "convention", member_of(AzimuthConvention, self.convention, "convention"))
        for array in (self.wavelength_nm, *self.direction, *self.values):
            require_kind(array, np.ndarray, "sky.RadianceField.from_points(zenith, azimuth, radiance)")
        for nm, direction, values in zip(self.wavelength_nm, self.direction, self.values, strict=True):
            if len(values) < 3:
                raise SceneError(
                    f"{len(values)} direction{'s' * (len(values) != 1)} at {nm:g} nm; a measured sky needs 3 or more"
                )
            if not np.all(np.isfinite(values) & (values >= 0)) or direction.shape != (len(values), 3):
                raise SceneError(f"radiances at {nm:g} nm must be finite and not negative, one for each direction")
        if self.polarisation is not None and self.sun is None:
            raise SceneError("polarisation wants to know where the sun is: give sun_zenith_deg= and sun_azimuth_deg=")
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
        convention: AzimuthConvention | ConventionWord = AzimuthConvention.ENU_FROM_EAST,
        polarisation: RayleighPattern | None = None,
        strength: ArrayLike | None = None,
        irradiance_W_m2_nm: ArrayLike | None = None,
    ) -> RadianceField:
        """Sky of points in any order; NaN or masked is a gap, and a direction that comes again has its mean radiance.

        SceneError: arrays that do not fit, negative radiances, fewer than three directions at a wavelength.

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
        is_absolute, grid, remarks, convention, polarisation, strength, irradiance_W_m2_nm : optional
            As for the class.
        """
        zenith, azimuth = (
            floats(name, given_angle(name, value, twin)).ravel()
            for name, value, twin in (
                ("sky_zenith_deg", sky_zenith_deg, sky_zenith_rad),
                ("sky_azimuth_deg", sky_azimuth_deg, sky_azimuth_rad),
            )
        )
        hidden = radiance if isinstance(radiance, np.ma.MaskedArray) else None
        values = np.array(floats("radiance", radiance if hidden is None else hidden.data), ndmin=1)
        if hidden is not None:
            values[np.atleast_1d(np.ma.getmaskarray(hidden))] = np.nan
        zenith = within_sky_deg(zenith)
        nm = np.atleast_1d(floats("wavelength_nm", 550.0 if wavelength_nm is None else wavelength_nm))
        if wavelength_nm is None:
            remarks = (*remarks, "the points have no wavelength, so the sky is the same at all wavelengths")
        if values.ndim == 2 and values.shape == (nm.size, zenith.size):
            n_wl, nm, values = nm.size, np.repeat(nm, zenith.size), values.ravel()
            zenith, azimuth = np.tile(zenith, n_wl), np.tile(azimuth, n_wl)
        elif values.size == zenith.size:  # of a grid of directions, whose angles are in this order, too
            nm, values = nm.ravel(), values.ravel()
        nm = np.broadcast_to(nm, values.shape) if nm.size == 1 else nm
        if not zenith.size == azimuth.size == values.size == nm.size:
            message = f"{zenith.size} zenith angles, {azimuth.size} azimuths and {nm.size} wavelengths do not fit"
            raise SceneError(f"{message} radiances of shape {values.shape}")
        sun_given = (
            one_angle("sun_zenith_deg", sun_zenith_deg, sun_zenith_rad),
            one_angle("sun_azimuth_deg", sun_azimuth_deg, sun_azimuth_rad),
        )
        sun_angles = [math.nan if angle is None else angle for angle in sun_given]
        sun = None if np.isnan(sun_angles).any() else -travel_from_sky(sun_angles[0], sun_angles[1])
        if sun is None and not np.isnan(sun_angles).all():
            missing = "zenith angle" if math.isnan(sun_angles[0]) else "azimuth"
            remarks = (*remarks, f"the sun's {missing} is not given, so the sky is interpolated without the sun")
        is_given, left_out = _given(zenith, azimuth, values)
        remarks = (*remarks, *left_out)
        points, repeats = _sorted_points(zenith[is_given], azimuth[is_given], nm[is_given], values[is_given])
        remarks = (*remarks, *repeats)
        return cls(
            *points,
            is_absolute=is_absolute,
            sun=sun,
            grid=grid,
            remarks=remarks,
            has_wavelength=wavelength_nm is not None,
            convention=convention,
            polarisation=polarisation,
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
            alike = [
                k
                for k, other in enumerate(self.direction)
                if np.array_equal(other, direction) and self.values[k].all() == self.values[row].all()
            ]
            values = np.stack([self.values[k] for k in alike])
            try:
                made = interpolate(direction, values, self.sun)
            except Exception as error:  # whatever scipy and its linear algebra say of the directions
                nm = self.wavelength_nm[row]
                raise SceneError(f"the radiances at {nm:g} nm cannot be interpolated ({error})") from error
            self._made.update(zip(alike, made, strict=True))
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

    def lower(self, wavelength_nm: ArrayLike) -> tuple[Component, ...]:
        """One component of patches; its strength is the irradiance, in W m-2 nm-1 where the radiances are absolute."""
        nm = np.atleast_1d(floats("wavelength_nm", wavelength_nm)).ravel()
        self._warn(nm)
        sun = None if self.sun is None else sky_from_travel(-self.sun)
        components = polarised(self, self._sky.lower(nm), nm, sun)
        if self.is_absolute and self.strength is None and self.irradiance_W_m2_nm is None:
            return tuple(dataclasses.replace(one, irradiance_W_m2_nm=one.strength) for one in components)
        return with_share(self, components)

    def _warn(self, nm: np.ndarray) -> None:
        """Warn of wavelengths that were not measured, and of light from where nothing was."""
        known = self.wavelength_nm
        outside = nm[(nm < known[0]) | (nm > known[-1])]
        if self.has_wavelength and outside.size:
            measured = f"wavelengths {known[0]:g} to {known[-1]:g}" if known.size > 1 else f"wavelength {known[0]:g}"
            warnings.warn(
                f"measured sky: {outside.size} of {nm.size} wavebands, such as {outside[0]:.12g} nm, lie outside the "
                f"measured {measured} nm; they have the sky of the nearest one",
                InputWarning,
                stacklevel=5,
            )
        warn_of_extrapolation(self._parts(nm), has_sun=self.sun is not None)
        zenith, azimuth, values = self._points(nm[0])
        warn_of_light(values, zenith, azimuth, sun_deg=self.sun_deg or (None, None), convention=self.convention)

    def _points(self, nm: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Zenith angles, azimuths [deg] and radiances at the wavelength that has the largest share in one."""
        row = max(self.rows_of(nm), key=lambda one: one[1])[0]
        zenith, azimuth = np.rad2deg(sky_from_travel(-self.direction[row]))
        return zenith, azimuth, self.values[row]

    def _parts(self, nm: np.ndarray) -> list[Interpolant]:
        return [self.interpolant(row) for row in sorted({row for one in nm for row, _ in self.rows_of(one)})]

    def notes(self, wavelength_nm: ArrayLike) -> tuple[str, ...]:
        """How the sky was made, the leave-one-out error, and the share of the light that is extrapolated."""
        nm = np.atleast_1d(floats("wavelength_nm", wavelength_nm))
        grid, moved = self._sky.patches, 100 * self._sky.variation(nm).max()
        inside = (
            f"light that is linear in {grid.n_zenith} x {grid.n_azimuth} patches moves {moved:.2g} % of the photons"
        )
        zenith, azimuth, values = self._points(nm[0])
        at = float(nm[0]) if self.has_wavelength else None
        seen = brightest_note(values, zenith, azimuth, float(self.irradiance(nm[:1])[0]), float(self.is_absolute), at)
        said = [one for one in self.remarks if one.startswith((SAYS, UNUSED))]
        others = [one for one in self.remarks if one not in said]
        parts = self._parts(nm)
        found = f"{known_of(parts)}; {seen}"
        notes = (*said, found, *notes_of(parts, has_sun=self.sun is not None), *others, inside)
        return tuple(f"measured sky: {note}" for note in notes)

    def missing_beam(self) -> str:
        """The note of a scene of this sky alone."""
        return (
            "measured sky: the direct beam of the sun is no part of it; two of dni, dhi and ghi add it, or in Python "
            "DirectBeam(...) with its share"
        )


def _given(zenith_deg: np.ndarray, azimuth_deg: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Which points are radiances of the sky, and remarks on the others, and on dark ones."""
    is_direction, is_gap = np.isfinite(zenith_deg) & np.isfinite(azimuth_deg), np.isnan(values)
    is_above = is_direction & (np.abs(zenith_deg) <= 90)
    is_given = is_above & ~is_gap
    is_dark = is_given & (values == 0) & np.any(values[is_given] > 0)
    said = (
        (~is_direction, "without a direction, and left out"),
        (is_direction & ~is_above, "directions below the horizon, and left out"),
        (is_above & is_gap, "gaps, and left out"),
        (is_dark, "0, and count as dark sky"),
    )
    return is_given, [f"{which.sum()} of {values.size} radiances are {what}" for which, what in said if which.any()]


def _sorted_points(
    zenith_deg: np.ndarray, azimuth_deg: np.ndarray, wavelength_nm: np.ndarray, values: np.ndarray
) -> tuple[tuple[np.ndarray, tuple[np.ndarray, ...], tuple[np.ndarray, ...]], tuple[str, ...]]:
    """Wavelengths, directions and radiances, the same for any order of the points; equal directions are averaged.

    Remarks tell how far they differ; SceneError where most of them differ by more than a repeated scan does.
    """
    if not values.size:
        raise SceneError("there is no radiance from above the horizon")
    # rounded, so that all azimuths of the zenith are one direction
    direction = np.round(-travel_from_sky(np.abs(zenith_deg), azimuth_deg + 180.0 * (zenith_deg < 0)), 6) + 0.0
    order = np.lexsort((values, *direction.T, wavelength_nm))
    keys, values = np.column_stack([wavelength_nm, direction])[order], values[order]
    first = np.flatnonzero(np.append(True, np.any(np.diff(keys, axis=0) != 0, axis=1)))
    count = np.diff(np.append(first, values.size))
    means = np.add.reduceat(values, first) / count
    low, high = values[first], values[first + count - 1]
    spread = (high - low) / np.where(high > 0, high, 1.0)
    remarks = tuple[str, ...]()
    if np.any(spread > _SAME):
        n_differ, n = (len(np.unique(which[:, 1:], axis=0)) for which in (keys[first[spread > _SAME]], keys))
        message = (
            f"{n_differ} of {n} directions come more than once, with radiances that differ by up to "
            f"{100 * spread.max():.2g} %"
        )
        if np.median(spread) > _OTHER_SKY:
            raise SceneError(f"{message}: give those of one time, and the wavelength of each (wavelength_nm)")
        remarks = (f"{message}; they count with their mean",)
    known, start = np.unique(keys[first, 0], return_index=True)
    return (known, tuple(np.split(keys[first, 1:], start[1:])), tuple(np.split(means, start[1:]))), remarks
