"""What numbers that go with the photons are worth in water: variance of independent photons over that of ours.

    python bench/even_numbers.py [--photons 100000] [--replicates 200] [--modes]

The light of inputs/clear_day falls through a flat surface into three waters (Petzold's, in Mobley 1994; Henyey
and Greenstein with g = 0.9; refractive index 1.34; black below 15 m). At each collision a photon's weight is
multiplied with the albedo of single scattering. Counted are the irradiances Ed and Eu, and the radiances within 20
degrees of the vertical, Ld downwards and Lu upwards, at 0 (just below the surface), 1, 5 and 10 m.
All choices are random (Philox) but the first ones: with one number the first free path comes from the photon, with two
the first scattering angle too, with three the azimuth of that scattering. Each replicate is a seed of its own.

A factor is the variance of the mean of N independent photons, which is that of one photon over N, divided by the
variance of the mean over the replicates. Its relative standard error is the root of 2 / (replicates - 1).
With --modes the table of `number_modes.py` comes first: the worst mode of directions and numbers on six grids.
"""

from __future__ import annotations

import argparse
import math
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numba
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples" / "slab"))

import number_modes
from fresnel import reflectance, refracted_mu
from philox import event_numbers, transport_key
from scattering import sample_henyey_greenstein, turned

import aomc_sky as sky

CLEAR_DAY = Path(__file__).resolve().parents[1] / "inputs" / "clear_day"
WATERS = {"clear": (0.114, 0.037), "coastal": (0.179, 0.219), "harbour": (0.366, 1.824)}
"""Absorption and scattering. [1/m]"""
DEPTHS_M = (0.0, 1.0, 5.0, 10.0)
BLACK_M = 15.0
NAMES = ("Ed", "Eu", "Ld", "Lu")
INDEX, ASYMMETRY, CONE = 1.34, 0.9, math.cos(math.radians(20.0))
_SMALL, _CHANCE = 1e-3, 0.1


@numba.njit(nogil=True)
def count(score: np.ndarray, level: int, uz: float, weight: float) -> None:
    """Add a crossing of a level to irradiance and, near the vertical, to radiance (but for the solid angle)."""
    k = 0 if uz < 0.0 else 1
    score[k, level] += weight
    if abs(uz) > CONE:
        score[2 + k, level] += weight / abs(uz)


@numba.njit(nogil=True)
def follow(
    i: int,
    direction: np.ndarray,
    numbers: np.ndarray,
    key: np.uint64,
    depths: np.ndarray,
    black: float,
    albedo: float,
    score: np.ndarray,
) -> None:
    """A photon's life below the surface; `numbers` holds its own choices, of which there may be none."""
    mu = refracted_mu(-direction[2], INDEX)
    weight = 1.0 - reflectance(-direction[2], mu, INDEX)
    ux, uy, uz = direction[0] / INDEX, direction[1] / INDEX, -mu
    z, level, event = 0.0, 0, 0
    while True:
        path, chance, polar, plane = event_numbers(key, i, event)
        if event == 0:
            path = 1.0 - numbers[0] if numbers.size > 0 else path  # in (0, 1]: its logarithm is finite
            polar = numbers[1] if numbers.size > 1 else polar
            plane = numbers[2] if numbers.size > 2 else plane
        event += 1
        z += math.log(path) * uz
        while level < depths.size and depths[level] <= z:
            count(score, level, uz, weight)
            level += 1
        while level > 0 and depths[level - 1] > z:
            level -= 1
            count(score, level, uz, weight)
        if z >= black:
            return
        if z < 0.0:
            z = 0.0
            weight *= reflectance(uz, refracted_mu(uz, 1.0 / INDEX), 1.0 / INDEX)
            uz = -uz
        else:
            weight *= albedo
            ux, uy, uz = turned(ux, uy, uz, sample_henyey_greenstein(ASYMMETRY, polar), plane)
        if weight < _SMALL:
            if chance >= _CHANCE:
                return
            weight /= _CHANCE


@numba.njit(nogil=True)
def simulate(
    directions: np.ndarray,
    numbers: np.ndarray,
    key: np.uint64,
    depths: np.ndarray,
    black: float,
    albedo: float,
    total: np.ndarray,
    squares: np.ndarray,
) -> None:
    """Add the scores of all photons, and their squares."""
    for i in range(directions.shape[0]):
        score = np.zeros(total.shape)
        follow(i, directions[i], numbers[i], key, depths, black, albedo, score)
        total += score
        squares += score * score


def factors(n: int, replicates: int, water: tuple[float, float], threads: int) -> np.ndarray:
    """Factor of each quantity and depth for 0 to 3 numbers, (4, quantities, depths); nan where no light comes."""
    scene = sky.read_scene(CLEAR_DAY, iterations=n, wavebands=[1])
    attenuation = sum(water)
    depths, medium = attenuation * np.array(DEPTHS_M), (attenuation * BLACK_M, water[1] / attenuation)

    def replicate(seed: int) -> np.ndarray:
        batch = scene.source(seed, precision="float64").photons(numbers=3)
        directions, numbers = batch.directions, np.ascontiguousarray(batch.numbers)
        scores = np.zeros((4, 2, len(NAMES), depths.size))
        for k in range(4):
            simulate(directions, numbers[:, :k], transport_key(seed), depths, *medium, scores[k, 0], scores[k, 1])
        return scores / n

    with ThreadPoolExecutor(threads) as pool:
        found = np.array(list(pool.map(replicate, range(1, replicates + 1))))
    mean, squares = found[:, :, 0].mean(axis=0), found[:, :, 1].mean(axis=0)
    spread = np.abs(mean - mean[0]) / (found[:, :, 0].std(axis=0).max(axis=0) / math.sqrt(replicates) + 1e-300)
    assert spread.max() < 6, spread  # the same light for any number of numbers
    with np.errstate(divide="ignore", invalid="ignore"):
        return (squares - mean**2).mean(axis=0) / n / found[:, :, 0].var(axis=0, ddof=1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--photons", type=int, default=100_000, help="of a replicate")
    parser.add_argument("--replicates", type=int, default=200)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--modes", action="store_true")
    options = parser.parse_args()
    if options.modes:
        for line in number_modes.rows(number_modes.GRIDS, number_modes.PHOTONS, number_modes.WORK):
            print(line, flush=True)
    error = math.sqrt(2 / (options.replicates - 1))
    print(f"{options.photons} photons, {options.replicates} replicates: factors are known to {error:.0%}")
    print("water    numbers" + "".join(f"  {name:>4} at" + "".join(f"{d:5g}" for d in DEPTHS_M) for name in NAMES))
    for name, water in WATERS.items():
        table = factors(options.photons, options.replicates, water, options.threads)
        for k, row in enumerate(table):
            print(f"{name:<9}{k:7}" + "".join(" " * 9 + "".join(f"{f:5.1f}" for f in part) for part in row), flush=True)


if __name__ == "__main__":
    main()
