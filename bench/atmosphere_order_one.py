"""Order 1 of a spherical sky: time per direction and wavelength against error, by the nodes of a panel.

    python bench/atmosphere_order_one.py [--repeats 5] [--wavelengths 16]

One thread, CPU time, the least of the turns, all numbers of nodes turn about. Molecules, a peaked aerosol and ozone
(inputs/atmosphere/clear_marine.atmo) in 40 x 25 directions from the horizon to the zenith and from the sun to opposite
it; the error is the largest over directions and wavelengths against 24 nodes, relative to each. The table's time is
what one sun costs before its first direction. The bar: less than 0.1 ms a direction and wavelength with the default,
also for a single wavelength and a sun below the horizon.
"""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path

import numpy as np
from harness import best_cpu_time, machine, verdict

from aomc_sky.atmosphere.medium import Medium
from aomc_sky.atmosphere.order_one import N_NODES, solve_order_one
from aomc_sky.formats.atmo.reader import read_atmo
from aomc_sky.source.atmospheres.medium import read_medium

CLEAR_SKY = Path(__file__).resolve().parents[1] / "inputs" / "atmosphere" / "clear_marine.atmo"
SUNS_DEG = (40.0, 85.0, 90.0, 92.0)
NODES = (2, 3, 4, N_NODES, 8, 12)
TRUE_NODES = 24
BAR_US = 100.0


def directions() -> tuple[np.ndarray, np.ndarray]:
    zenith = np.pi / 2 * (1.0 - np.linspace(0.0, 1.0, 40) ** 2)
    azimuth = np.linspace(0.0, np.pi, 25)
    return np.repeat(zenith, azimuth.size), np.tile(azimuth, zenith.size)


def measure(medium: Medium, sun_deg: float, repeats: int) -> float:
    """Print a row for each number of nodes; return the default's time. [us a direction and wavelength]"""
    sun = np.radians(sun_deg)
    zenith, azimuth = directions()
    n = zenith.size * medium.wavelength_nm.size
    truth = solve_order_one(medium, sun, zenith, azimuth, n_nodes=TRUE_NODES)
    seen = truth > 1e-12 * truth.max()
    contenders = {}
    for nodes in NODES:
        contenders[f"{nodes}"] = partial(solve_order_one, medium, sun, zenith, azimuth, n_nodes=nodes)
        contenders[f"{nodes} table"] = partial(solve_order_one, medium, sun, zenith[:1], azimuth[:1], n_nodes=nodes)
    best = best_cpu_time(contenders, repeats)
    for nodes in NODES:
        found = solve_order_one(medium, sun, zenith, azimuth, n_nodes=nodes)
        error = np.abs(found[seen] / truth[seen] - 1.0).max()
        table = best[f"{nodes} table"]
        each = (best[f"{nodes}"] - table) / n
        name = f"{nodes} (default)" if nodes == N_NODES else f"{nodes}"
        n_wl = medium.wavelength_nm.size
        print(f"{sun_deg:7.1f}  {n_wl:4d}    {name:12s} {1e3 * table:9.1f} {1e6 * each:15.2f}   {error:.1e}")
    return 1e6 * (best[f"{N_NODES}"] - best[f"{N_NODES} table"]) / n


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--wavelengths", type=int, default=16)
    arguments = parser.parse_args()
    print(machine())
    description = read_atmo(CLEAR_SKY)
    print("    sun  n_wl    nodes        table ms  us/direction/wl   largest error")
    slowest = 0.0
    for wavelength_nm in (np.linspace(400.0, 700.0, arguments.wavelengths), np.array([550.0])):
        medium, _ = read_medium(description, wavelength_nm)
        for sun_deg in SUNS_DEG:
            slowest = max(slowest, measure(medium, sun_deg, arguments.repeats))
    print(f"slowest default, us a direction and wavelength  {verdict(slowest, BAR_US, at_least=False)}")


if __name__ == "__main__":
    main()
