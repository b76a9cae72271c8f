"""Every solver of the atmosphere on one sky: time a wavelength against error, in one run.

    python bench/atmosphere_solvers.py [--repeats 3]

One thread, CPU time of the process, turn about, the least of the turns; each solver starts from the medium, so its
tables are paid for. Air that scatters like molecules, of optical depth 0.5, over ground of albedo 0.2, the sun at 60
degrees; the radius of the ground is 1e11 m, so that flat layers, in which the truth is known, are the same
atmosphere. Compared are flux-weighted means of 9 x 12 patches of half the sky, by their relative rms deviation from a
solution by successive orders with three times the angles and elements, 12 x 6 points a patch; PythonicDISORT with 128
streams in the same points is printed beside it as a second opinion.

`mc` follows paths in 2 x 2 points of each patch. What curved air adds to the error of `sos` is another matter:
docs/models/atmosphere.md.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

import numpy as np
from disort_peer import rayleigh_disort
from harness import best_cpu_time, machine

from aomc_sky.atmosphere.backward import solve_paths
from aomc_sky.atmosphere.medium import Constituent, Medium
from aomc_sky.atmosphere.scattering_orders.diffuse import ALL_ORDERS, Resolution
from aomc_sky.errors import MissingExtraError
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.atmosphere import AtmosphereSky

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.plane_layers import Layers, solve_layers

ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
TAU, MU0, ALBEDO = 0.5, 0.5, 0.2
SUN = float(np.arccos(MU0))
GRID = PatchGrid.regular(9, 24)
HALF = 12
FINE = Resolution(n_mu=64, n_element=32, n_moments=3)
PATHS, STREAMS = (100, 1000, 10_000), (16, 32, 64)
MOST = 40


def rayleigh(cosine: np.ndarray, row: int = 0) -> np.ndarray:
    return 3.0 / (16.0 * np.pi) * (1.0 + cosine * cosine)


def medium() -> Medium:
    column = -8e3 * np.expm1(-15.0)
    gas = Constituent(
        name="gas", number_density=lambda h: np.exp(-h / 8e3) / column, kink_altitude_m=np.empty(0),
        scattering_m2=np.array([TAU]), absorption_m2=np.zeros(1), phase_function=rayleigh,
    )  # fmt: skip
    return Medium(
        earth_radius_m=1e11, top_m=120e3, wavelength_nm=np.array([550.0]), constituents=(gas,),
        ground_albedo=np.array([ALBEDO]), toa_irradiance=np.ones(1), sun_angular_radius_rad=0.0, n_orders=ALL_ORDERS,
    )  # fmt: skip


def points(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Zenith angles (9 n,) and azimuths (12 n,) of Gauss points in mu^2 and azimuth, and their weights (n,)."""
    x, w = np.polynomial.legendre.leggauss(n)
    share = (x + 1.0) / 2.0
    near, growth, far = GRID.ring_sin2()
    sin2, cos2 = near[:, None] + growth[:, None] * share, far[:, None] + growth[:, None] * (1.0 - share)
    azimuth = (np.arange(HALF)[:, None] + share) * np.pi / HALF
    return np.arctan2(np.sqrt(sin2), np.sqrt(cos2)).ravel(), azimuth.ravel(), w / 2.0


def means(radiance, n_zenith: int, n_azimuth: int) -> np.ndarray:
    """Patch means (9, 12) of radiance(zenith, azimuth), which answers on the product of its arguments."""
    zenith, _, up = points(n_zenith)
    _, azimuth, around = points(n_azimuth)
    found = np.asarray(radiance(zenith, azimuth)).reshape(-1, n_zenith, HALF, n_azimuth)
    return np.einsum("zpaq,p,q->za", found, up, around)


def table(method: str) -> np.ndarray:
    sky = AtmosphereSky(medium=medium(), sun_zenith_deg=60.0, method=method, grid=GRID)
    return sky.patch_mean[0].sum(axis=0).reshape(GRID.n_zenith, -1)[:, :HALF]


def paths(n_paths: int) -> np.ndarray:
    def radiance(zenith: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
        theta, phi = np.meshgrid(zenith, azimuth, indexing="ij")
        return solve_paths(
            medium(), sun_zenith_rad=SUN, sky_zenith_rad=theta.ravel(), azimuth_from_sun_rad=phi.ravel(),
            n_paths=n_paths, n_orders=MOST, seed=1,
        ).radiance[0]  # fmt: skip

    return means(radiance, 2, 2)


def layers(resolution: Resolution):
    slab = Layers(optical_depth=np.array([TAU]), scattering=np.ones((1, 1)), phases=(rayleigh,))

    def radiance(zenith: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
        return solve_layers(slab, ALBEDO, SUN, zenith, resolution=resolution).by_order(azimuth).sum(axis=1)[0]

    return radiance


def contenders() -> dict[str, object]:
    found = {"order1": lambda: table("order1"), "sos": lambda: table("sos")}
    found |= {f"mc, {4 * n} paths a patch": lambda n=n: paths(n) for n in PATHS}
    try:
        flat = {f"PythonicDISORT, {n} streams": rayleigh_disort(n, TAU, MU0, ALBEDO) for n in STREAMS}
    except MissingExtraError as error:
        print(f"left out: {error}")
        return found
    return found | {name: lambda law=law: means(law, 3, 3) for name, law in flat.items()}


def rms(found: np.ndarray, truth: np.ndarray) -> float:
    return float(np.sqrt(np.mean((found / truth - 1.0) ** 2)))


def main() -> None:
    if any(os.environ.get(name) != value for name, value in ONE_THREAD.items()):  # numpy reads them when it starts
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, **ONE_THREAD})
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=3)
    repeats = parser.parse_args().repeats
    print(machine())
    solvers = contenders()
    truth = means(layers(FINE), 12, 6)
    if any("DISORT" in name for name in solvers):
        distance = rms(means(rayleigh_disort(128, TAU, MU0, ALBEDO), 12, 6), truth)
        print(f"\ntruth against PythonicDISORT, 128 streams: {100 * distance:.4f} % rms")
    found: dict[str, np.ndarray] = {}
    timed = {name: (lambda name=name: found.update({name: solvers[name]()})) for name in solvers}
    times = best_cpu_time(timed, repeats, time.process_time)
    print(f"\n{'':32s}{'s a wavelength':>16s}{'rms error, %':>14s}")
    for name, taken in times.items():
        print(f"{name:32s}{taken:16.4f}{100 * rms(found[name], truth):14.4f}")


if __name__ == "__main__":
    main()
