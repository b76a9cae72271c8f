"""Backward paths beside Mitsuba 3 on a homogeneous slab, and in shells of the earth's atmosphere: speed in one run.

    python bench/backward_paths.py [--paths 100000] [--repeats 7]

CPU time of the process, turn about, the least of the turns. A flat slab of optical depth 0.5 that scatters like air
over black ground, the sun at 60 degrees: our paths in one shell beside the `volpath` integrator of Mitsuba's variant
scalar_rgb, both from an eye at the bottom that looks up under 40 degrees. Mitsuba carries three colours and any
scene; ours one wavelength, in spheres, and samples order 1 with a quarter of its paths, since that is solved by
quadrature. Both radiances are printed beside the truth (successive orders). Then a molecular atmosphere of the same
optical depth in shells. The bars: 3 times as many paths a second as Mitsuba, and in shells at least 60 % of those in
the slab.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from harness import machine, verdict

from aomc_sky.atmosphere.backward import CHECKED, Bundle, Shells, path_tables
from aomc_sky.atmosphere.medium import Constituent, Medium
from aomc_sky.extras import optional_module

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.plane_layers import Layers, solve_layers

TAU, SUN, VIEW = 0.5, np.radians(60.0), np.radians(40.0)
MOST = 40


def rayleigh(cosine: np.ndarray, row: int = 0) -> np.ndarray:
    return 3.0 / (16.0 * np.pi) * (1.0 + cosine * cosine)


def medium(density, radius_m: float, top_m: float) -> Medium:
    """One gas of optical depth TAU; `density` integrates to 1 over the altitude."""
    gas = Constituent(
        name="gas", number_density=density, kink_altitude_m=np.empty(0), scattering_m2=np.array([TAU]),
        absorption_m2=np.zeros(1), phase_function=rayleigh,
    )  # fmt: skip
    return Medium(
        earth_radius_m=radius_m, top_m=top_m, wavelength_nm=np.array([550.0]), constituents=(gas,),
        ground_albedo=np.zeros(1), toa_irradiance=np.ones(1), sun_angular_radius_rad=0.0, n_orders=MOST,
    )  # fmt: skip


def ours(given: Medium, n_paths: int, shells: Shells | None = None):
    """A function that follows the paths and returns the radiance, order 1 by paths too; and the number of shells."""
    tables = path_tables(given, shells)
    paths = Bundle(given, tables, SUN, None, np.zeros(1), (n_paths, MOST, 1))

    def work() -> float:
        orders, whole = np.zeros((24, 2)), np.zeros(6)
        paths.follow(0, VIEW, np.pi / 2, orders, whole)
        return float(whole[0] + CHECKED * whole[3]) / n_paths

    return work, tables.shells[0].shape[1]


def mitsuba(n_paths: int):
    mi = optional_module("mitsuba", extra="bench")
    mi.set_variant("scalar_rgb")
    towards = [0.0, float(np.sin(VIEW)), float(np.cos(VIEW))]
    eye = [0.0, 0.0, -0.49999]
    scene = mi.load_dict({
        "type": "scene",
        "air": {"type": "homogeneous", "albedo": 1.0, "sigma_t": TAU, "phase": {"type": "rayleigh"}},
        "slab": {
            "type": "cube",
            "to_world": mi.ScalarTransform4f().scale([1e4, 1e4, 0.5]),
            "bsdf": {"type": "null"},
            "interior": {"type": "ref", "id": "air"},
        },
        "sun": {"type": "directional", "direction": [-float(np.sin(SUN)), 0.0, -float(np.cos(SUN))], "irradiance": 1.0},
        "sensor": {
            "type": "radiancemeter", "origin": eye, "direction": towards, "medium": {"type": "ref", "id": "air"},
            "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": n_paths},
        },
        "integrator": {"type": "volpath", "max_depth": MOST + 1, "rr_depth": 5},
    })  # fmt: skip
    return lambda: float(np.array(mi.render(scene, spp=n_paths)).ravel()[0])


def truth() -> float:
    layers = Layers(optical_depth=np.array([TAU]), scattering=np.ones((1, 1)), phases=(rayleigh,))
    sky = solve_layers(layers, 0.0, SUN, np.array([VIEW]))
    return float(sky.by_order(np.array([np.pi / 2])).sum())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--paths", type=int, default=100_000)
    parser.add_argument("--repeats", type=int, default=7)
    args = parser.parse_args()
    flat = medium(np.ones_like, 1e9, 1.0)
    one = Shells(edge_m=np.array([0.0, 1.0]), density=np.ones((1, 1)))
    earth = medium(lambda h: np.exp(-h / 8e3) / 8e3, 6.371e6, 120e3)
    slab, _ = ours(flat, args.paths, one)
    shells, n_shells = ours(earth, args.paths)
    contenders = {"slab": slab, "shells": shells, "Mitsuba": mitsuba(args.paths)}
    taken = dict.fromkeys(contenders, np.inf)
    for turn in range(-1, args.repeats):
        for name, work in contenders.items():
            start = time.process_time()
            work()
            if turn >= 0:
                taken[name] = min(taken[name], time.process_time() - start)
    print(machine())
    print(f"\noptical depth {TAU}, radiances:")
    print(f"  slab {slab():.5f}, Mitsuba {contenders['Mitsuba']():.5f}, truth {truth():.5f}")
    for name, spent in taken.items():
        print(f"  {name:8s} {args.paths / spent / 1e6:6.3f} million paths a second")
    print(f"\nslab, times Mitsuba          {verdict(taken['Mitsuba'] / taken['slab'], 3.0, at_least=True)}")
    print(f"{n_shells} shells, % of the slab   {verdict(100 * taken['slab'] / taken['shells'], 60.0, at_least=True)}")


if __name__ == "__main__":
    main()
