"""The Perez sky: its integral, the set-up of one sky, and exact rejection against uniform patches.

    python bench/perez.py [--photons 2000000] [--repeats 7]

One thread, photons into reused buffers of 65 536. The bars: the integral of eq. (3) below 1 ms, one sky
(coefficients, masses of 45 x 180 patches, allocation) below 5 ms, rejection at most 1.5 times the time of
photons that are uniform inside the patch.
"""

from __future__ import annotations

import argparse
import statistics
import time

import numpy as np
from harness import in_turns, machine, ratio, verdict

import aomc_sky as sky
from aomc_sky.kernels.backend import announce_photons

SKIES = {
    "dark overcast": {"sun_zenith_rad": 0.8, "epsilon": 1.0, "delta": 0.05},
    "intermediate": {"sun_zenith_rad": 0.8, "epsilon": 1.35, "delta": 0.31},
    "clear": {"sun_zenith_rad": 0.7, "epsilon": 6.3, "delta": 0.12},
}
BATCH = 65_536


def milliseconds(work, repeats: int) -> float:
    """Median time of something short, after a first call."""
    work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return 1e3 * statistics.median(times)


def set_up(inputs: dict[str, float], grid: sky.PatchGrid) -> None:
    model = sky.PerezSky(**inputs, grid=grid)
    sky.allocate(model.patch_mass(grid), 1_000_000, seed=1)


def drain(source: sky.PhotonSource, out: sky.PhotonBatch) -> None:
    for _ in source.batches(0, BATCH, out=out):
        pass


def source_of(inputs: dict[str, float], n_photons: int, **options) -> sky.PhotonSource:
    parts = sky.PerezSky(**inputs, **options.pop("sky", {})).lower(500)
    bands = sky.Wavebands(wavelength_nm=np.array([500.0]))
    return sky.Scene(wavebands=bands, n_photons=n_photons, components=parts).source(seed=1, **options)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--photons", type=int, default=2_000_000)
    parser.add_argument("--repeats", type=int, default=7)
    options = parser.parse_args()
    announce_photons(10**12)

    print(f"{machine()}, medians of {options.repeats} turns")
    grid = sky.PatchGrid.regular(45, 180)
    for name, inputs in SKIES.items():
        model = sky.PerezSky(**inputs, grid=grid)
        a_to_e = model.model_coefficients
        integral = milliseconds(lambda i=inputs, c=a_to_e: sky.perez.horizontal_integral(c, i["sun_zenith_rad"]), 20)
        ready = milliseconds(lambda i=inputs: set_up(i, grid), 20)
        print(f"\n{name}")
        print(f"  integral of eq. (3)                  {integral:7.2f} ms   {verdict(integral, 1.0, at_least=False)}")
        print(f"  coefficients, masses, allocation     {ready:7.2f} ms   {verdict(ready, 5.0, at_least=False)}")
        for order in ("shuffled", "patch"):
            sources = {
                within: source_of(inputs, options.photons, order=order, sky={"grid": grid, "within": within})
                for within in ("exact", "uniform")
            }
            batches = {within: source.photons(0, 0, BATCH) for within, source in sources.items()}
            times = in_turns(
                {w: lambda w=w, s=s, b=batches: drain(s[w], b[w]) for w, s in ((w, sources) for w in sources)},
                options.repeats,
            )
            each = {within: statistics.median(taken) / options.photons * 1e9 for within, taken in times.items()}
            found = ratio(times["exact"], times["uniform"])
            print(
                f"  exact / uniform, {order:9s} {each['exact']:6.2f} / {each['uniform']:5.2f} ns per photon"
                f"   {verdict(found, 1.5, at_least=False)}"
            )


if __name__ == "__main__":
    main()
