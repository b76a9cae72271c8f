"""`aomc_sky.animate`: a background sky over time, as a GIF."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.outputs.picture import MOVING_SUFFIX, picture_path, save_animation
from aomc_sky.pictures.content import Picture
from aomc_sky.pictures.domes.background import frame_times_s, moving_picture, time_span_s
from aomc_sky.pictures.drawing.dome import View
from aomc_sky.pictures.drawing.panels import figure_of
from aomc_sky.pictures.drawing.style import SIZES_PX, colours_of, palette_of
from aomc_sky.skies.lobes.background import BackgroundSky

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

    Returns
    -------
    ndarray, float64
        Times of the frames. [s since 1970-01-01 UTC]

    Raises
    ------
    UsageError
        An argument that does not go.
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
    whole = moving_picture(background, wavelength_nm, times.tolist(), title=title, interpolation=interpolation)
    write_frames(whole, path, frame_ms=frame_ms, view=View.named(seen_from), limits=limits, size_px=size_px)
    return times


def write_frames(
    whole: Picture,
    path: str | Path,
    *,
    frame_ms: int = FRAME_MS,
    view: View = View.ABOVE,
    limits: Sequence[float] | None = None,
    size_px: int = SIZE_PX,
) -> None:
    """Write the domes of a picture one after the other; arguments and errors as `animate` has them."""
    target = picture_path(path, may_move=True)
    if target.suffix.lower() != MOVING_SUFFIX:
        raise UsageError(f"an animation ends in {MOVING_SUFFIX}, got {target.name!r}")
    if not 20 <= frame_ms <= 10_000:
        raise UsageError(f"a frame is shown for 20 to 10000 ms, got {frame_ms}")
    if not SIZES_PX[0] <= size_px <= _WIDEST_PX:
        raise UsageError(f"an animation is {SIZES_PX[0]} to {_WIDEST_PX} dots wide, got {size_px}")
    frames = (dataclasses.replace(whole, domes=(dome,)) for dome in whole.domes)
    figures = (figure_of(frame, size_px=size_px, view=view, like=whole, limits=limits) for frame in frames)
    save_animation(figures, target, palette=palette_of(colours_of(whole, limits)), frame_ms=frame_ms)
