"""A background sky: lobes that move and change with time, each with a spectrum in absolute units."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import SceneError, UsageError
from aomc_sky.skies import lobe_laws
from aomc_sky.skies.lobe_horizon import mass_above_horizon
from aomc_sky.skies.quaternion import to_local, vertical_in_local

_DAY_S = 86400.0
_EPOCH_WEEKDAY = 4.0  # 1970-01-01 was a Thursday, four days after Sunday
_WAVELENGTH_TOLERANCE = 1e-6  # 0.400 um is 0.4000000059 in float32


class Reference(enum.Enum):
    """What the relative times of an animation count from."""

    ABSOLUTE = "absolute"
    """A point in time; the animation does not repeat."""
    DIURNAL = "diurnal"
    """The most recent midnight."""
    HEBDOMADAL = "hebdomadal"
    """Midnight at the begin of the most recent Sunday."""


@dataclass(frozen=True, kw_only=True, slots=True)
class LobeAnimation:
    """One lobe over time: its keys in the order of time.

    Parameters
    ----------
    kind : tuple of str, n_key of them
        "hg", "ggx" or "beckmann" at each key.
    param0, param1 : ndarray, float64, shape (n_key,)
        g and nothing [0 <= g < 1], or the roughness along local x and y [> 0].
    coefficient : ndarray, float64, shape (n_key,)
        Factor of the curve. [>= 0]
    quaternion : ndarray, float64, shape (n_key, 4)
        Rotation (w, x, y, z) from local to world, of any length but 0.
    curve : ndarray, int64, shape (n_key,)
        Row of the sky's curves. [0 to n_curve - 1]
    time_days : ndarray, float64, shape (n_key,)
        Time since the reference, never falling; of equal times the later key wins. [d]
    reference : Reference
        What the times count from.
    reference_unix_s : float
        The reference of an absolute animation. [s since 1970-01-01 UTC]
    """

    kind: tuple[str, ...]
    param0: np.ndarray
    param1: np.ndarray
    coefficient: np.ndarray
    quaternion: np.ndarray
    curve: np.ndarray
    time_days: np.ndarray
    reference: Reference
    reference_unix_s: float = 0.0

    def __post_init__(self) -> None:
        n_key = len(self.kind)
        arrays = (self.param0, self.param1, self.coefficient, self.curve, self.time_days)
        if n_key == 0 or any(a.shape != (n_key,) for a in arrays) or self.quaternion.shape != (n_key, 4):
            raise SceneError("an animation has at least one key, and every member one value for each key")
        for key, kind in enumerate(self.kind):
            lobe_laws.checked(kind, self.param0[key], self.param1[key])
        vertical_in_local(self.quaternion)
        if not np.all(np.isfinite(self.time_days)) or np.any(np.diff(self.time_days) < 0.0):
            raise SceneError("the keys of an animation must stand in the order of time")
        if not np.all((self.coefficient >= 0.0) & (self.coefficient < np.inf)):
            raise SceneError("the coefficient of a lobe must be finite and not negative")

    def relative_days(self, unix_time_s: ArrayLike, *, utc_offset_h: float = 0.0) -> np.ndarray:
        """Time since the reference; of a repeating animation in [0, 1) or [0, 7).

        Parameters
        ----------
        unix_time_s : array_like
            Time. [s since 1970-01-01 UTC]
        utc_offset_h : float
            Local time less UTC, for the midnight of repeating animations. [h]

        Returns
        -------
        ndarray, float64
            [d]
        """
        time = np.asarray(unix_time_s, dtype=np.float64)
        if not np.all(np.isfinite(time)):
            raise SceneError("a time must be finite")
        if self.reference is Reference.ABSOLUTE:
            return (time - self.reference_unix_s) / _DAY_S
        local = time + 3600.0 * utc_offset_h
        if self.reference is Reference.DIURNAL:
            return np.mod(local, _DAY_S) / _DAY_S
        return np.mod(local + _EPOCH_WEEKDAY * _DAY_S, 7.0 * _DAY_S) / _DAY_S

    def between(self, relative_days: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Keys around a time and how far it lies between them.

        Parameters
        ----------
        relative_days : array_like
            Time since the reference. [d]

        Returns
        -------
        key_low, key_high : ndarray, int64
            Equal up to the first and from the last key on: the end keys hold, also at midnight.
        fraction : ndarray, float64
            Share of the later key. [0 to 1)
        """
        time = np.asarray(relative_days, dtype=np.float64)
        last = self.time_days.size - 1
        after = np.searchsorted(self.time_days, time, side="right")
        low = np.clip(after - 1, 0, last)
        high = np.where((time <= self.time_days[0]) | (after > last), low, np.minimum(after, last))
        span = self.time_days[high] - self.time_days[low]
        fraction = np.where(high > low, (time - self.time_days[low]) / np.where(high > low, span, 1.0), 0.0)
        return low, high, fraction


@dataclass(frozen=True, kw_only=True, slots=True)
class BackgroundSky:
    """Starlight, airglow, city light: animated lobes whose light adds, in absolute units.

    Parameters
    ----------
    animations : mapping of str to LobeAnimation
        The animations by name.
    wavelength_nm : ndarray, float64, shape (n_wavelength,)
        Wavelengths of the curves, rising. [nm]
    curves : ndarray, float64, shape (n_curve, n_wavelength)
        Spectral irradiance integrated over the whole sphere. [W m-2 nm-1, >= 0]
    utc_offset_h : float
        Local time less UTC, for the midnight of repeating animations. [h]
    """

    animations: Mapping[str, LobeAnimation]
    wavelength_nm: np.ndarray
    curves: np.ndarray
    utc_offset_h: float = 0.0

    def __post_init__(self) -> None:
        wavelength = self.wavelength_nm
        rises = wavelength.ndim == 1 and wavelength.size > 0 and bool(np.all(np.diff(wavelength) > 0.0))
        if not rises or not np.all(np.isfinite(wavelength)):
            raise SceneError("the wavelengths of a background sky must be finite and rise")
        if self.curves.ndim != 2 or self.curves.shape[1] != wavelength.size:
            raise SceneError("every curve of a background sky has one value for each wavelength")
        if not np.all((self.curves >= 0.0) & (self.curves < np.inf)):
            raise SceneError("the curves of a background sky must be finite and not negative")
        for name, animation in self.animations.items():
            if np.any((animation.curve < 0) | (animation.curve >= self.curves.shape[0])):
                raise SceneError(f"animation {name!r} names a curve that is not there")
        if not np.isfinite(self.utc_offset_h):
            raise SceneError("the UTC offset must be finite")

    def irradiance(
        self, animation: str | None, unix_time_s: ArrayLike, wavelength_nm: ArrayLike, *, above: str = "sphere"
    ) -> np.ndarray:
        """Spectral irradiance of an animation, integrated over the whole sphere as the files give it.

        Parameters
        ----------
        animation : str or None
            Name of the animation; None adds all of them.
        unix_time_s : array_like
            Time, broadcast with the wavelengths. [s since 1970-01-01 UTC]
        wavelength_nm : array_like
            Wavelengths. [nm]
        above : {"sphere", "horizon", "projected"}
            The whole lobe; its part above the horizon; that part on a horizontal plane.

        Returns
        -------
        ndarray, float64
            Coefficient times curve, linear in time between the keys and in wavelength. [W m-2 nm-1]

        Raises
        ------
        UsageError
            There is no such animation, or `above` is unknown.
        SceneError
            A wavelength is outside the curves by more than 1e-6 of itself, or a time is not finite.
        """
        if above not in ("sphere", "horizon", "projected"):
            raise UsageError(f"above is 'sphere', 'horizon' or 'projected', not {above!r}")
        spectrum = self._spectra(wavelength_nm)
        total = np.zeros(np.broadcast_shapes(np.shape(unix_time_s), spectrum.shape[1:]))
        for one in self._named(animation):
            strength = one.coefficient * _shares(one, above)
            for key, weight in self._weights(one, unix_time_s):
                total = total + weight * strength[key] * _rows(spectrum, one.curve[key], total.shape)
        return total

    def radiance(
        self, sky_zenith_rad: ArrayLike, sky_azimuth_rad: ArrayLike, wavelength_nm: ArrayLike, unix_time_s: float
    ) -> np.ndarray:
        """Radiance of the sky at one time; the lobes of two keys fade into each other.

        Parameters
        ----------
        sky_zenith_rad, sky_azimuth_rad : array_like
            Sky directions: 0 overhead, azimuth from +x (east) towards +y (north). [rad]
        wavelength_nm : array_like
            Wavelengths, broadcast with the angles. [nm]
        unix_time_s : float
            Time. [s since 1970-01-01 UTC]

        Returns
        -------
        ndarray, float64
            Radiance of all animations together. [W m-2 sr-1 nm-1]

        Raises
        ------
        SceneError
            A wavelength is outside the curves, or the time is not finite.
        """
        zenith, azimuth = np.broadcast_arrays(sky_zenith_rad, sky_azimuth_rad)
        sine = np.sin(zenith)
        world = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(zenith)], axis=-1)
        spectrum = self._spectra(wavelength_nm)
        total = np.zeros(np.broadcast_shapes(zenith.shape, spectrum.shape[1:]))
        for one in self.animations.values():
            for key, weight in self._weights(one, float(unix_time_s)):
                at = int(key)
                local = to_local(one.quaternion[at], world)
                density = lobe_laws.pdf(one.kind[at], one.param0[at], one.param1[at], local)
                total = total + weight * one.coefficient[at] * spectrum[one.curve[at]] * density
        return total

    def _named(self, animation: str | None) -> list[LobeAnimation]:
        if animation is None:
            return list(self.animations.values())
        if animation not in self.animations:
            known = ", ".join(self.animations) or "none"
            raise UsageError(f"there is no animation {animation!r} in this sky; there are: {known}")
        return [self.animations[animation]]

    def _weights(self, one: LobeAnimation, unix_time_s: ArrayLike) -> list[tuple[np.ndarray, np.ndarray]]:
        low, high, fraction = one.between(one.relative_days(unix_time_s, utc_offset_h=self.utc_offset_h))
        return [(low, 1.0 - fraction), (high, fraction)]

    def _spectra(self, wavelength_nm: ArrayLike) -> np.ndarray:
        """Every curve at the wavelengths, shape (n_curve, ...)."""
        wanted = np.asarray(wavelength_nm, dtype=np.float64)
        low, high = self.wavelength_nm[0], self.wavelength_nm[-1]
        inside = (wanted >= low * (1 - _WAVELENGTH_TOLERANCE)) & (wanted <= high * (1 + _WAVELENGTH_TOLERANCE))
        if not np.all(inside):
            first = wanted[~inside].flat[0]
            raise SceneError(f"{first:g} nm is outside the background's curves, {low:g} to {high:g} nm")
        return np.stack([np.interp(wanted, self.wavelength_nm, curve) for curve in self.curves])


def _shares(one: LobeAnimation, above: str) -> np.ndarray:
    """Share of each key's lobe that counts."""
    if above == "sphere":
        return np.ones(len(one.kind))
    weighting = "plain" if above == "horizon" else "projected"
    return np.array(
        [
            float(mass_above_horizon(kind, *shape, weighting=weighting))
            for kind, *shape in zip(one.kind, one.param0, one.param1, one.quaternion, strict=True)
        ]
    )


def _rows(spectrum: np.ndarray, curve: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """spectrum[curve[time], wavelength] where times and wavelengths broadcast to `shape`."""
    wide = np.broadcast_to(
        spectrum.reshape(spectrum.shape[0], *(1,) * (len(shape) - spectrum.ndim + 1), *spectrum.shape[1:]),
        (spectrum.shape[0], *shape),
    )
    return np.take_along_axis(wide, np.broadcast_to(curve, shape)[None], axis=0)[0]
