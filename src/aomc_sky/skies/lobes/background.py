"""A background sky: lobes that move and change with time, each with a spectrum in absolute units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import SceneError, UsageError
from aomc_sky.float_mode import in_default_mode
from aomc_sky.phase.vectorised import real, shape_of
from aomc_sky.skies.lobes.animation import LobeAnimation
from aomc_sky.skies.lobes.horizon import mass_above_horizon
from aomc_sky.skies.lobes.sky import checked_samples, spectra_at


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

    @in_default_mode
    def __post_init__(self) -> None:
        checked_samples(self.wavelength_nm, self.curves)
        for name, animation in self.animations.items():
            if np.any((animation.curve < 0) | (animation.curve >= self.curves.shape[0])):
                raise SceneError(f"animation {name!r} names a curve that is not there")
        if not np.all(np.isfinite(real(self.utc_offset_h))):
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
        spectrum = spectra_at(wavelength_nm, self.wavelength_nm, self.curves)
        total = np.zeros(shape_of((real(unix_time_s), spectrum[0])))
        for one in self._named(animation):
            strength = one.coefficient * _shares(one, above)
            for key, weight in self._weights(one, unix_time_s):
                total = total + weight * strength[key] * _rows(spectrum, one.curve[key], total.shape)
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
