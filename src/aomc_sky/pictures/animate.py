"""Background skies: at one time or at many, side by side, or one after the other as a GIF (`aomc_sky.animate`)."""

from __future__ import annotations

import dataclasses
import datetime
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.formats.sky_toml.rules import moment_text
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.picture import MOVING_SUFFIX, picture_path, save_animation
from aomc_sky.pictures.content import RADIANCE, Dome, Picture
from aomc_sky.pictures.dome import SIZES_PX, USUAL_COLOURS, ColourChoice, View, colours_of, palette_of
from aomc_sky.pictures.panels import figure_of
from aomc_sky.pictures.source import LOBE_BINS, lobe_note, marks_of
from aomc_sky.skies.lobes.animation import Reference
from aomc_sky.skies.lobes.background import BackgroundSky, background_at
from aomc_sky.skies.lobes.patches import patch_shares
from aomc_sky.skies.lobes.sky import LobeSky
from aomc_sky.steps import counted

FRAME_MS, SIZE_PX = 120, 640
_WIDEST_PX = 2000


def animate(
    background: BackgroundSky,
    path: str | Path,
    *,
    wavelength_nm: float = 550.0,
    start_s: float | None = None,
    stop_s: float | None = None,
    n_frames: int = 48,
    frame_ms: int = FRAME_MS,
    interpolation: str = "crossfade",
    title: str = "",
    seen_from: str = "above",
    limits: Sequence[float] | None = None,
    size_px: int = SIZE_PX,
    cmap: Any = None,
    norm: Any = None,
    caption: bool = True,
) -> np.ndarray:
    """Write a background sky over time as a GIF that repeats.

    Parameters
    ----------
    background : BackgroundSky
        What changes.
    path : str or Path
        The file. [.gif]
    wavelength_nm : float
        Wavelength. [nm]
    start_s, stop_s : float, optional
        Time of the first frame, and where the animation would begin again; by default from the first key to the last,
        or the day or the week after which the sky repeats itself. [s since 1970-01-01 UTC]
    n_frames : int
        Frames, evenly spaced in time. [2 to 1000]
    frame_ms : int
        How long each is shown. [ms, 20 to 10000]
    interpolation : {"crossfade", "slerp"}
        What lobes do between their keys.
    title : str
        Above the dome.
    seen_from : {"above", "below"}
        As a map with east to the right, or as an eye that looks up sees it.
    limits : (float, float), optional
        Values of the two ends of the colour bar; by default those of all frames, which share their colours.
    size_px : int
        Width. [dots, 300 to 2000]
    cmap, norm, caption
        As `plot` has them.

    Returns
    -------
    ndarray, float64
        Times of the frames. [s since 1970-01-01 UTC]

    Raises
    ------
    UsageError
        An argument that is not allowed.
    SceneError
        A wavelength outside the curves of the sky.
    OutputError
        The file cannot be written; what stood there before is unchanged.
    MissingExtraError
        matplotlib is not installed: ``pip install "aomc-sky[plot]"``.

    Notes
    -----
    Each lobe is drawn by its exact mean in patches of 2 by 2 degrees. Cost: about 0.1 s for a frame, and 0.3 s for
    each lobe of its own shape.
    """
    span = time_span_s(background)
    times = frame_times_s(span[0] if start_s is None else start_s, span[1] if stop_s is None else stop_s, n_frames)
    picture = moving_picture(background, wavelength_nm, times.tolist(), title=title, interpolation=interpolation)
    choice = ColourChoice(limits=limits, cmap=cmap, norm=norm)
    view = View.named(seen_from)
    write_frames(picture, path, frame_ms=frame_ms, view=view, choice=choice, size_px=size_px, has_caption=caption)
    return times


def write_frames(
    picture: Picture,
    path: str | Path,
    *,
    frame_ms: int = FRAME_MS,
    view: View = View.ABOVE,
    choice: ColourChoice = USUAL_COLOURS,
    size_px: int = SIZE_PX,
    has_caption: bool = True,
) -> None:
    """Write the domes of a picture one after the other; arguments and errors as `animate` has them."""
    target = picture_path(path, may_move=True)
    if target.suffix.lower() != MOVING_SUFFIX:
        raise UsageError(f"an animation ends in {MOVING_SUFFIX}, got {target.name!r}")
    if not 20 <= frame_ms <= 10_000:
        raise UsageError(f"a frame is shown for 20 to 10000 ms, got {frame_ms}")
    if not SIZES_PX[0] <= size_px <= _WIDEST_PX:
        raise UsageError(f"an animation is {SIZES_PX[0]} to {_WIDEST_PX} dots wide, got {size_px}")
    frames = (dataclasses.replace(picture, domes=(dome,)) for dome in picture.domes)
    style: dict[str, Any] = {
        "size_px": size_px,
        "view": view,
        "like": picture,
        "choice": choice,
        "has_caption": has_caption,
    }
    figures = (figure_of(frame, **style) for frame in counted(frames, "frame", len(picture.domes)))
    save_animation(figures, target, palette=palette_of(colours_of(picture, choice)), frame_ms=frame_ms)


MOVING_BINS = (45, 180)
"""Equal bins of zenith and azimuth of the pictures of an animation."""

_DAY_S = 86400.0
_SUNDAY_S = 3 * _DAY_S  # 1970-01-04 was a Sunday


def lobe_picture(
    skies: Sequence[tuple[str, Sequence[LobeSky]]],
    wavelength_nm: float,
    *,
    title: str = "",
    bins: tuple[int, int] = LOBE_BINS,
) -> Picture:
    """Skies of lobes at one wavelength, W m-2 sr-1 nm-1; the light of the skies under one title adds.

    Each lobe is drawn by its exact mean in equal bins of zenith and azimuth, and marked where it is narrower than a
    patch.
    """
    grid = PatchGrid.regular(*bins)
    domes = tuple(_dome(name, parts, wavelength_nm, grid) for name, parts in counted(skies, "sky", len(skies)))
    return Picture(domes=domes, quantity=RADIANCE, title=title, notes=(lobe_note(bins),))


def _dome(name: str, skies: Sequence[LobeSky], wavelength_nm: float, grid: PatchGrid) -> Dome:
    components = [c for sky in skies for c in sky.lower([wavelength_nm])]
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
    fixed = [a for a in animations if a.reference is Reference.ABSOLUTE and a.time_days.size > 1]
    if fixed:
        starts = [a.reference_unix_s + _DAY_S * float(a.time_days[0]) for a in fixed]
        stops = [a.reference_unix_s + _DAY_S * float(a.time_days[-1]) for a in fixed]
        return min(starts), max(stops)
    midnight = -3600.0 * sky.utc_offset_h
    if any(a.reference is Reference.HEBDOMADAL for a in animations):
        return midnight + _SUNDAY_S, midnight + _SUNDAY_S + 7 * _DAY_S
    return midnight, midnight + _DAY_S


def frame_times_s(start_s: float, stop_s: float, n_frames: int) -> np.ndarray:
    """Times of 2 to 1000 frames: even steps, the last one a step before the end, where a repeating sky begins again."""
    if not 2 <= n_frames <= 1000:
        raise UsageError(f"an animation has 2 to 1000 frames, got {n_frames}")
    if not stop_s > start_s:
        raise UsageError("an animation must end later than it starts")
    return start_s + (stop_s - start_s) * np.arange(n_frames) / n_frames


def time_text(sky: BackgroundSky, unix_time_s: float) -> str:
    """A time as its picture says it: of the day or the week where the sky repeats, else the date in UTC."""
    references = {a.reference for a in sky.animations.values() if a.time_days.size > 1}
    if Reference.ABSOLUTE in references:
        return moment_text(float(round(unix_time_s)))
    local = datetime.datetime(1970, 1, 1) + datetime.timedelta(seconds=round(unix_time_s + 3600.0 * sky.utc_offset_h))
    days = ("Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday")
    day = f"{days[local.weekday()]} " if Reference.HEBDOMADAL in references else ""
    return f"{day}{local:%H:%M} local time"


def moving_picture(
    sky: BackgroundSky,
    wavelength_nm: float,
    times_s: Iterable[float],
    *,
    title: str = "",
    interpolation: str = "crossfade",
) -> Picture:
    """A background sky at several times, a dome for each, to be drawn side by side or one after the other.

    `interpolation` says what lobes do between their keys; times are seconds since 1970-01-01 UTC.
    """
    skies = [(time_text(sky, t), [background_at(sky, t, interpolation=interpolation)]) for t in times_s]
    return lobe_picture(skies, wavelength_nm, title=title, bins=MOVING_BINS)
