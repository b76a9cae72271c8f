"""Background skies over time, lobes that move and change, each with a spectrum in absolute units; and at one time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import SceneError, number, require_kind, require_one_of
from aomc_sky.formats.report import Report
from aomc_sky.phase.vectorised import real, shape_of
from aomc_sky.record import same_content, short_repr
from aomc_sky.skies.lobes.file.check import check_sky, close_by_hand
from aomc_sky.skies.lobes.file.data import Animation
from aomc_sky.skies.lobes.horizon import LobeWeightingWord, mass_above_horizon
from aomc_sky.skies.lobes.lobe import slerp
from aomc_sky.skies.lobes.sky import LobeSky, WeightedLobe, spectra_at

AboveWord = Literal["sphere", "horizon", "projected"]


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class BackgroundSky:
    """Starlight, airglow, city light: animated lobes whose light adds, in absolute units.

    Parameters
    ----------
    animations : mapping of str to Animation
        The animations by name.
    wavelength_nm : ndarray, float64, shape (n_wavelength,)
        Wavelengths of the curves, rising. [nm]
    curves : ndarray, float64, shape (n_curve, n_wavelength)
        Spectral irradiance integrated over the whole sphere. [W m-2 nm-1, >= 0]
    utc_offset_h : float
        Local time less UTC, for the midnight of repeating animations. [h]
    texts : tuple of str
        Notes for a person, such as what the file says in words.

    Examples
    --------
    >>> town = sky.lobes.SkyLobe(kind="hg", width=0.8, zenith_deg=85.0, spectrum=[1e-8])
    >>> sky.lobes.write_background(
    ...     "town.h5", sky.lobes.background_of_lobes({"town": town}, [550.0])
    ... )
    >>> sorted(sky.read_background("town.h5").animations)
    ['town']
    """

    animations: Mapping[str, Animation]
    wavelength_nm: np.ndarray
    curves: np.ndarray
    utc_offset_h: float = 0.0
    texts: tuple[str, ...] = field(default=(), compare=False)

    __eq__ = same_content
    __repr__ = short_repr

    def __post_init__(self) -> None:
        require_kind(self.animations, Mapping, "the mapping of sky.lobes.background_of_lobes")
        for name in ("wavelength_nm", "curves"):
            require_kind(getattr(self, name), np.ndarray, f"{name}=np.array(...)")
        report = Report(path="background sky")
        check_sky(self.animations, self.wavelength_nm, self.curves, report)
        close_by_hand(report)
        if not np.all(np.isfinite(real(self.utc_offset_h))):
            raise SceneError("the UTC offset must be finite")

    def irradiance(
        self, animation: str | None, unix_time_s: ArrayLike, wavelength_nm: ArrayLike, *, above: AboveWord = "sphere"
    ) -> np.ndarray:
        """Spectral irradiance of an animation: coefficient times curve, linear in time and wavelength. [W m-2 nm-1]

        SceneError: a wavelength is outside the curves by more than 1e-6 of itself, or a time is not finite.

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
        """
        require_one_of(get_args(AboveWord), above, "above")
        if animation is not None:
            require_one_of(self.animations, animation, "animation")
        spectrum = spectra_at(wavelength_nm, self.wavelength_nm, self.curves)
        total = np.zeros(shape_of((real(unix_time_s), spectrum[0])))
        for lobe in self.animations.values() if animation is None else [self.animations[animation]]:
            strength = lobe.coefficient * _shares(lobe, above)
            low, high, fraction = lobe.between(lobe.relative_days(unix_time_s, utc_offset_h=self.utc_offset_h))
            for key, weight in ((low, 1.0 - fraction), (high, fraction)):
                total = total + weight * strength[key] * _rows(spectrum, lobe.curve_index[key], total.shape)
        return total


InterpolationWord = Literal["crossfade", "slerp"]


def background_at(
    backgrounds: BackgroundSky | Sequence[BackgroundSky],
    unix_time_s: float,
    *,
    utc_offset_h: float | None = None,
    interpolation: InterpolationWord = "crossfade",
) -> LobeSky:
    """One or several background skies at one time.

    Lobes are called as the animations, behind that ``/key`` (from 0) where two keys fade into each other, before that
    ``sky/`` (from 1) where several skies add. Lobes without light are left out. SceneError: the time or the offset is
    not finite.

    Parameters
    ----------
    backgrounds : BackgroundSky or sequence of BackgroundSky
        The skies; the light of several adds.
    unix_time_s : float
        Time. [s since 1970-01-01 UTC]
    utc_offset_h : float, optional
        Local time less UTC, for the midnight of repeating animations. [h] Left out: that of each sky.
    interpolation : {"crossfade", "slerp"}
        How lobes go from one key to the next; their irradiance is linear in time either way. With "crossfade" the lobes
        of both keys stand still, and the light goes from one to the other. With "slerp" one lobe turns the short way at
        a constant rate, its parameters linear in time, and keys of different kinds fade.

    Examples
    --------
    >>> town = sky.lobes.SkyLobe(kind="hg", width=0.8, zenith_deg=85.0, spectrum=[1e-8])
    >>> sky.lobes.write_background(
    ...     "town.h5", sky.lobes.background_of_lobes({"town": town}, [550.0])
    ... )
    >>> at_noon = sky.background_at(sky.read_background("town.h5"), unix_time_s=43200.0)
    >>> [lobe.name for lobe in at_noon.lobes]
    ['town']
    """
    require_one_of(get_args(InterpolationWord), interpolation, "interpolation")
    skies = [backgrounds] if isinstance(backgrounds, BackgroundSky) else list(backgrounds)
    for one in skies:
        require_kind(one, BackgroundSky, "sky.read_background('town.h5')")
    unix_time_s = number("unix_time_s", unix_time_s)
    utc_offset_h = None if utc_offset_h is None else number("utc_offset_h", utc_offset_h)
    lobes: list[WeightedLobe] = []
    for place, sky in enumerate(skies, start=1):
        prefix = f"{place}/" if len(skies) > 1 else ""
        offset = sky.utc_offset_h if utc_offset_h is None else utc_offset_h
        for name, animation in sky.animations.items():
            time = float(animation.relative_days(unix_time_s, utc_offset_h=offset))
            lobes += _lobes(sky, animation, prefix + name, time, interpolation)
    return LobeSky(lobes=tuple(lobes), texts=tuple(dict.fromkeys(text for sky in skies for text in sky.texts)))


def _lobes(
    sky: BackgroundSky, animation: Animation, name: str, relative_days: float, interpolation: str
) -> list[WeightedLobe]:
    """The lobe of an animation, or the two that fade into each other."""
    keys = animation.between(relative_days)
    low, high, fraction = int(keys[0]), int(keys[1]), float(keys[2])
    light = animation.coefficient[[low, high], None] * sky.curves[animation.curve_index[[low, high]]]
    light *= np.array([[1.0 - fraction], [fraction]])
    is_one_kind = animation.lobe_type[low] == animation.lobe_type[high]
    shape = np.column_stack([animation.param0, animation.param1, animation.quaternion])
    if is_one_kind and (interpolation == "slerp" or np.all(shape[low] == shape[high])):
        share = fraction if interpolation == "slerp" else 0.0
        lobes = [_lobe(sky, animation, name, low, high, share, light.sum(axis=0))]
    else:
        lobes = [_lobe(sky, animation, f"{name}/{key}", key, key, 0.0, light[i]) for i, key in enumerate((low, high))]
    return [lobe for lobe in lobes if np.any(lobe.spectrum > 0.0)]


def _lobe(
    sky: BackgroundSky, animation: Animation, name: str, low: int, high: int, share: float, light: np.ndarray
) -> WeightedLobe:
    """One lobe between two keys."""
    first, second = (
        float((1.0 - share) * shape[low] + share * shape[high]) for shape in (animation.param0, animation.param1)
    )
    return WeightedLobe(
        name=name,
        kind=animation.kind[low],  # type: ignore[arg-type]  # one that `_check` knows
        param0=first,
        param1=second,
        quaternion=slerp(animation.quaternion[low], animation.quaternion[high], share),
        wavelength_nm=sky.wavelength_nm,
        spectrum=light,
    )


def _shares(lobe: Animation, above: AboveWord) -> np.ndarray:
    """Share of each key's lobe that counts."""
    if above == "sphere":
        return np.ones(len(lobe))
    weighting: LobeWeightingWord = "plain" if above == "horizon" else "projected"
    return np.array(
        [
            float(mass_above_horizon(kind, *shape, weighting=weighting))  # type: ignore[arg-type]  # as above
            for kind, *shape in zip(lobe.kind, lobe.param0, lobe.param1, lobe.quaternion, strict=True)
        ]
    )


def _rows(spectrum: np.ndarray, curve: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """spectrum[curve[time], wavelength] where times and wavelengths broadcast to `shape`."""
    wide = np.broadcast_to(
        spectrum.reshape(spectrum.shape[0], *(1,) * (len(shape) - spectrum.ndim + 1), *spectrum.shape[1:]),
        (spectrum.shape[0], *shape),
    )
    return np.take_along_axis(wide, np.broadcast_to(curve, shape)[None], axis=0)[0]
