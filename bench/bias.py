"""The variance of tallies in a slab of water when photons are shared out otherwise than light.

    python bench/bias.py [--runs 300] [--photons 4000]

A slab of optical depth 2 with Henyey-Greenstein scattering (g = 0.92, single scattering albedo 0.9) and no surface,
below a sun at 40 degrees and its sky. Each ratio is the variance over the runs with a bias, over that without one, at
equal photons; it is known to about sqrt(4 / runs). A mean that moves by more than its error ends the program.
"""

from __future__ import annotations

import argparse
import math

import numba
import numpy as np
from harness import machine
from slab import left, seeded

import aomc_sky as sky

TALLIES = ("up, sky alone", "down, sky alone", "up, sun alone", "up, all light")


@numba.njit(nogil=True)
def tallies(directions: np.ndarray, weight: np.ndarray, is_sky: np.ndarray, seed: int) -> np.ndarray:
    """Weights that leave upwards and downwards: of the sky, of the sky, of the sun, of all."""
    seeded(seed)
    found = np.zeros(4)
    for i in range(weight.size):
        side, _, _ = left(directions[0, i], directions[1, i], directions[2, i])
        if side == 1:
            found[0 if is_sky[i] else 2] += weight[i]
            found[3] += weight[i]
        elif side == -1 and is_sky[i]:
            found[1] += weight[i]
    return found / weight.size


def runs_of(scene: sky.Scene, n_runs: int, bias: dict[str, float], importance: object) -> np.ndarray:
    """The tallies of independent runs, (n_runs, 4)."""
    found = []
    for seed in range(n_runs):
        source = scene.source(seed, bias=bias, importance=importance)
        batch = source.photons()
        weight = np.ones(len(batch), np.float32) if batch.weight is None else batch.weight
        directions = np.stack([batch.ux, batch.uy, batch.uz]).astype(np.float64)
        found.append(tallies(directions, weight, source.component_of(batch.patch) == 1, seed))
    return np.array(found)


def scene_of(share_of_sky: float, n_photons: int) -> sky.Scene:
    """The sun, and a sky with this share of the light."""
    beam = sky.DirectBeam(sun_zenith_deg=40.0, strength=1.0 - share_of_sky)
    diffuse = sky.PerezSky(sun_zenith_deg=40.0, epsilon=6.0, delta=0.1, strength=share_of_sky)
    return sky.Scene(wavebands=[550.0], n_photons=n_photons, components=[beam, diffuse])


def aureole(zenith: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """Ten times as many photons per light within 20 degrees of the sun."""
    sun = math.radians(40.0)
    cosine = np.cos(zenith) * math.cos(sun) + np.sin(zenith) * math.sin(sun) * np.cos(azimuth)
    return np.where(cosine > math.cos(math.radians(20.0)), 10.0, 1.0)


CASES = (
    ("sky has 0.1 of the light, 0.5 of the photons", 0.1, {"perez": 0.5}, None),
    ("sky has 0.1 of the light, 0.8 of the photons", 0.1, {"perez": 0.8}, None),
    ("sky has 0.02 of the light, 0.8 of the photons", 0.02, {"perez": 0.8}, None),
    ("sky has 0.5 of the light, importance 10 of the aureole", 0.5, None, {"perez": aureole}),
)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=300)
    parser.add_argument("--photons", type=int, default=4000)
    arguments = parser.parse_args()
    print(
        f"{machine()}; variance with the bias over that without, {arguments.runs} runs of {arguments.photons} photons"
    )
    print(f"{'':56s}" + "".join(f"{name:>17s}" for name in TALLIES) + f"{'effective':>11s}")
    for name, share, bias, importance in CASES:
        scene = scene_of(share, arguments.photons)
        plain, biased = (runs_of(scene, arguments.runs, *how) for how in (({}, None), (bias or {}, importance)))
        error = np.sqrt((plain.var(axis=0, ddof=1) + biased.var(axis=0, ddof=1)) / arguments.runs)
        off = np.abs(biased.mean(axis=0) - plain.mean(axis=0)) / error
        if off.max() > 6.0:
            raise SystemExit(f"{name}: a mean is {off.max():.1f} standard errors off: the light is wrong")
        ratio = biased.var(axis=0, ddof=1) / plain.var(axis=0, ddof=1)
        effective = scene.source(0, bias=bias, importance=importance).effective_photons(0) / arguments.photons
        print(f"{name:56s}" + "".join(f"{one:17.3g}" for one in ratio) + f"{effective:11.0%}")


if __name__ == "__main__":
    main()
