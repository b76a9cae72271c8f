"""Background skies at one time: the animated lobes stop, and the light of several skies adds."""

from __future__ import annotations

import enum
from collections.abc import Sequence

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.skies.lobes.animation import LobeAnimation
from aomc_sky.skies.lobes.background import BackgroundSky
from aomc_sky.skies.lobes.quaternion import slerp
from aomc_sky.skies.lobes.sky import LobeSky, WeightedLobe


class Interpolation(enum.Enum):
    """What a lobe does between two keys; its irradiance is linear in time either way.

    CROSSFADE
        The lobes of both keys stand still, and the light goes from one to the other.
    SLERP
        One lobe turns the short way at a constant rate, its parameters linear in time. A key cannot turn into a
        key of another kind: those two fade as above.
    """

    CROSSFADE = "crossfade"
    SLERP = "slerp"


def background_at(
    backgrounds: BackgroundSky | Sequence[BackgroundSky],
    unix_time_s: float,
    *,
    utc_offset_h: float | None = None,
    interpolation: str | Interpolation = Interpolation.CROSSFADE,
) -> LobeSky:
    """One or several background skies at one time.

    Parameters
    ----------
    backgrounds : BackgroundSky or sequence of BackgroundSky
        The skies; the light of several adds.
    unix_time_s : float
        Time. [s since 1970-01-01 UTC]
    utc_offset_h : float, optional
        Local time less UTC, for the midnight of repeating animations. [h] Left out: that of each sky.
    interpolation : {"crossfade", "slerp"} or Interpolation
        What lobes do between their keys.

    Returns
    -------
    LobeSky
        Its lobes are called as the animations, behind that ``/key`` (from 0) where two keys fade into each other,
        before that ``sky/`` (from 1) where several skies add. Lobes without light are left out.

    Raises
    ------
    UsageError
        There is no such interpolation.
    SceneError
        The time or the offset is not finite.
    """
    try:
        how = Interpolation(interpolation)
    except ValueError:
        allowed = ", ".join(repr(m.value) for m in Interpolation)
        raise UsageError(f"interpolation is one of {allowed}, not {interpolation!r}") from None
    skies = [backgrounds] if isinstance(backgrounds, BackgroundSky) else list(backgrounds)
    lobes: list[WeightedLobe] = []
    for number, sky in enumerate(skies, start=1):
        prefix = f"{number}/" if len(skies) > 1 else ""
        offset = sky.utc_offset_h if utc_offset_h is None else utc_offset_h
        for name, animation in sky.animations.items():
            time = float(animation.relative_days(unix_time_s, utc_offset_h=offset))
            lobes += _lobes(sky, animation, prefix + name, time, how)
    return LobeSky(lobes=tuple(lobes))


def _lobes(
    sky: BackgroundSky, animation: LobeAnimation, name: str, relative_days: float, how: Interpolation
) -> list[WeightedLobe]:
    """The lobe of an animation, or the two that fade into each other."""
    keys = animation.between(relative_days)
    low, high, fraction = int(keys[0]), int(keys[1]), float(keys[2])
    light = animation.coefficient[[low, high], None] * sky.curves[animation.curve[[low, high]]]
    light *= np.array([[1.0 - fraction], [fraction]])
    turns = how is Interpolation.SLERP and animation.kind[low] == animation.kind[high]
    if turns or _same_shape(animation, low, high):
        share = fraction if turns else 0.0
        found = [_lobe(sky, animation, name, low, high, share, light.sum(axis=0))]
    else:
        found = [_lobe(sky, animation, f"{name}/{key}", key, key, 0.0, light[i]) for i, key in enumerate((low, high))]
    return [lobe for lobe in found if np.any(lobe.spectrum > 0.0)]


def _lobe(
    sky: BackgroundSky, animation: LobeAnimation, name: str, low: int, high: int, share: float, light: np.ndarray
) -> WeightedLobe:
    """One lobe between two keys."""
    first, second = (
        float((1.0 - share) * shape[low] + share * shape[high]) for shape in (animation.param0, animation.param1)
    )
    return WeightedLobe(
        name=name,
        kind=animation.kind[low],
        param0=first,
        param1=second,
        quaternion=slerp(animation.quaternion[low], animation.quaternion[high], share),
        wavelength_nm=sky.wavelength_nm,
        spectrum=light,
    )


def _same_shape(animation: LobeAnimation, low: int, high: int) -> bool:
    """Whether both keys are the same lobe, so that only its light changes."""
    shape = np.column_stack([animation.param0, animation.param1, animation.quaternion])
    return animation.kind[low] == animation.kind[high] and bool(np.all(shape[low] == shape[high]))
