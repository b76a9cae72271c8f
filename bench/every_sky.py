"""One run of transport for many skies, by weights of its photons, beside a run of its own for each sky.

    python bench/every_sky.py [--skies 50] [--photons 100000] [--seeds 16]

Skies are Perez skies of random suns, clearness and brightness, and overcast and clear ones. The run launches the mean
of them all. Tallies of a slab of water (optical depth 2, Henyey-Greenstein g = 0.92, albedo 0.9): what leaves upwards,
what leaves downwards within 45 degrees of the vertical, and what leaves downwards towards +x. Printed are the
difference of both ways over many seeds, in standard errors and in per cent, the variance of a weighted run over that of
a run of its own, and the time of both ways. A difference of more than 6 standard errors ends the program.
"""

from __future__ import annotations

import argparse
import math
import time
import warnings

import numba
import numpy as np
from harness import machine
from slab import left, seeded

import aomc_sky as sky


@numba.njit(nogil=True)
def tallies(directions: np.ndarray, seed: int) -> np.ndarray:
    """Of each photon: upwards, downwards near the vertical, downwards towards +x; (n, 3)."""
    seeded(seed)
    found = np.zeros((directions.shape[1], 3))
    for i in range(directions.shape[1]):
        side, ux, uz = left(directions[0, i], directions[1, i], directions[2, i])
        if side == 1:
            found[i, 0] = 1.0
        elif side == -1:
            found[i, 1] = 1.0 if -uz > math.sqrt(0.5) else 0.0
            found[i, 2] = 1.0 if ux > 0.0 else 0.0
    return found


def directions_of(batch: sky.PhotonBatch) -> np.ndarray:
    """Travel directions, (3, n)."""
    return np.stack([batch.ux, batch.uy, batch.uz]).astype(np.float64)


def skies_of(n_skies: int, n_photons: int) -> list[sky.Scene]:
    """Scenes of skies without beams."""
    random = np.random.default_rng(1)
    scenes = []
    for k in range(n_skies):
        sun = {"sun_zenith_deg": float(random.uniform(10, 75)), "sun_azimuth_deg": float(random.uniform(0, 360))}
        kind = {0: sky.OvercastSky(), 1: sky.HarrisonCoombesSky(**sun)}.get(k % 10)
        model = kind or sky.PerezSky(**sun, epsilon=float(random.uniform(1, 8)), delta=float(random.uniform(0.08, 0.4)))
        scenes.append(sky.Scene(wavebands=[550.0], n_photons=n_photons, components=model))
    return scenes


def mean_of(scenes: list[sky.Scene], n_photons: int) -> sky.Scene:
    """The scene of the mean of skies."""

    def radiance(zenith: np.ndarray, azimuth: np.ndarray, wavelength_nm: np.ndarray) -> np.ndarray:
        return np.mean([scene.radiance(0, *np.broadcast_arrays(zenith, azimuth)) for scene in scenes], axis=0)

    return sky.Scene(wavebands=[550.0], n_photons=n_photons, components=sky.FunctionSky(radiance, name="mean"))


def main() -> None:
    """Print both ways."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--skies", type=int, default=50)
    parser.add_argument("--photons", type=int, default=100_000)
    parser.add_argument("--seeds", type=int, default=16)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", sky.ModelLimitWarning)
    scenes = skies_of(arguments.skies, arguments.photons)
    mean = mean_of(scenes, arguments.photons)
    tallies(np.array([[0.0], [0.0], [-1.0]]), 0)
    own, one = (np.zeros((arguments.seeds, arguments.skies, 3)) for _ in range(2))
    seconds = np.zeros(2)
    for seed in range(arguments.seeds):
        began = time.process_time()
        for k, scene in enumerate(scenes):
            batch = scene.source(seed).photons()
            own[seed, k] = tallies(directions_of(batch), 1000 * seed + k).mean(axis=0)
        middle = time.process_time()
        source = mean.source(10_000 + seed)
        batch = source.photons()
        found = tallies(directions_of(batch), 10**6 + seed)
        for k, scene in enumerate(scenes):
            one[seed, k] = source.weights_for(scene, batch) @ found / len(batch)
        seconds += middle - began, time.process_time() - middle
    error = np.sqrt((own.var(axis=0, ddof=1) + one.var(axis=0, ddof=1)) / arguments.seeds)
    difference = one.mean(axis=0) - own.mean(axis=0)
    print(f"{machine()}; {arguments.skies} skies, {arguments.seeds} runs of {arguments.photons} photons each")
    for k, name in enumerate(("upwards", "downwards, near the vertical", "downwards, towards +x")):
        z, part = difference[:, k] / error[:, k], difference[:, k] / own.mean(axis=0)[:, k]
        ratio = one[:, :, k].var(axis=0, ddof=1) / own[:, :, k].var(axis=0, ddof=1)
        print(
            f"{name:30s} worst {np.abs(z).max():.1f} standard errors, rms {np.sqrt(np.mean(z * z)):.2f}; rms "
            "difference "
            f"{np.sqrt(np.mean(part**2)):.2%}; variance {np.median(ratio):.2f} (median) of a run of its own"
        )
        if np.abs(z).max() > 6.0:
            raise SystemExit("the weighted run is wrong")
    print(f"processor time: a run for each sky {seconds[0]:.1f} s, one run and weights {seconds[1]:.1f} s")


if __name__ == "__main__":
    main()
