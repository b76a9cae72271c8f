"""How often `aomc-sky verify --scene` finds a planted defect, by kind, share and number of photons.

python bench/verify_power.py [--seeds 20] [--scenes clear_day:1 overcast:1] [--photons 1e4 1e5 1e6] [--defects Lambert]

Photons of one waveband are drawn independently, or by a plan that the tests do not know, and spoilt; a report at the
family level of 1e-6 that fails counts as found. The numbers of docs/verify.md come from here.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import aomc_sky as sky
from aomc_sky.verify.directions import PhotonRows, Tied, verify_directions

INPUTS = Path(__file__).parents[1] / "inputs"
LEVEL = 1e-6
BLOCK = 65_536


def replaced(directions: np.ndarray, share: float, rng: np.random.Generator, zenith: Callable) -> np.ndarray:
    """Some photons replaced by others of this law of the zenith angle, uniform in azimuth."""
    spoilt = directions.copy()
    chosen = np.flatnonzero(rng.random(len(spoilt)) < share)
    theta, phi = zenith(rng.random(chosen.size)), 2 * np.pi * rng.random(chosen.size)
    spoilt[chosen] = -np.column_stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    return spoilt


def uniform_in_zenith_angle(directions: np.ndarray, share: float, rng: np.random.Generator) -> np.ndarray:
    """Neither sine nor cosine."""
    return replaced(directions, share, rng, lambda u: u * np.pi / 2)


def lambert(directions: np.ndarray, share: float, rng: np.random.Generator) -> np.ndarray:
    """The same radiance from everywhere."""
    return replaced(directions, share, rng, lambda u: np.arcsin(np.sqrt(u)))


def tilted(directions: np.ndarray, degrees: float, rng: np.random.Generator) -> np.ndarray:
    """All turned about a horizontal axis; what would come from below the horizon stays as it was."""
    angle, axis = math.radians(degrees), 2 * np.pi * rng.random()
    along = np.array([math.cos(axis), math.sin(axis), 0.0])
    turned = (
        directions * math.cos(angle)
        + np.cross(along, directions) * math.sin(angle)
        + np.outer(directions @ along, along) * (1 - math.cos(angle))
    )
    return np.where(turned[:, 2:] < 0, turned, directions).astype(directions.dtype)


def copied(directions: np.ndarray, share: float, rng: np.random.Generator) -> np.ndarray:
    """Photons in the place of which another one stands a second time."""
    spoilt = directions.copy()
    chosen = np.flatnonzero(rng.random(len(spoilt)) < share)
    spoilt[chosen] = directions[rng.integers(len(directions), size=chosen.size)]
    return spoilt


DEFECTS: dict[str, tuple[Callable[[np.ndarray, float, np.random.Generator], np.ndarray], tuple[float, ...], str]] = {
    "none": (lambda d, size, rng: d, (0.0,), ""),
    "uniform in zenith angle": (uniform_in_zenith_angle, (0.01, 0.1), "%"),
    "Lambert": (lambert, (0.01, 0.03, 0.1), "%"),
    "tilt": (tilted, (0.1, 1.0), "deg"),
    "photons copied": (copied, (1e-4, 1e-3, 0.01), "%"),
}


def report_of(source: sky.PhotonSource, tied: Tied, directions: np.ndarray, band: int, seed: int) -> bool:
    """Whether the photons pass."""
    starts = range(0, len(directions), BLOCK)
    blocks = (PhotonRows(start=s, direction=directions[s : s + BLOCK]) for s in starts)
    return verify_directions(source, {band: blocks}, tied=tied, family_level=LEVEL, seed=seed).passed


def found(name: str, band: int, n: int, tied: Tied, seeds: int, only: list[str]) -> dict[tuple[str, float], int]:
    """How many spoilt sets are found, by defect and size."""
    scene = sky.read_scene(INPUTS / name / "amc.inp", iterations=n, wavebands=[band + 1])
    counts: dict[tuple[str, float], int] = {}
    for seed in range(seeds):
        source = scene.source(seed, method="iid" if tied is Tied.INDEPENDENT else None)
        directions = source.photons(band).directions
        for defect, (spoil, sizes, _) in DEFECTS.items():
            for size in sizes if not only or defect in only else ():
                spoilt = spoil(directions, size, np.random.default_rng([seed, int(size * 1e6)]))
                key = defect, size
                counts[key] = counts.get(key, 0) + (not report_of(source, tied, spoilt, band, seed))
    return counts


def shown(size: float, unit: str) -> str:
    """A size with its unit."""
    return f"{100 * size:g} %" if unit == "%" else f"{size:g} {unit}".strip()


def main() -> None:
    """Print one table for each scene and waveband."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--scenes", nargs="+", default=["clear_day:1", "clear_day:3", "overcast:1", "perez_sky:1"])
    parser.add_argument("--photons", nargs="+", type=float, default=[1e4, 1e5, 1e6])
    parser.add_argument("--defects", nargs="+", default=[], choices=list(DEFECTS), help="only these")
    arguments = parser.parse_args()
    numbers = [int(n) for n in arguments.photons]
    for entry in arguments.scenes:
        name, _, waveband = entry.partition(":")
        begin = time.perf_counter()
        columns = {
            (tied, n): found(name, int(waveband or 1) - 1, n, tied, arguments.seeds, arguments.defects)
            for tied in (Tied.INDEPENDENT, Tied.STRATIFIED)
            for n in numbers
        }
        print(f"\n`{name}`, waveband {waveband or 1}: found of {arguments.seeds} seeds\n")
        print("| defect | size | " + " | ".join(f"{tied.value}, {n:.0e}" for tied, n in columns) + " |")
        print("| --- | --- |" + " --- |" * len(columns))
        for key in next(iter(columns.values())):
            size = shown(key[1], DEFECTS[key[0]][2]) if key[0] != "none" else ""
            print(f"| {key[0]} | {size} | " + " | ".join(str(of[key]) for of in columns.values()) + " |")
        print(f"\n{time.perf_counter() - begin:.0f} s")


if __name__ == "__main__":
    main()
