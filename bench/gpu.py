"""Photons a second of aomc_sky.h on a GPU, and the ratio to cuRAND, which draws three numbers a photon.

    python bench/gpu.py [--photons 1e9]

A photon is made by `aomc_sky_at` in a thread and added up, so that no memory for photons is in the time. Directions
are those of our batches, bit for bit: `python -m pytest tests/include/test_gpu.py`.
"""

from __future__ import annotations

import argparse
import ctypes
import statistics
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import aomc_sky as sky
from bench.source_file import scenes
from tests.include.test_gpu import gpu

CURAND = 2
DRIVER = gpu("-fmad=false -DDRIVER_PEER")


def seconds(way: int, n: int) -> float:
    """Median time of a kernel for n photons."""
    return statistics.median(DRIVER.library.driver_seconds(way, ctypes.c_int64(n)) for _ in range(5))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--photons", type=float, default=1e9, help="of each source")
    n = int(parser.parse_args().photons)
    print(f"cuRAND: {n / seconds(CURAND, n) / 1e9:.1f} x 10^9 photons a second")
    print("10^9 photons a second | time / cuRAND")
    for name, components in scenes().items():
        wavebands = sky.Wavebands(wavelength_nm=np.linspace(400, 700, components[0].strength.size))
        for order in ("shuffled", "patch"):
            for way, precision in enumerate(("float32", "float64")):
                scene = sky.Scene(wavebands=wavebands, n_photons=n, components=components)
                DRIVER.open(scene.source(seed=3, order=order, precision=precision))
                ours = seconds(way, n)
                print(f"{name:16} {order:8} {precision} {n / ours / 1e9:7.2f} | {ours / seconds(CURAND, n):5.2f}")


if __name__ == "__main__":
    main()
