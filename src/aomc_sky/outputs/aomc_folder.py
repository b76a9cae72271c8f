"""The folder of an export to the AOMC program: our sky beside copies of the scene's own files."""

from __future__ import annotations

import shutil
import warnings
from pathlib import Path

import numpy as np

from aomc_sky.errors import ForeignOutputError, InputWarning, SceneError
from aomc_sky.formats.lambbot import read_lambbot
from aomc_sky.outputs.aomc_skydist import AomcSky, write_amc_copy, write_aomc_sky
from aomc_sky.outputs.run_folder import PLAN, RunFolder

SKYDIST = "skydist.inp"
_OURS = (SKYDIST, "amc.inp", "lambbot.inp")
_LEFT_OUT = (*_OURS[:2], "difcol.inp")
"""Files of a scene that are not copied: two are written anew, the third belongs to the program's own source."""


def refuse_foreign_scene(folder: RunFolder) -> None:
    """Raise where a folder holds the files of a scene that no export wrote."""
    found = [name for name in _OURS if folder.size_of(name) is not None]
    if found and folder.size_of(PLAN) is None:
        raise ForeignOutputError(
            f"{folder.path} holds {found[0]} but no {PLAN}: a scene of yours; choose another --out, or write --force "
            "to replace it"
        )


def check_scene(amc_inp: Path, wavelength_nm: np.ndarray) -> None:
    """Raise unless the lambbot.inp beside amc.inp has the wavebands of the run.

    Parameters
    ----------
    amc_inp : Path
        amc.inp of the scene.
    wavelength_nm : ndarray, float64, shape (n_band,)
        Wavebands of the run. [nm]
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)  # the run has told them
        found = read_lambbot(amc_inp.parent / "lambbot.inp", lenient=True).wavelength_nm
    if not np.array_equal(found, wavelength_nm):
        raise SceneError(
            f"{amc_inp.parent / 'lambbot.inp'} has {found.size} wavebands that are not the {wavelength_nm.size} of the "
            "run; name the scene that was run"
        )


def write_aomc_folder(sky: AomcSky, folder: RunFolder, amc_inp: Path | None) -> list[str]:
    """Write the sky, and with a scene all that the program reads, amc.inp last.

    Parameters
    ----------
    sky : AomcSky
        What the program shall launch.
    folder : RunFolder
        Where to.
    amc_inp : Path, optional
        The scene: amc.inp is copied with the new iterations and light source 1, every other ``.inp`` file
        beside it as it is, except skydist.inp and difcol.inp.

    Returns
    -------
    list of str
        Names of the files.
    """
    write_aomc_sky(sky, folder.path)
    if amc_inp is None:
        return [SKYDIST]
    others = sorted(p for p in amc_inp.parent.glob("*.inp") if p.is_file() and p.name not in _LEFT_OUT)
    for path in others:
        with folder.stream(path.name) as target, open(path, "rb") as source:
            shutil.copyfileobj(source, target)
    write_amc_copy(amc_inp, folder.path / "amc.inp", sky.iterations)
    return [SKYDIST, "amc.inp", *(p.name for p in others)]
