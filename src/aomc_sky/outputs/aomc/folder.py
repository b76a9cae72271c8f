"""The folder of an export to the AOMC program: our sky beside copies of the scene's own files."""

from __future__ import annotations

import shutil
import warnings
from pathlib import Path

import numpy as np

from aomc_sky.errors import InputWarning, SceneError
from aomc_sky.formats.aomc.amc import read_lambbot
from aomc_sky.outputs.aomc.skydist import INTENSITIES, AomcSky, read_quietly, write_amc_copy, write_aomc_sky
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.regular_file import open_regular

SKYDIST = "skydist.inp"
COUNTS = "counts.csv"
_LEFT_OUT = (SKYDIST, "amc.inp", "difcol.inp")
"""Files of a scene that are not copied: two are written anew, the third belongs to the program's own source."""


def check_scene(amc_inp: Path, wavelength_nm: np.ndarray) -> None:
    """Raise unless the lambbot.inp beside amc.inp has the wavebands of the run. [nm]"""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)  # the run has reported them
        of_scene = read_lambbot(amc_inp.parent / "lambbot.inp", lenient=True).wavelength_nm
    if not np.array_equal(of_scene, wavelength_nm):
        raise SceneError(
            f"{amc_inp.parent / 'lambbot.inp'} has {of_scene.size} wavebands that are not the {wavelength_nm.size} of "
            "the run; name the scene that was run"
        )


def write_aomc_folder(sky: AomcSky, folder: RunFolder, amc_inp: Path | None) -> list[str]:
    """Write the sky and its counts, and with a scene all files beside it; return the names of the files.

    amc.inp is copied last, with the new iterations and light source 1; every other ``.inp`` file beside it
    as it is, except skydist.inp and difcol.inp.
    """
    write_aomc_sky(sky, folder.path)
    names = [SKYDIST, COUNTS]
    folder.write(COUNTS, counts_text(sky))
    if sky.photons_of_run is not None:
        folder.write(INTENSITIES, intensities_text(sky, sky.photons_of_run))
        names.append(INTENSITIES)
    if amc_inp is None:
        return names
    others = sorted(p for p in amc_inp.parent.glob("*.inp") if p.is_file() and p.name not in _LEFT_OUT)
    for path in others:
        with folder.stream(path.name) as target, open_regular(path) as source:
            shutil.copyfileobj(source, target)
    write_amc_copy(amc_inp, folder.path / "amc.inp", sky.iterations)
    return [*names, "amc.inp", *(p.name for p in others)]


def counts_text(sky: AomcSky) -> bytes:
    """Photons that the program launches from each whole degree, a line for each that has any."""
    lines = ["waveband,wavelength_nm,sky_wavelength_nm,zenith_index,azimuth_index,photons"]
    for band, counts in enumerate(sky.counts):
        head = f"{band + 1},{float(sky.wavelength_nm[band])!r},{float(sky.sky_wavelength_nm[band])!r}"
        zenith, azimuth = np.nonzero(counts)
        rows = zip((zenith + 1).tolist(), azimuth.tolist(), counts[zenith, azimuth].tolist(), strict=True)
        lines += [f"{head},{z},{a},{n}" for z, a, n in rows]
    return "\n".join([*lines, ""]).encode("ascii")


def intensities_text(sky: AomcSky, photons_of_run: np.ndarray) -> bytes:
    """What a waveband's photons stand for: those of the run over those that the program launches."""
    lines = ["waveband,wavelength_nm,intensity,photons_of_the_run,photons_launched"]
    launched = sky.counts.sum(axis=(1, 2)).tolist()
    for band, (n_run, n_launched) in enumerate(zip(photons_of_run.tolist(), launched, strict=True)):
        intensity = n_run / n_launched if n_launched else 0.0
        lines.append(f"{band + 1},{float(sky.wavelength_nm[band])!r},{intensity!r},{n_run},{n_launched}")
    return "\n".join([*lines, ""]).encode("ascii")


def water_note(folder: RunFolder) -> str:
    """Which files of the water the program will look for in vain, with their rows; empty where all are there.

    The program opens all four whatever amc.inp says, and stops where the first number of one differs from amc.inp.
    """
    if folder.size_of("amc.inp") is None:
        return (
            "the AOMC program also reads amc.inp, lambbot.inp and the files of the water (conc.inp, abs.inp, scat.inp, "
            "spf.inp) from the folder of skydist.inp"
        )
    config = read_quietly(folder.path / "amc.inp")
    rows = {
        "conc.inp": config.n_concentration_layers,
        "abs.inp": config.n_wavebands,
        "scat.inp": config.n_wavebands,
        "spf.inp": config.n_spf_angles,
    }
    missing = [f"{name} ({n} row{'s' if n != 1 else ''})" for name, n in rows.items() if folder.size_of(name) is None]
    if not missing:
        return ""
    return (
        "the AOMC program still needs files of the water, which are not in the folder of the scene: "
        f"{', '.join(missing)}, for {config.n_constituents} constituent{'s' if config.n_constituents != 1 else ''}"
    )
