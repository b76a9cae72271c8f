"""A transport loop with our sampler inside against the same loop with np.random: time, error, time to an error.

    python bench/transport.py [--photons 50000] [--repeats 101] [--replicates 64] [--sample 100000]
    python bench/transport.py --figure docs/figures/transport_error.png

All loops are compiled by numba and run on one thread; only the sampler differs. They take turns;
times are CPU times of the thread, of the best of many short turns, which a busy machine disturbs least. The
sky is Perez's clear one in 90 x 360 patches. The contenders draw a patch from the cumulative masses by
bisection, or from an alias table, and place the photon in it by numba's own np.random, as one writes it first.
Loops: the source alone; the source and the surface (Fresnel, refraction, histogram of directions); the slab
of examples/slab. Errors are spreads over independent replicates, known to about 1 in sqrt(replicates); the
time to an error counts both. No bar: the gain is what the table says.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numba
import numpy as np
from harness import best_cpu_time, machine

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples" / "slab"))

from fresnel import reflectance, refracted_mu
from philox import event_numbers, transport_key
from tally import ONE_PHOTON, REFLECTED, Tally, add_refracted, empty_tally
from transport import enter
from water import Water, water_layer

import aomc_sky as sky

N_AZIMUTH = 360
WATER = water_layer(depth_m=10, absorption_per_m=0.05, scattering_per_m=0.15, bottom_reflectance=0.05)
DEPTHS = np.array([0.0, 0.5, 1.0]) * WATER.optical_depth
LOOPS = ("source", "surface", "slab")


@dataclass(frozen=True, kw_only=True)
class Sampler:
    """A jitted ``sample(i, *tables)``, and how it is seeded."""

    sample: Any
    tables: tuple[np.ndarray, ...]
    seed: Callable[[int], None]


@numba.njit(nogil=True)
def seed_numba(seed: int) -> None:
    np.random.seed(seed)  # noqa: NPY002 - numba's own generator, of this thread


@numba.njit(nogil=True)
def place(patch: int, mu2: np.ndarray, growth: np.ndarray) -> tuple[float, float, float]:
    """A direction in a patch, as one writes it first."""
    ring, column = patch // N_AZIMUTH, patch % N_AZIMUTH
    square = mu2[ring] + growth[ring] * np.random.random()  # noqa: NPY002
    azimuth = (column + np.random.random()) * (2 * np.pi / N_AZIMUTH)  # noqa: NPY002
    sine = np.sqrt(1 - square)
    return -sine * np.cos(azimuth), -sine * np.sin(azimuth), -np.sqrt(square)


@numba.njit(nogil=True)
def by_bisection(i: int, cumulative: np.ndarray, mu2: np.ndarray, growth: np.ndarray) -> tuple[float, float, float]:
    patch = np.searchsorted(cumulative, np.random.random(), side="right")  # noqa: NPY002
    return place(min(patch, cumulative.size - 1), mu2, growth)


@numba.njit(nogil=True)
def by_alias(
    i: int, share: np.ndarray, other: np.ndarray, mu2: np.ndarray, growth: np.ndarray
) -> tuple[float, float, float]:
    patch = int(np.random.random() * share.size)  # noqa: NPY002
    if np.random.random() >= share[patch]:  # noqa: NPY002
        patch = other[patch]
    return place(patch, mu2, growth)


def alias_table(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vose's table."""
    share, other = p * p.size, np.arange(p.size)
    small = list(np.flatnonzero(share < 1))
    large = list(np.flatnonzero(share >= 1))
    while small and large:
        low, high = small.pop(), large[-1]
        other[low] = high
        share[high] -= 1 - share[low]
        if share[high] < 1:
            small.append(large.pop())
    share[small + large] = 1
    return share, other


@numba.njit(nogil=True)
def source_loop(sample: Any, tables: Any, n: int) -> float:
    total = 0.0
    for i in range(n):
        ux, uy, uz = sample(i, *tables)
        total += ux + uy + uz
    return total


@numba.njit(nogil=True)
def surface_loop(sample: Any, tables: Any, n: int, water: Water, tally: Tally) -> None:
    for i in range(n):
        ux, uy, uz = sample(i, *tables)
        mu = refracted_mu(-uz, water.refractive_index)
        turned_back = int(ONE_PHOTON * reflectance(-uz, mu, water.refractive_index) + 0.5)
        tally.fate[REFLECTED] += turned_back
        add_refracted(tally.refracted, ux, uy, mu, water.refractive_index, ONE_PHOTON - turned_back)


@numba.njit(nogil=True)
def slab_loop(sample: Any, tables: Any, n: int, water: Water, key: np.uint64, depths: np.ndarray, tally: Tally) -> None:
    for i in range(n):
        ux, uy, uz = sample(i, *tables)
        first = event_numbers(key, i, 0)
        enter(i, np.float64(ux), np.float64(uy), np.float64(uz), water, key, depths, tally, first)


def run(loop: str, sampler: Sampler, n: int, seed: int = 1) -> Tally:
    """One loop from its own seeds."""
    tally = empty_tally(DEPTHS.size)
    sampler.seed(seed)
    if loop == "source":
        source_loop(sampler.sample, sampler.tables, n)
    elif loop == "surface":
        surface_loop(sampler.sample, sampler.tables, n, WATER, tally)
    else:
        slab_loop(sampler.sample, sampler.tables, n, WATER, transport_key(seed), DEPTHS, tally)
    return tally


def contenders(grid: sky.PatchGrid, p: np.ndarray) -> dict[str, Sampler]:
    """Samplers that are seeded at run time."""
    near, far = grid.ring_mu()
    rings = (far**2, near**2 - far**2)
    cumulative = np.cumsum(p)
    return {
        "np.random, bisection": Sampler(
            sample=by_bisection, tables=(cumulative / cumulative[-1], *rings), seed=seed_numba
        ),
        "np.random, alias": Sampler(sample=by_alias, tables=(*alias_table(p), *rings), seed=seed_numba),
    }


def ours(scene: sky.Scene, seed: int, **options: str) -> Sampler:
    """Our sampler; its seed is settled with its source."""
    sample = scene.source(seed, **options).numba_sampler(0).sample
    return Sampler(sample=sample, tables=(), seed=lambda seed: None)


def quantities(tally: Tally, n: int) -> dict[str, np.ndarray]:
    """What the errors are told of."""
    one = float(n) * ONE_PHOTON
    return {
        "transmitted irradiance": 1 - tally.fate[REFLECTED] / one,
        "refracted directions, 288 cells": tally.refracted / one,
        "Ed in 5 m": tally.down[1] / one,
        "Ed in 10 m": tally.down[2] / one,
        "light leaving the water": tally.fate[1] / one,
    }


def relative_errors(tallies: list[Tally], n: int) -> dict[str, float]:
    """Relative standard deviation of each quantity over replicates; of many cells, the root mean square."""
    told = [quantities(tally, n) for tally in tallies]
    errors = {}
    for name in told[0]:
        values = np.array([one[name] for one in told])
        relative = values.std(axis=0, ddof=1) / values.mean(axis=0)
        errors[name] = float(np.sqrt(np.mean(relative**2)))
    return errors


def print_times(times: dict[str, dict[str, float]], n: int) -> None:
    first = next(iter(times["source"]))
    print(f"\nns per photon, best turns of {n} photons    source    surface       slab   source's share of the slab")
    for name in times["source"]:
        each = [times[loop][name] / n * 1e9 for loop in LOOPS]
        print(f"{name:<38}" + "".join(f"{value:11.1f}" for value in each) + f"{each[0] / each[2]:15.1%}")
    for name in list(times["source"])[1:]:
        ratios = [times[loop][name] / times[loop][first] for loop in LOOPS]
        print(f"{name + ' / ours':<38}" + "".join(f"{value:11.2f}" for value in ratios))


def print_errors(mine: dict[str, float], other: dict[str, float], slower: dict[str, float], n: int) -> None:
    print(f"\nrelative error of {n} photons            ours   np.random    ratio   time to one error, np.random / ours")
    for name, error in mine.items():
        gain = other[name] / error
        loop = "surface" if name in ("transmitted irradiance", "refracted directions, 288 cells") else "slab"
        print(f"{name:<34}{error:11.1e}{other[name]:12.1e}{gain:9.1f}{gain**2 * slower[loop]:14.1f} ({loop} loop)")


def replicated(scene: sky.Scene, peer: Sampler, replicates: int) -> tuple[list[Tally], list[Tally]]:
    """The slab, several times, with our photons and with a contender's."""
    n = int(scene.n_photons[0])
    seeds = range(1, replicates + 1)
    mine = [run("slab", ours(scene, seed, precision="float64"), n, seed) for seed in seeds]
    return mine, [run("slab", peer, n, seed) for seed in seeds]


def draw(path: Path, components: tuple[sky.component.Component, ...], peer: Sampler, replicates: int) -> None:
    """Relative error against photons, log-log, a panel for each of three quantities."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    photons = [1_000, 4_000, 16_000, 64_000, 256_000]
    bands = sky.Wavebands(wavelength_nm=np.array([500.0]))
    errors = []
    for n in photons:
        scene = sky.Scene(wavebands=bands, n_photons=n, components=components)
        errors.append([relative_errors(tallies, n) for tallies in replicated(scene, peer, replicates)])
    names = list(errors[0][0])[:3]
    figure, panels = plt.subplots(1, len(names), figsize=(9.6, 3.4), layout="constrained", sharey=True)
    for panel, name in zip(panels, names, strict=True):
        for k, (label, color) in enumerate((("aomc-sky", "#0072b2"), ("np.random", "#d55e00"))):
            told = [error[k][name] for error in errors]
            panel.loglog(photons, told, "os"[k] + "-", label=label, color=color)
        panel.set(title=name, xlabel="photons")
        panel.grid(which="major", alpha=0.3)
    panels[0].set_ylabel("relative standard deviation")
    panels[0].legend()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--photons", type=int, default=50_000, help="of the timed loops")
    parser.add_argument("--repeats", type=int, default=101)
    parser.add_argument("--replicates", type=int, default=64, help="of the errors")
    parser.add_argument("--sample", type=int, default=100_000, help="photons of a replicate")
    parser.add_argument("--figure", type=Path, help="draw error against photons into this file, and nothing else")
    options = parser.parse_args()

    grid = sky.PatchGrid.regular(90, N_AZIMUTH)
    clear = sky.PerezSky(sun_zenith_rad=0.7, epsilon=6.3, delta=0.12, grid=grid, within="uniform")
    components = clear.lower([500.0])
    p = components[0].mass[0] / components[0].mass[0].sum()
    bands = sky.Wavebands(wavelength_nm=np.array([500.0]))
    timed = sky.Scene(wavebands=bands, n_photons=options.photons, components=components)
    samplers = {"ours": ours(timed, 1, precision="float64"), **contenders(grid, p)}
    peer = "np.random, alias"
    if options.figure:
        draw(options.figure, components, samplers[peer], options.replicates)
        return
    print(machine())
    times = {}
    for loop in LOOPS:
        works = {name: partial(run, loop, sampler, options.photons) for name, sampler in samplers.items()}
        times[loop] = best_cpu_time(works, options.repeats)
    print_times(times, options.photons)

    small = sky.Scene(wavebands=bands, n_photons=options.sample, components=components)
    mine, other = replicated(small, samplers[peer], options.replicates)
    for name, one, two in zip(quantities(mine[0], 1), means(mine), means(other), strict=True):
        assert np.allclose(one, two, rtol=0.2), name  # the loops do the same physics
    slower = {loop: times[loop][peer] / times[loop]["ours"] for loop in LOOPS}
    print_errors(relative_errors(mine, options.sample), relative_errors(other, options.sample), slower, options.sample)


def means(tallies: list[Tally]) -> list[np.ndarray]:
    """Mean of each quantity over replicates."""
    told = [quantities(tally, 1) for tally in tallies]
    return [np.mean([one[name] for one in told], axis=0) for name in told[0]]


if __name__ == "__main__":
    main()
