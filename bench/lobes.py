"""A Perez sky with the twenty lobes of a night beside the Perez sky alone; tries of the lobes' samplers.

    python bench/lobes.py [--photons 1000000] [--repeats 15]

CPU time of one thread, least of turns, photons into reused buffers of 65 536. The bars: with one photon in five from
lobes at least half the photons per second of the Perez sky alone (other shares are printed besides), and at most
3 tries a photon for every lobe of a grid of hard ones.
"""

from __future__ import annotations

import argparse
import dataclasses
import itertools

import numpy as np
from harness import best_cpu_time, machine, verdict

import aomc_sky as sky
from aomc_sky.component import Component
from aomc_sky.kernels.backend import announce_photons
from aomc_sky.skies.lobes.envelope import LobeFrame, envelope_of
from aomc_sky.skies.lobes.sky import lobe_components

BATCH = 65_536
N_LOBES = 20
SHARES = (0.05, 0.2, 0.5)
ROUGHNESS = ((1e-4, 1e-4), (0.01, 0.02), (0.3, 0.3), (1.0, 1.0), (1e3, 1e3), (0.01, 100.0), (1e-4, 1.0), (0.1, 1e3))
ASYMMETRY = (0.0, 1e-8, 0.5, 0.9, 0.99, 0.99999, 1 - 2.0**-24, 1 - 1e-10, 1 - 1e-14)
ZENITHS_DEG = (0.0, 10.0, 60.0, 70.0, 80.0, 88.0, 89.999, 90.0, 90.0001, 91.0, 95.0, 120.0, 150.0, 170.0, 179.9, 180.0)


def night(strength: float) -> tuple[Component, ...]:
    """Twenty lobes of all kinds, widths and directions that share a strength."""
    rng = np.random.default_rng(5)
    kinds = (["hg", "ggx", "beckmann"] * N_LOBES)[:N_LOBES]
    rough = 10 ** rng.uniform(-1.5, 0.3, (2, N_LOBES))
    first = np.where(np.array(kinds) == "hg", rng.uniform(0, 0.95, N_LOBES), rough[0])
    lobes = lobe_components(
        names=[f"lobe {i}" for i in range(N_LOBES)],
        kinds=kinds,
        param0=first,
        param1=rough[1],
        quaternion=rng.normal(size=(N_LOBES, 4)),
        irradiance=np.ones((N_LOBES, 1)),
    )
    return tuple(
        dataclasses.replace(lobe, strength=np.array([strength / len(lobes)]), irradiance_W_m2_nm=None) for lobe in lobes
    )


def sources(n_photons: int) -> dict[str, sky.PhotonSource]:
    bands = sky.Wavebands(wavelength_nm=np.array([500.0]))
    perez = sky.PerezSky(sun_zenith_rad=0.7, epsilon=6.3, delta=0.12, grid=sky.PatchGrid.regular(45, 180)).lower(500)
    total = float(perez[0].strength[0])
    scenes = {"Perez alone": perez}
    for share in SHARES:
        scenes[f"{100 * share:g} % from lobes"] = (*perez, *night(total * share / (1 - share)))
    return {
        name: sky.Scene(wavebands=bands, n_photons=n_photons, components=parts).source(seed=1)
        for name, parts in scenes.items()
    }


def tries(shape: tuple[str, float, float], zenith_deg: float) -> float:
    """Mean number of tries of a lobe; 0 where nothing of it is above the horizon."""
    half = np.deg2rad(zenith_deg) / 2
    quaternion = np.array([np.cos(half), np.sin(half) * 0.8, np.sin(half) * 0.6, 0.0])
    projected = float(sky.lobes.mass_above_horizon(*shape, quaternion, weighting="projected"))
    return envelope_of(LobeFrame.of(*shape, quaternion))[1] / projected if projected > 1e-200 else 0.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--photons", type=int, default=1_000_000)
    parser.add_argument("--repeats", type=int, default=15)
    options = parser.parse_args()
    announce_photons(10**12)  # compiled from the first photon on

    print(f"{machine()}, least CPU time of {options.repeats} turns")
    found = sources(options.photons)
    out = {name: source.photons(0, 0, BATCH) for name, source in found.items()}

    def drain(name: str) -> None:
        for _ in found[name].batches(0, BATCH, out=out[name]):
            pass

    best = best_cpu_time({name: lambda n=name: drain(n) for name in found}, options.repeats)
    alone = best["Perez alone"]
    for name, seconds in best.items():
        bar = verdict(alone / seconds, 0.5, at_least=True) if name.startswith("20 %") else ""
        print(f"  {name:16} {1e9 * seconds / options.photons:6.1f} ns a photon   speed {alone / seconds:.2f}   {bar}")
    shapes = [("hg", g, 0.0) for g in ASYMMETRY]
    shapes += [(kind, *rough) for kind in ("ggx", "beckmann") for rough in ROUGHNESS]
    counts = {case: tries(*case) for case in itertools.product(shapes, ZENITHS_DEG)}
    lit = {case: count for case, count in counts.items() if count > 0}
    worst = max(lit, key=lit.__getitem__)
    mean, most = np.mean(list(lit.values())), verdict(lit[worst], 3.0, at_least=False)
    print(f"  tries a photon, {len(lit)} hard lobes: mean {mean:.2f}, most {lit[worst]:.2f}   {most}")
    print(f"  most at {worst[0]} with the axis at {worst[1]:g} degrees")


if __name__ == "__main__":
    main()
