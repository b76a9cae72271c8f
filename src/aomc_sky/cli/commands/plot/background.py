"""Pictures of a background-sky file for ``aomc-sky plot``: one time, times side by side, an animation."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.formats.sky_toml.keys import BackgroundSection
from aomc_sky.formats.sky_toml.rules import moment_text
from aomc_sky.pictures.animate import SIZE_PX, write_frames
from aomc_sky.pictures.content import Picture
from aomc_sky.pictures.domes.background import frame_times_s, lobe_picture, moving_picture, time_span_s
from aomc_sky.pictures.drawing.dome import View
from aomc_sky.pictures.drawing.panels import MOST_PANELS
from aomc_sky.skies.lobes.background import BackgroundSky
from aomc_sky.source.backgrounds.read import read_background
from aomc_sky.source.backgrounds.scene import LobeScene, read_lobe_scene

_WAVELENGTH_NM = 550.0


def still(arguments: argparse.Namespace) -> Picture:
    """The sky at one time, a dome for each wavelength."""
    if arguments.start is not None or arguments.stop is not None or arguments.frames is not None:
        raise UsageError("--time is one time; --start, --stop and --frames are an animation's")
    scene = _scene(arguments, arguments.time)
    wavelengths = scene.wavelength_nm.tolist() if arguments.wavelength else [_nearest(scene)]
    pictures = [lobe_picture([(f"{w:g} nm", scene.skies)], w) for w in wavelengths]
    title = f"{Path(arguments.path).name}, {moment_text(arguments.time)}"
    domes = tuple(picture.domes[0] for picture in pictures)
    return dataclasses.replace(pictures[0], domes=domes, title=_title(arguments, title))


def side_by_side(arguments: argparse.Namespace) -> Picture:
    """The sky at up to 12 times."""
    n_frames = arguments.frames or MOST_PANELS
    if n_frames > MOST_PANELS:
        raise UsageError(f"{n_frames} frames go into a .gif; side by side there is room for {MOST_PANELS}")
    return _over_time(arguments, n_frames)


def moving(arguments: argparse.Namespace, target: Path, *, n_frames: int) -> Picture:
    """Write the animation and return all its frames."""
    picture = _over_time(arguments, n_frames)
    view = View.named(arguments.seen_from)
    write_frames(picture, target, view=view, limits=arguments.range, size_px=arguments.size or SIZE_PX)
    return picture


def _over_time(arguments: argparse.Namespace, n_frames: int) -> Picture:
    sky, wavelength = _sky(arguments)
    return moving_picture(
        sky,
        wavelength,
        frame_times_s(*_span(arguments, sky), n_frames).tolist(),
        title=_title(arguments, f"{Path(arguments.path).name} at {wavelength:g} nm"),
        interpolation=arguments.interpolation,
    )


def _scene(arguments: argparse.Namespace, time_s: float) -> LobeScene:
    section = BackgroundSection(
        file=arguments.path,
        time=time_s,
        animation=None if arguments.animation is None else tuple(arguments.animation),
        utc_offset=arguments.utc_offset,
        interpolation=arguments.interpolation,
    )
    return read_lobe_scene([section], arguments.wavelength)


def _sky(arguments: argparse.Namespace) -> tuple[BackgroundSky, float]:
    """The sky with the animations that were named, and the wavelength."""
    if arguments.wavelength and len(arguments.wavelength) > 1:
        raise UsageError("over time one --wavelength is drawn; several are for one --time")
    scene = _scene(arguments, 0.0)  # refuses names and wavelengths that the file does not have
    sky = read_background(arguments.path, utc_offset_h=arguments.utc_offset)
    if arguments.animation is not None:
        sky = dataclasses.replace(sky, animations={name: sky.animations[name] for name in arguments.animation})
    return sky, float(scene.wavelength_nm[0]) if arguments.wavelength else _nearest(scene)


def _nearest(scene: LobeScene) -> float:
    return float(scene.wavelength_nm[np.argmin(np.abs(scene.wavelength_nm - _WAVELENGTH_NM))])


def _span(arguments: argparse.Namespace, sky: BackgroundSky) -> tuple[float, float]:
    start, stop = time_span_s(sky)
    return start if arguments.start is None else arguments.start, stop if arguments.stop is None else arguments.stop


def _title(arguments: argparse.Namespace, text: str) -> str:
    return text if arguments.title is None else str(arguments.title)
