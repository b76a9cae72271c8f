"""Photons per second against numpy: all contenders deliver float32 unit vectors, one thread.

    python bench/emission.py [--photons 1000000 10000000] [--repeats 7] [--batch 65536]

The sky has 90 x 360 patches with the gradation of a clear one. Ours fills reused buffers in batches;
numpy chooses patches (`Generator.choice` with p, or multinomial counts and repeat), then places each
photon uniformly in its patch and turns it into a vector: in its own float64, as one writes it first,
and tuned, with float32 random numbers and functions throughout. The bar stands against both.
"""

from __future__ import annotations

import argparse
import statistics

import numpy as np
from harness import in_turns, machine, ratio, verdict

import aomc_sky as sky

BAR = 20.0
N_ZENITH, N_AZIMUTH = 90, 360


def clear_sky() -> tuple[sky.PatchGrid, np.ndarray]:
    """Radiance that brightens towards the horizon and around a sun at 40 degrees."""
    grid = sky.PatchGrid.regular(N_ZENITH, N_AZIMUTH)
    zenith = np.deg2rad(grid.zenith_bounds_deg.mean(axis=1))[:, None]
    azimuth = np.deg2rad(grid.azimuth_bounds_deg.mean(axis=1))[None, :]
    sun = np.deg2rad(40.0)
    apart = np.arccos(np.clip(np.cos(zenith) * np.cos(sun) + np.sin(zenith) * np.sin(sun) * np.cos(azimuth), -1, 1))
    radiance = (1 - np.exp(-0.32 / np.cos(zenith))) * (1 + 10 * np.exp(-3 * apart) + 0.45 * np.cos(apart) ** 2)
    return grid, radiance[None]


class NumpySampler:
    """The same photons, as one writes it with numpy."""

    def __init__(self, grid: sky.PatchGrid, p: np.ndarray, dtype: type) -> None:
        self.rng = np.random.default_rng(1)
        self.p, self.dtype = p, dtype
        near, far = grid.ring_mu()
        self.mu2, self.growth = (far**2).astype(dtype), (near**2 - far**2).astype(dtype)
        start, end = np.deg2rad(grid.azimuth_bounds_deg).T
        self.azimuth, self.width = start.astype(dtype), (end - start).astype(dtype)

    def place(self, patch: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Unit vectors of photons, each uniform in its patch."""
        ring, column = np.divmod(patch, N_AZIMUTH)
        mu2 = self.mu2[ring] + self.growth[ring] * self.rng.random(patch.size, dtype=self.dtype)
        azimuth = self.azimuth[column] + self.width[column] * self.rng.random(patch.size, dtype=self.dtype)
        sine = np.sqrt(1 - mu2)
        vector = -sine * np.cos(azimuth), -sine * np.sin(azimuth), -np.sqrt(mu2)
        return tuple(component.astype(np.float32, copy=False) for component in vector)

    def choice(self, n: int) -> object:
        """Patches drawn one by one."""
        return self.place(self.rng.choice(self.p.size, size=n, p=self.p))

    def multinomial(self, n: int) -> object:
        """Photons sorted by patch."""
        return self.place(np.repeat(np.arange(self.p.size), self.rng.multinomial(n, self.p)))


def drain(source: sky.PhotonSource, out: sky.PhotonBatch) -> None:
    for _ in source.batches(0, len(out), out=out):
        pass


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--photons", type=int, nargs="+", default=[1_000_000, 10_000_000])
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--batch", type=int, default=65_536, help="photons per call, into the same buffers")
    options = parser.parse_args()
    import aomc_sky.kernels.emit  # noqa: F401 - compiled from the first photon on

    grid, radiance = clear_sky()
    table = sky.TabulatedSky(wavelength_nm=[500], values=radiance, grid=grid, weighting="projected")
    bands = sky.Wavebands(wavelength_nm=np.array([500.0]))
    print(f"{machine()}, batches of {options.batch}")
    for n in options.photons:
        scene = sky.Scene(wavebands=bands, n_photons=n, components=table.lower([500]))
        mass = scene.source().mass(0)
        contenders = {}
        for order in ("shuffled", "patch"):
            for precision in ("float32", "float64"):
                source = scene.source(seed=1, order=order, precision=precision)
                out = source.photons(0, 0, min(n, options.batch))
                contenders[f"{order} {precision}"] = lambda source=source, out=out: drain(source, out)
        for dtype, name in ((np.float64, "numpy"), (np.float32, "tuned")):
            sampler = NumpySampler(grid, mass, dtype)
            contenders[f"{name} choice"] = lambda n=n, s=sampler: s.choice(n)
            contenders[f"{name} multinomial"] = lambda n=n, s=sampler: s.multinomial(n)
        times = in_turns(contenders, options.repeats)
        print(f"\n{n} photons, {N_ZENITH} x {N_AZIMUTH} patches, median of {options.repeats} turns")
        for name, taken in times.items():
            median = statistics.median(taken)
            print(f"  {name:20s} {median / n * 1e9:8.2f} ns per photon {n / median / 1e6:9.1f} million per second")
        for ours, peer in (("shuffled float32", "numpy choice"), ("patch float32", "numpy multinomial")):
            print(f"  {peer} / {ours:18s} {verdict(ratio(times[peer], times[ours]), BAR, at_least=True)}")
            tuned = peer.replace("numpy", "tuned")
            print(f"  {tuned} / {ours:18s} {verdict(ratio(times[tuned], times[ours]), BAR, at_least=True)}")


if __name__ == "__main__":
    main()
