"""The launch rules of the AOMC program in Fortran, run on a folder that it would run in."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np

from aomc_sky.formats.aomc.amc import LightSource, read_amc


def launched(program: Path, folder: Path, shape: tuple[int, ...]) -> np.ndarray:
    """Photons of (waveband, zenith index - 1, azimuth index) that the program launches in `folder`."""
    config = read_amc(folder / "amc.inp")
    assert config.light_source is LightSource.FILE
    lines = (folder / "lambbot.inp").read_text().splitlines()[1:]
    wavelengths = [line.split()[0] for line in lines[: config.n_wavebands]]
    job = f"{folder / 'skydist.inp'}\n{config.iterations} {len(wavelengths)}\n{' '.join(wavelengths)}\n"
    done = subprocess.run([program], input=job, capture_output=True, text=True, timeout=120, check=True)
    counts = np.zeros(shape, dtype=np.int64)
    rows = np.loadtxt(done.stdout.splitlines(), dtype=np.int64, ndmin=2)
    if rows.size:
        counts[rows[:, 0] - 1, rows[:, 1] - 1, rows[:, 2]] = rows[:, 3]
    return counts
