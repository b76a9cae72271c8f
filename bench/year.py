"""A year of skies from a weather file: hours per second, on one core.

    python bench/year.py [--days 365] [--iterations 1e6] [--bins 45 180] [--repeats 3]

Invented weather at 50 degrees north, sun by a short formula, so that neither a weather file nor pvlib is needed. What
is timed is `aomc_sky.engine.year.run_year` from the plan to the manifest: model, masses, counts, files on the disk.
The first hours are made once beforehand, so that no compiler is timed.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from pathlib import Path
from statistics import median

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from aomc_sky.engine.year import run_year
from aomc_sky.sampling.streams import STREAM_VERSION
from aomc_sky.source.year import SCHEMA, HourState, YearPlan
from bench.harness import machine, seconds, verdict

LATITUDE_DEG = 50.0
BAR = 80.0


def invented(days: int, iterations: int, bins: list[int]) -> YearPlan:
    """Hours from clear to overcast, from sunrise to sunset, through the seasons."""
    rows = np.arange(24 * days)
    declination = np.deg2rad(-23.44) * np.cos(2 * np.pi * (rows / 24 + 10) / 365.25)
    angle = np.deg2rad(15.0 * (rows % 24 + 0.5 - 12.0))
    latitude = np.deg2rad(LATITUDE_DEG)
    mu = np.sin(latitude) * np.sin(declination) + np.cos(latitude) * np.cos(declination) * np.cos(angle)
    lit = np.maximum(mu, 0.0)
    cloud = np.random.default_rng(1).random(rows.size)
    arrays = {
        "line": rows + 9,
        "start_s": 3600 * rows,
        "sun_zenith_deg": np.rad2deg(np.arccos(mu)),
        "sun_azimuth_deg": np.mod(270.0 - np.rad2deg(angle), 360.0),
        "extraterrestrial_normal": np.full(rows.size, 1361.1),
        "dni": np.where(cloud > 0.5, 900.0 * cloud * lit**0.3, 0.0),
        "dhi": np.where(mu > 0, (60.0 + 400.0 * np.minimum(cloud, 1 - cloud)) * lit**0.7, 0.0),
        "state": np.where(mu > 0, HourState.SKY, HourState.NIGHT).astype(np.int8),
    }
    options = {
        "schema": SCHEMA,
        "stream": STREAM_VERSION,
        "seed": 1,
        "iterations": iterations,
        "bins": bins,
        "limits": "radiance",
        "air_mass": "kasten-young-1989",
        "with_beam": False,
        "site": [LATITUDE_DEG, 0.0, 0.0],
    }
    return YearPlan(arrays=arrays, options=options)


def rate(plan: YearPlan) -> float:
    """Hours with a sky per second of one whole run."""
    folder = Path(tempfile.mkdtemp())
    try:
        return plan.sky_rows.size / seconds(lambda: run_year(plan, folder))
    finally:
        shutil.rmtree(folder)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--days", type=int, default=365)
    parser.add_argument("--iterations", type=float, default=1e6)
    parser.add_argument("--bins", type=int, nargs=2, default=[45, 180])
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    print(machine())
    rate(invented(1, int(options.iterations), options.bins))
    plan = invented(options.days, int(options.iterations), options.bins)
    rates = [rate(plan) for _ in range(options.repeats)]
    n_zenith, n_azimuth = options.bins
    print(f"{plan.sky_rows.size} skies on {n_zenith} x {n_azimuth} patches, median of {options.repeats}")
    print(f"{'skies per second, one core':28s} {verdict(median(rates), BAR, at_least=True)}")


if __name__ == "__main__":
    main()
