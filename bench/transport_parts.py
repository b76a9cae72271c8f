"""What a photon's life in examples/slab costs, part by part.

    python bench/transport_parts.py [--photons 30000] [--repeats 101]

One thread, its CPU time; the parts take turns, and the best turn of each counts. A part is timed in a loop
of its own, on numbers like those it gets, so the parts need not add up: inside the slab they wait for each
other, and branches are not foretold.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
from harness import best_cpu_time, machine

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples" / "slab"))

from fresnel import reflectance, refracted_mu
from philox import event_numbers, transport_key
from scattering import sample_henyey_greenstein, turned
from tally import ONE_PHOTON, empty_tally
from transport import follow, trace
from water import Water, water_layer

import aomc_sky as sky

WATER = water_layer(depth_m=10, absorption_per_m=0.05, scattering_per_m=0.15, bottom_reflectance=0.05)
KEY = transport_key(1)
GOLDEN = 0.6180339887498949


@numba.njit(nogil=True)
def numbers(n: int, key: np.uint64) -> float:
    total = 0.0
    for i in range(n):
        a, b, c, d = event_numbers(key, i, 0)
        total += a + b + c + d
    return total


@numba.njit(nogil=True)
def paths(n: int) -> float:
    total = 0.0
    for i in range(n):
        total += math.log((i + 0.5) / n)
    return total


@numba.njit(nogil=True)
def cosines(n: int, g: float) -> float:
    total = 0.0
    for i in range(n):
        total += sample_henyey_greenstein(g, (i * GOLDEN) % 1.0)
    return total


@numba.njit(nogil=True)
def turns(n: int) -> float:
    x, y, z = 0.6, 0.0, -0.8
    for i in range(n):
        x, y, z = turned(x, y, z, 0.9, (i * GOLDEN) % 1.0)
    return x


@numba.njit(nogil=True)
def surfaces(n: int, index: float) -> float:
    total = 0.0
    for i in range(n):
        mu = (i + 0.5) / n
        total += reflectance(mu, refracted_mu(mu, index), index)
    return total


@numba.njit(nogil=True)
def directions(sample: Any, n: int) -> float:
    total = 0.0
    for i in range(n):
        ux, uy, uz = sample(i)
        total += ux + uy + uz
    return total


@numba.njit(nogil=True)
def lives(n: int, water: Water, key: np.uint64, depths: np.ndarray, tally: Any) -> None:
    """From below the surface to the end, all on one refracted path."""
    for i in range(n):
        follow(i, 0.36, 0.0, -0.9329523031752481, ONE_PHOTON, water, key, depths, tally)


def parts(n: int) -> dict[str, Callable[[], object]]:
    """Everything that is timed, n times each."""
    scene = sky.read_scene(Path(__file__).resolve().parents[1] / "inputs" / "clear_day", iterations=n, wavebands=[1])
    sample = scene.source(1, precision="float64").numba_sampler(0).sample
    depths = np.array([0.0, 0.5, 1.0]) * WATER.optical_depth
    tally = empty_tally(depths.size)
    return {
        "the whole photon": lambda: trace(sample, 0, n, WATER, KEY, depths, tally),
        "its source": lambda: directions(sample, n),
        "its life below the surface": lambda: lives(n, WATER, KEY, depths, tally),
        "  the same, no depths counted": lambda: lives(n, WATER, KEY, depths[:0], tally),
        "four random numbers (once per event)": lambda: numbers(n, KEY),
        "logarithm of a free path (once per event)": lambda: paths(n),
        "scattering cosine": lambda: cosines(n, WATER.asymmetry),
        "turn of the direction": lambda: turns(n),
        "Snell and Fresnel": lambda: surfaces(n, WATER.refractive_index),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--photons", type=int, default=30_000)
    parser.add_argument("--repeats", type=int, default=101)
    options = parser.parse_args()
    print(machine())
    times = best_cpu_time(parts(options.photons), options.repeats)
    print("\nns, best of the turns")
    for name, taken in times.items():
        print(f"{name:<44}{taken / options.photons * 1e9:10.1f}")


if __name__ == "__main__":
    main()
