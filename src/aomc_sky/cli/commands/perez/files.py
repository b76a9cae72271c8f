"""What ``aomc-sky perez`` writes of one sky: a table of radiances, photon counts, a picture."""

from __future__ import annotations

import argparse

import numpy as np

from aomc_sky.cli.commands.perez.sky import FoundSky
from aomc_sky.errors import UsageError
from aomc_sky.grid import PatchGrid


def write_table(found: FoundSky, arguments: argparse.Namespace, path: str) -> None:
    """Write skydist.inp: the mean radiance of each patch, weighted as its photons are.

    Read back, the table gives the masses of the model again, for mass = radiance x projected solid angle.
    """
    from aomc_sky.formats.skydist.table import Bins, SkyTable, Values, write_skydist

    if not arguments.wavelength > 0:
        raise UsageError(f"--wavelength must be positive, got {arguments.wavelength:g}")
    grid = PatchGrid.regular(*arguments.bins)
    scale = float(found.sky.relative_integral) if found.dhi is None else found.dhi
    radiance = (found.mass * scale / grid.projected_solid_angle_sr).reshape(1, grid.n_zenith, grid.n_azimuth)
    table = SkyTable(
        wavelength_nm=np.array([arguments.wavelength]),
        radiance=radiance,
        path=path,
    )
    write_skydist(table, path, bins=Bins.EQUAL, values=Values.RADIANCE)


def write_counts(found: FoundSky, arguments: argparse.Namespace, path: str) -> None:
    """Write the photons of every patch with mass, in the columns of a run's counts.csv."""
    from aomc_sky.formats.text_file import write_atomically
    from aomc_sky.outputs.counts import COLUMNS
    from aomc_sky.sampling.allocation import allocate
    from aomc_sky.sampling.mass import normalise

    grid = PatchGrid.regular(*arguments.bins)
    counts = allocate(found.mass, arguments.iterations, seed=arguments.seed)
    mass = normalise(found.mass)
    zenith = [f"{lo!r},{hi!r}" for lo, hi in grid.zenith_bounds_deg.tolist()]
    azimuth = [f"{lo!r},{hi!r}" for lo, hi in grid.azimuth_bounds_deg.tolist()]
    cells = np.flatnonzero(mass)
    rings, columns = np.divmod(cells, grid.n_azimuth)
    rows = zip(rings.tolist(), columns.tolist(), mass[cells].tolist(), counts[cells].tolist(), strict=True)
    lines = [
        f"1,,,perez,{z + 1},{a},{zenith[z]},{azimuth[a]},{m!r},{m * arguments.iterations!r},{n}" for z, a, m, n in rows
    ]
    write_atomically(path, "\n".join([COLUMNS, *lines, ""]))


def write_picture(found: FoundSky, arguments: argparse.Namespace, path: str) -> None:
    """Draw the sky dome."""
    from aomc_sky.pictures.plot import plot

    clearness, brightness = found.sky.clearness, found.sky.brightness
    what = "" if clearness is None else f", ε = {clearness:.4g}, Δ = {brightness:.3g}"
    source = found.source
    when = source.get("sun_at") or source.get("time")
    plot(found.sky, path, title="Perez sky" + what + (f"\n{when}" if when else ""))
