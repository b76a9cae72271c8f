"""What ``aomc-sky lobes`` writes: a table of radiances, a dataset, a picture, a run folder of photons."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from aomc_sky.extras import optional_module
from aomc_sky.formats.sky_toml.rules import moment_text
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.folder.target_file import check_folder, check_target
from aomc_sky.source.backgrounds.scene import LobeScene


def write_files(scene: LobeScene, arguments: argparse.Namespace, formats: tuple[str, ...]) -> dict[str, str]:
    """Write everything that the options ask for.

    Parameters
    ----------
    scene : LobeScene
        The lobes.
    arguments : argparse.Namespace
        Options of the sub-command.
    formats : tuple of str
        Photon files of a run folder.

    Returns
    -------
    dict
        What was written, and where.
    """
    written: dict[str, str] = {}
    skydist, picture = arguments.write_skydist, arguments.plot
    if arguments.netcdf is not None:
        for name in ("xarray", "h5netcdf", "h5py"):
            optional_module(name, extra="netcdf")
    if picture is not None:
        optional_module("matplotlib", extra="plot")
    if arguments.out is not None:
        check_folder(arguments.out, "--out")
        skydist = str(Path(arguments.out) / "skydist.inp") if skydist is None else skydist
        if picture is None and find_spec("matplotlib") is not None:
            picture = str(Path(arguments.out) / "sky.png")
    files = {"--write-skydist": skydist, "--netcdf": arguments.netcdf, "--plot": picture}
    for option, path in files.items():
        if path is not None:
            check_target(path, option, force=arguments.force, inputs=[section.file for section in scene.sections])
    if arguments.out is not None:
        written["photons"] = _write_photons(scene, arguments, formats)
    if skydist or arguments.netcdf:
        written |= _write_tables(scene, arguments, skydist)
    if picture:
        write_picture(scene, picture)
        written["picture"] = picture
    elif arguments.out is not None:
        written["no picture"] = 'pip install "aomc-sky[plot]" draws one'
    return written


def _write_photons(scene: LobeScene, arguments: argparse.Namespace, formats: tuple[str, ...]) -> str:
    from aomc_sky.cli.progress import progress_bar
    from aomc_sky.engine.run import JobOptions, run_job

    sampled = scene.scene(arguments.iterations)
    source = sampled.source(arguments.seed)
    options = JobOptions(formats=formats, force=arguments.force)
    with progress_bar(enabled=not (arguments.quiet or arguments.json)) as progress:
        run_job(source, sampled, Path(arguments.out), options, progress)
    return str(arguments.out)


def _write_tables(scene: LobeScene, arguments: argparse.Namespace, skydist: str | None) -> dict[str, str]:
    from aomc_sky.outputs.tables.lobes import patch_radiance, write_lobe_netcdf, write_lobe_skydist

    grid = PatchGrid.regular(*arguments.bins)
    radiance = patch_radiance(scene, grid)
    writers: list[tuple[str, str | None, Callable[[str], None]]] = [
        ("radiances", skydist, lambda path: write_lobe_skydist(scene, radiance, path)),
        ("dataset", arguments.netcdf, lambda path: write_lobe_netcdf(scene, radiance, grid, path)),
    ]
    for _, path, write in writers:
        if path:
            write(path)
    return {what: path for what, path, _ in writers if path}


def write_picture(scene: LobeScene, path: str) -> None:
    """Draw the sky dome at the wavelength nearest to 550 nm."""
    from aomc_sky.outputs.picture import picture_path, save_picture
    from aomc_sky.pictures.domes.background import lobe_picture
    from aomc_sky.pictures.drawing.panels import figure_of

    target = picture_path(path)
    wavelength = float(scene.wavelength_nm[np.argmin(np.abs(scene.wavelength_nm - 550.0))])
    files = ", ".join(Path(section.file).name for section in scene.sections)
    title = f"{files} at {wavelength:g} nm\n{moment_text(scene.sections[0].time)}"
    figure = figure_of(lobe_picture([("", scene.skies)], wavelength, title=title))
    save_picture(figure, target, dpi=figure.dpi)
