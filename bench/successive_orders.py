"""Successive orders of scattering beside PythonicDISORT, and a whole clear sky: time and error in one run.

    python bench/successive_orders.py [--repeats 7]

One thread, CPU time, the least of the turns. A Rayleigh layer under a plane beam, half the sky in 18 x 24 equal bins
of zenith and azimuth, patch means by 3 x 3 Gauss points; both solvers pay for the evaluation in the points, ours also
for its own estimate of the error. The truth is the same means by 12 x 6 points of a solution with three times the
angles and elements; PythonicDISORT with 128 streams in the same points is printed beside it as a second opinion. The
bar: at most 50 ms a wavelength and sun at 0.05 % rms. Then the sky of inputs/atmosphere/clear_marine.atmo with all
orders: 16 wavelengths, 45 x 180 patch means, the sun at 40 degrees, order 1 and the reading included, at most 5 s.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
import sys
from pathlib import Path

import numpy as np
from disort_peer import rayleigh_disort
from harness import best_cpu_time, machine, verdict

from aomc_sky.atmosphere.scattering_orders.diffuse import ALL_ORDERS, Resolution
from aomc_sky.formats.atmo.reader import read_atmo
from aomc_sky.skies.atmosphere import AtmosphereSky
from aomc_sky.source.atmospheres.medium import read_medium

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.plane_layers import Layers, solve_layers

CLEAR_SKY = Path(__file__).resolve().parents[1] / "inputs" / "atmosphere" / "clear_marine.atmo"
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
TAU, MU0 = 0.5, 0.5
N_ZENITH, N_AZIMUTH = 18, 24
STREAMS = (16, 32, 64)
FINE = Resolution(n_mu=64, n_element=32, n_moments=3)


def rayleigh(cosine: np.ndarray) -> np.ndarray:
    return 3.0 / (16.0 * np.pi) * (1.0 + cosine * cosine)


def bin_points(n_bin: int, end: float, n_point: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points of equal bins and their weights inside a bin, (n_bin * n_point,) and (n_point,)."""
    x, w = np.polynomial.legendre.leggauss(n_point)
    width = end / n_bin
    return ((np.arange(n_bin)[:, None] + 0.5 + 0.5 * x) * width).ravel(), 0.5 * w


def means(radiance, n_zenith_point: int, n_azimuth_point: int) -> np.ndarray:
    """Patch means (N_ZENITH, N_AZIMUTH) by solid angle of radiance(zenith, azimuth) on a product of points."""
    zenith, zenith_weight = bin_points(N_ZENITH, 0.5 * np.pi, n_zenith_point)
    azimuth, azimuth_weight = bin_points(N_AZIMUTH, np.pi, n_azimuth_point)
    found = radiance(zenith, azimuth).reshape(N_ZENITH, n_zenith_point, N_AZIMUTH, n_azimuth_point)
    weight = np.sin(zenith).reshape(N_ZENITH, n_zenith_point) * zenith_weight
    weight /= weight.sum(axis=1, keepdims=True)
    return np.einsum("zpaq,zp,q->za", found, weight, azimuth_weight)


def ours(resolution: Resolution | None = None):
    layers = Layers(optical_depth=np.array([TAU]), scattering=np.ones((1, 1)), phases=(rayleigh,))

    def radiance(zenith: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
        sky = solve_layers(layers, 0.0, np.arccos(MU0), zenith, resolution=resolution)
        return sky.by_order(azimuth).sum(axis=1)[0]

    return radiance


def rms(found: np.ndarray, truth: np.ndarray) -> float:
    return float(np.sqrt(np.mean((found / truth - 1.0) ** 2)))


def clear_sky() -> AtmosphereSky:
    medium, _ = read_medium(read_atmo(CLEAR_SKY))
    return AtmosphereSky(medium=dataclasses.replace(medium, n_orders=ALL_ORDERS), sun_zenith_deg=40.0)


def main() -> None:
    if any(os.environ.get(name) != value for name, value in ONE_THREAD.items()):  # numpy reads them when it starts
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, **ONE_THREAD})
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=7)
    repeats = parser.parse_args().repeats
    print(machine())
    coarse = Resolution(n_mu=10, n_element=5, n_moments=3)
    contenders = {"successive orders": ours(), "successive orders, coarse": ours(coarse)}
    contenders |= {f"PythonicDISORT, {n} streams": rayleigh_disort(n, TAU, MU0, 0.0) for n in STREAMS}
    truth = means(ours(FINE), 12, 6)
    print(f"\nRayleigh layer, optical depth {TAU}, mu0 {MU0}, {N_ZENITH} x {N_AZIMUTH} patch means")
    distance = rms(means(rayleigh_disort(128, TAU, MU0, 0.0), 12, 6), truth)
    print(f"  truth against PythonicDISORT, 128 streams: {100 * distance:.4f} % rms")
    times = best_cpu_time({name: (lambda law=law: means(law, 3, 3)) for name, law in contenders.items()}, repeats)
    errors = {name: 100.0 * rms(means(law, 3, 3), truth) for name, law in contenders.items()}
    for name, taken in times.items():
        share = taken / times["successive orders"]
        print(f"  {name:28s} {1e3 * taken:7.1f} ms {share:6.2f} x   {errors[name]:8.4f} % rms")
    whole = best_cpu_time({"sky": clear_sky}, max(repeats // 3, 1))["sky"]
    print(f"\nclear sky, 16 wavelengths, 45 x 180 patches: {whole:.2f} s\n")
    print(f"ms a wavelength and sun      {verdict(1e3 * times['successive orders'], 50.0, at_least=False)}")
    print(f"thousandths of a % rms       {verdict(1e3 * errors['successive orders'], 50.0, at_least=False)}")
    print(f"whole clear sky, s           {verdict(whole, 5.0, at_least=False)}")


if __name__ == "__main__":
    main()
