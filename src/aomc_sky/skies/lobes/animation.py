"""One lobe that moves and changes with time: its keys, and the rules of time of background-sky files."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import SceneError
from aomc_sky.phase.vectorised import real
from aomc_sky.skies.lobes.file.data import ReferenceType
from aomc_sky.skies.lobes.lobe import checked, vertical_in_local

_DAY_S = 86400.0
_EPOCH_WEEKDAY = 4.0  # 1970-01-01 was a Thursday, four days after Sunday


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
    reference : ReferenceType
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
    reference: ReferenceType
    reference_unix_s: float = 0.0

    def __post_init__(self) -> None:
        n_key = len(self.kind)
        arrays = (self.param0, self.param1, self.coefficient, self.curve, self.time_days)
        if n_key == 0 or any(a.shape != (n_key,) for a in arrays) or self.quaternion.shape != (n_key, 4):
            raise SceneError("an animation has at least one key, and every member one value for each key")
        for key, kind in enumerate(self.kind):
            checked(kind, self.param0[key], self.param1[key])
        vertical_in_local(self.quaternion)
        if not np.all(np.isfinite(self.time_days)) or np.any(np.diff(self.time_days) < 0.0):
            raise SceneError("the keys of an animation must be in the order of time")
        if not np.all((self.coefficient >= 0.0) & (self.coefficient < np.inf)):
            raise SceneError("the coefficient of a lobe must be finite and not negative")

    def relative_days(self, unix_time_s: ArrayLike, *, utc_offset_h: float = 0.0) -> np.ndarray:
        """Days since the reference, of a repeating animation in [0, 1) or [0, 7).

        `unix_time_s` counts seconds since 1970-01-01 UTC. `utc_offset_h` is local time less UTC, for the midnight of
        repeating animations.
        """
        time, offset = real(unix_time_s), real(utc_offset_h)
        if not np.all(np.isfinite(time)) or not np.all(np.isfinite(offset)):
            raise SceneError("a time and its UTC offset must be finite")
        if self.reference is ReferenceType.ABSOLUTE:
            return (time - self.reference_unix_s) / _DAY_S
        local = time + 3600.0 * utc_offset_h
        if self.reference is ReferenceType.DIURNAL:
            return np.mod(local, _DAY_S) / _DAY_S
        return np.mod(local + _EPOCH_WEEKDAY * _DAY_S, 7.0 * _DAY_S) / _DAY_S

    def between(self, relative_days: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Keys before and after a time in days, int64, and the share of the later one [0 to 1).

        Both keys are equal up to the first and from the last key on: the end keys hold, also at midnight.
        """
        time = np.asarray(relative_days, dtype=np.float64)
        last = self.time_days.size - 1
        after = np.searchsorted(self.time_days, time, side="right")
        low = np.clip(after - 1, 0, last)
        high = np.where((time <= self.time_days[0]) | (after > last), low, np.minimum(after, last))
        span = self.time_days[high] - self.time_days[low]
        fraction = np.where(high > low, (time - self.time_days[low]) / np.where(high > low, span, 1.0), 0.0)
        return low, high, fraction
