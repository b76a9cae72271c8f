"""amc.inp and the files beside it become a scene."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np

from aomc_sky.errors import InputFileError, Problem, SceneError, UsageError
from aomc_sky.formats.amc import AmcConfig, LightSource, read_amc
from aomc_sky.formats.amc import Footprint as AmcFootprint
from aomc_sky.formats.difcol import DifcolTable, read_difcol
from aomc_sky.formats.lambbot import LambbotTable, read_lambbot
from aomc_sky.formats.skydist import SkyTable, read_skydist
from aomc_sky.source.footprint import Footprint, FootprintShape
from aomc_sky.source.from_difcol import internal_scene_parts
from aomc_sky.source.from_table import TableOptions, table_scene_parts
from aomc_sky.source.sampling_options import SamplingOptions
from aomc_sky.source.scene import MAX_PHOTONS, Scene
from aomc_sky.wavebands import Wavebands

T = TypeVar("T")

COMPAT_NAME = "--compat aomc"


def read_scene(
    path: str | os.PathLike[str],
    *,
    iterations: int | None = None,
    sky: str | None = None,
    bins: str | None = None,
    weighting: str | None = None,
    compat: str | None = None,
    lenient: bool = False,
    azimuth_bins: str = "n+1",
    wavebands: Sequence[int] | None = None,
) -> Scene:
    """Read amc.inp and the files beside it.

    Parameters
    ----------
    path : str or path
        amc.inp, or the folder that holds it. lambbot.inp and, by the light-source flag, skydist.inp
        or difcol.inp are read from the same folder.
    iterations : int, optional
        Instead of line 1 of amc.inp. [1 to 2^62]
    sky : {"uniform"}, optional
        The diffuse sky of a scene with light-source flag 0; with flag 1 it replaces the sky file, and
        all light is diffuse.
    bins : {"equal", "degrees"}, optional
        What the indices of skydist.inp are; default: what the file declares, else equal bins.
    weighting : {"listed", "projected", "solid-angle", "aomc"}, optional
        What its values are; default: what the file declares, else listed masses. For a sky model:
        "projected" (default) or "solid-angle".
    compat : {"aomc"}, optional
        Everything as the AOMC 1.2.2 program does it: bins, weighting, wavelength rule, rounding,
        directions, order.
    lenient : bool
        Take Fortran's value, with a warning, where a person would read another one.
    azimuth_bins : {"n+1", "n"}
        "n": azimuth indices 1 to n are n equal bins.
    wavebands : sequence of int, optional
        Only these bands get photons; their photons do not depend on the others. [1-based]

    Returns
    -------
    Scene

    Raises
    ------
    InputFileError
        Every problem of every file.
    SceneError
        The files describe a scene that cannot be sampled.
    UsageError
        Options that contradict each other or the files.
    """
    _check_choices(sky=sky, bins=bins, weighting=weighting, compat=compat, azimuth_bins=azimuth_bins)
    amc_path = _amc_path(path)
    config, lambbot, table, difcol, files = _read_all(amc_path, sky, lenient, compat)
    if iterations is not None:
        config = dataclasses.replace(config, iterations=_checked_iterations(iterations))
    bands = _wavebands(lambbot)
    if table is not None:
        options = TableOptions(bins=bins, weighting=weighting, compat=compat, azimuth_bins=azimuth_bins)
        parts = table_scene_parts(config, bands, table, options)
    else:
        assert difcol is not None
        _refuse_table_options(bins=bins, azimuth_bins=None if azimuth_bins == "n+1" else azimuth_bins)
        parts = internal_scene_parts(config, bands, difcol, sky=sky, weighting=weighting, compat=compat)
    parts["n_photons"] = _only_bands(parts["n_photons"], wavebands)
    parts["options"] = {**parts["options"], "compat": compat, "lenient": lenient, "wavebands": _listed(wavebands)}
    scene = Scene(
        wavebands=bands,
        footprint=_footprint(config),
        preset=parts.pop("preset", SamplingOptions()),
        preset_name=COMPAT_NAME if compat else None,
        input_files=files,
        **parts,
    )
    if compat is None:
        for band in np.flatnonzero(scene.n_photons):
            if not scene.is_lit(int(band)):
                scene.refuse_dark_band(int(band))
    return scene


def _check_choices(**given: str | None) -> None:
    allowed = {
        "sky": ("uniform", "perez"),
        "bins": ("equal", "degrees"),
        "weighting": ("listed", "projected", "solid-angle", "aomc"),
        "compat": ("aomc",),
        "azimuth_bins": ("n+1", "n"),
    }
    for name, value in given.items():
        if value is not None and value not in allowed[name]:
            raise UsageError(f"{name} must be one of {', '.join(map(repr, allowed[name]))}, got {value!r}")
    if given["compat"] is not None:
        contradicting = {"bins": ("degrees",), "weighting": ("aomc",), "sky": ("uniform",), "azimuth_bins": ("n+1",)}
        for name, kept in contradicting.items():
            if given[name] is not None and given[name] not in kept:
                raise UsageError(f"{COMPAT_NAME} means {name} {kept[0]!r}, which contradicts {given[name]!r}")
    if given["sky"] == "perez":
        raise UsageError("the Perez sky is not part of this version; write --sky uniform for a uniform diffuse sky")


def _refuse_table_options(**given: str | None) -> None:
    for name, value in given.items():
        if value is not None:
            raise UsageError(f"{name} {value!r} says how to read skydist.inp, but this scene has none (flag 0)")


def _amc_path(path: str | os.PathLike[str]) -> Path:
    given = Path(path)
    return given / "amc.inp" if given.is_dir() else given


def _checked_iterations(iterations: int) -> int:
    if isinstance(iterations, bool) or int(iterations) != iterations or not 1 <= int(iterations) <= MAX_PHOTONS:
        raise SceneError(f"iterations must be a whole number from 1 to 2^62, got {iterations!r}")
    return int(iterations)


def _read_all(
    amc_path: Path, sky: str | None, lenient: bool, compat: str | None
) -> tuple[AmcConfig, LambbotTable, SkyTable | None, DifcolTable | None, dict[str, str]]:
    """Read every file that can be read before the first error is raised, so that all are reported."""
    problems: list[Problem] = []

    def attempt(read: Callable[[], T]) -> T | None:
        try:
            return read()
        except InputFileError as error:
            problems.extend(error.problems)
            return None

    folder = amc_path.parent
    config = attempt(lambda: read_amc(amc_path, lenient=lenient))
    n = config.n_wavebands if config else None
    has_target = bool(config and config.bottom_target)
    files = {"amc": str(amc_path), "lambbot": str(folder / "lambbot.inp")}
    lambbot = attempt(lambda: read_lambbot(files["lambbot"], n_wavebands=n, has_target=has_target, lenient=lenient))
    table, difcol = None, None
    if config is not None and config.light_source is LightSource.FILE and sky is None:
        files["skydist"] = str(folder / "skydist.inp")
        downgrade = frozenset({"E308"}) if compat else frozenset()
        table = attempt(lambda: read_skydist(files["skydist"], lenient=lenient, downgrade=downgrade))
    elif config is not None and config.light_source is LightSource.FILE:
        difcol = _all_diffuse(config.n_wavebands)  # the program reads no difcol.inp under this flag
    elif config is not None:
        files["difcol"] = str(folder / "difcol.inp")
        difcol = attempt(lambda: read_difcol(files["difcol"], n_wavebands=n, lenient=lenient))
    if problems or config is None or lambbot is None:
        raise InputFileError(problems)
    return config, lambbot, table, difcol, files


def _all_diffuse(n_wavebands: int) -> DifcolTable:
    """What a sky model that replaces a sky file means: no beam, the iterations in every band."""
    return DifcolTable(direct_fraction=np.zeros(n_wavebands), intensity=np.ones(n_wavebands))


def _wavebands(lambbot: LambbotTable) -> Wavebands:
    return Wavebands(
        wavelength_nm=lambbot.wavelength_nm,
        bottom_reflectance=lambbot.bottom_reflectance,
        bottom_specular_fraction=lambbot.bottom_specular_fraction,
        target_reflectance=lambbot.target_reflectance,
        target_specular_fraction=lambbot.target_specular_fraction,
    )


def _footprint(config: AmcConfig) -> Footprint:
    if config.footprint is AmcFootprint.CIRCLE:
        d = config.circle_diameter_m
        return Footprint(shape=FootprintShape.CIRCLE, size_x_m=d, size_y_m=d)
    if config.footprint is AmcFootprint.RECTANGLE:
        return Footprint(shape=FootprintShape.RECTANGLE, size_x_m=config.rectangle_x_m, size_y_m=config.rectangle_y_m)
    return Footprint()


def _listed(wavebands: Sequence[int] | None) -> list[int] | None:
    return None if wavebands is None else sorted(int(b) for b in set(wavebands))


def _only_bands(n_photons: np.ndarray, wavebands: Sequence[int] | None) -> np.ndarray:
    if wavebands is None:
        return n_photons
    chosen = _listed(wavebands)
    if not chosen or chosen[0] < 1 or chosen[-1] > n_photons.size:
        raise UsageError(f"wavebands run from 1 to {n_photons.size}, got {list(wavebands)}")
    kept = np.zeros_like(n_photons)
    index = np.array(chosen) - 1
    kept[index] = n_photons[index]
    return kept
