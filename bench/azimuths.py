"""How evenly the photons of random grids lie in azimuth, beside independent photons.

    python bench/azimuths.py [--sky equal|alternate|function|perez] [--grids 100] [--bands 64]

Each grid has 2 to 90 rings, 3 to 360 columns and 30 to 30 000 photons, half of the time a whole number for each ring.
A scene of as many equal wavebands as `--bands` gives as many independent runs. The table shows, for columns, sectors
of 10 degrees and the modes exp(i m azimuth), the standard deviation over these runs beside that of independent photons
(1.0): the median over the grids, the 99th percentile and the worst. `--before SRC` measures another version as well.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys

import numpy as np

import aomc_sky as sky

N_MODES, N_SECTORS = 12, 36


def sky_of(kind: str, rings: int, columns: int) -> object:
    grid = sky.PatchGrid.regular(rings, columns)
    if kind == "perez":
        return sky.PerezSky(sun_zenith_deg=50, sun_azimuth_deg=77, epsilon=4.0, delta=0.15, grid=grid)
    if kind == "function":
        return sky.FunctionSky(lambda zenith, azimuth, nm: 1 + 2 * np.cos(zenith) + 0 * (azimuth + nm), grid=grid)
    values = np.ones((1, rings, columns))
    values[:, 1::2] = 2 if kind == "alternate" else 1
    return sky.TabulatedSky(wavelength_nm=[550.0], values=values, grid=grid)


def ratios(kind: str, rings: int, columns: int, photons: int, bands: int) -> list[float]:
    """Of columns, of sectors, of each mode."""
    scene = sky.Scene(wavebands=np.full(bands, 550.0), n_photons=photons, components=[sky_of(kind, rings, columns)])
    source = scene.source(seed=0)
    column = np.zeros((bands, columns))
    sector, mode = np.zeros((bands, N_SECTORS)), np.zeros((bands, N_MODES), complex)
    for band in range(bands):
        batch = source.photons(band)
        turn = np.exp(1j * np.arctan2(-batch.uy, -batch.ux))
        column[band] = np.bincount(batch.patch % columns, minlength=columns)
        part = np.floor(np.angle(turn) / (2 * np.pi) * N_SECTORS).astype(int) % N_SECTORS
        sector[band] = np.bincount(part, minlength=N_SECTORS)
        mode[band] = np.cumprod(np.broadcast_to(turn[:, None], (turn.size, N_MODES)), axis=1).sum(0)
    found = []
    for counts in (column, sector):
        p = counts.mean(0) / photons
        found.append(math.sqrt(counts.var(0, ddof=1).mean() / (photons * p * (1 - p)).mean()))
    mean = mode.mean(0)
    variance = (np.abs(mode - mean) ** 2).sum(0) / (bands - 1)
    return [*found, *np.sqrt(variance / (photons * (1 - np.abs(mean / photons) ** 2))).tolist()]


def grids(n: int) -> list[tuple[int, int, int]]:
    rng = np.random.default_rng(123)
    found = []
    for _ in range(n):
        rings, columns = int(rng.integers(2, 91)), int(rng.integers(3, 361))
        photons = int(np.exp(rng.uniform(np.log(30), np.log(3e4))))
        found.append((rings, columns, max(rings, photons // rings * rings) if rng.random() < 0.5 else photons))
    return found


def show(name: str, table: np.ndarray, chosen: list[tuple[int, int, int]]) -> None:
    print(f"\n{name}: ratios to independent photons, {len(table)} grids")
    print(f"{'':12s}{'median':>9s}{'99 %':>9s}{'worst':>9s}   worst grid (rings, columns, photons)")
    for k, quantity in enumerate(("columns", "sectors", *(f"mode {m + 1}" for m in range(N_MODES)))):
        values = table[:, k]
        worst = int(values.argmax())
        row = "".join(f"{x:9.2f}" for x in (np.median(values), np.quantile(values, 0.99), values[worst]))
        print(f"{quantity:12s}{row}   {chosen[worst]}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sky", choices=("equal", "alternate", "function", "perez"), default="equal")
    parser.add_argument("--grids", type=int, default=100)
    parser.add_argument("--bands", type=int, default=64)
    parser.add_argument("--before", help="the folder src of another version")
    parser.add_argument("--raw", action="store_true", help="print the ratios as JSON")
    options = parser.parse_args()
    chosen = grids(options.grids)
    table = [ratios(options.sky, *grid, options.bands) for grid in chosen]
    if options.raw:
        print(json.dumps(table))
        return
    print(f"noise of a ratio: {1 / math.sqrt(4 * options.bands):.2f} (modes), less for columns and sectors")
    if options.before:
        arguments = ["--sky", options.sky, "--grids", str(options.grids), "--bands", str(options.bands), "--raw"]
        environment = {**os.environ, "PYTHONPATH": options.before}
        before = subprocess.run(
            [sys.executable, __file__, *arguments], env=environment, capture_output=True, check=True
        )
        show("before", np.array(json.loads(before.stdout)), chosen)
    show("now", np.array(table), chosen)


if __name__ == "__main__":
    main()
