"""Background skies: lobes at one time, or at several times side by side."""

from __future__ import annotations

import datetime
from collections.abc import Iterable, Sequence

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.formats.sky_toml.keys import moment_text
from aomc_sky.grid import PatchGrid
from aomc_sky.pictures.picture import MOST_PANELS, RADIANCE, Dome, Picture
from aomc_sky.pictures.source import LOBE_BINS, lobe_note, marks_of
from aomc_sky.progress import counted
from aomc_sky.skies.lobes.background import BackgroundSky, InterpolationWord, background_at
from aomc_sky.skies.lobes.file.data import ReferenceType
from aomc_sky.skies.lobes.patches import patch_shares
from aomc_sky.skies.lobes.sky import LobeSky

MOVING_BINS = (45, 180)
"""Equal bins of zenith and azimuth of skies at several times."""

_DAY_S = 86400.0
_SUNDAY_S = 3 * _DAY_S  # 1970-01-04 was a Sunday


def lobe_picture(
    skies: Sequence[tuple[str, LobeSky]],
    wavelength_nm: float,
    *,
    title: str = "",
    bins: tuple[int, int] = LOBE_BINS,
) -> Picture:
    """Skies of lobes at one wavelength, each with its title. [W m-2 sr-1 nm-1]

    Each lobe is drawn by its exact mean in equal bins of zenith and azimuth, and marked where it is narrower than a
    patch.
    """
    grid = PatchGrid.regular(*bins)
    domes = tuple(_dome(name, sky, wavelength_nm, grid) for name, sky in counted(skies, "sky", len(skies)))
    return Picture(domes=domes, quantity=RADIANCE, title=title, notes=(lobe_note(bins),))


def _dome(name: str, sky: LobeSky, wavelength_nm: float, grid: PatchGrid) -> Dome:
    components = sky.lower([wavelength_nm])
    light = np.zeros(grid.n_patches)
    for component in components:
        light += float(component.strength[0]) * patch_shares(component, grid)
    radiance = light / grid.projected_solid_angle_sr
    return Dome(grid=grid, values=radiance, title=name, marks=marks_of(components, grid))


def time_span_s(sky: BackgroundSky) -> tuple[float, float]:
    """Time over which a background sky changes, start and stop. [s since 1970-01-01 UTC]

    From the first key to the last one of the animations that do not repeat; else a week from a Sunday's midnight, or a
    day, of local time.
    """
    animations = sky.animations.values()
    fixed = [a for a in animations if a.reference is ReferenceType.ABSOLUTE and a.relative_time_days.size > 1]
    if fixed:
        starts = [a.time_point_s + _DAY_S * float(a.relative_time_days[0]) for a in fixed]
        stops = [a.time_point_s + _DAY_S * float(a.relative_time_days[-1]) for a in fixed]
        return min(starts), max(stops)
    midnight = -3600.0 * sky.utc_offset_h
    if any(a.reference is ReferenceType.HEBDOMADAL for a in animations):
        return midnight + _SUNDAY_S, midnight + _SUNDAY_S + 7 * _DAY_S
    return midnight, midnight + _DAY_S


def frame_times_s(start_s: float, stop_s: float, n_frames: int) -> np.ndarray:
    """Times of 2 to 12 domes: even steps, the last one a step before the end, where a repeating sky begins again."""
    if not 2 <= n_frames <= MOST_PANELS:
        raise UsageError(f"--frames is 2 to {MOST_PANELS}, as many domes as fit side by side, got {n_frames}")
    return start_s + (stop_s - start_s) * np.arange(n_frames) / n_frames


def time_text(sky: BackgroundSky, unix_time_s: float) -> str:
    """A time as its picture says it: of the day or the week where the sky repeats, else the date in UTC."""
    references = {a.reference for a in sky.animations.values() if a.relative_time_days.size > 1}
    if ReferenceType.ABSOLUTE in references:
        return moment_text(float(round(unix_time_s)))
    local = datetime.datetime(1970, 1, 1) + datetime.timedelta(seconds=round(unix_time_s + 3600.0 * sky.utc_offset_h))
    days = ("Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday")
    day = f"{days[local.weekday()]} " if ReferenceType.HEBDOMADAL in references else ""
    return f"{day}{local:%H:%M} local time"


def moving_picture(
    sky: BackgroundSky,
    wavelength_nm: float,
    times_s: Iterable[float],
    *,
    title: str = "",
    interpolation: InterpolationWord = "crossfade",
) -> Picture:
    """A background sky at several times, a dome for each.

    `interpolation` says what lobes do between their keys; times are seconds since 1970-01-01 UTC.
    """
    skies = [(time_text(sky, t), background_at(sky, t, interpolation=interpolation)) for t in times_s]
    return lobe_picture(skies, wavelength_nm, title=title, bins=MOVING_BINS)
