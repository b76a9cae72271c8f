"""Light of a scene's sky in a layer of water: shares of its irradiance, with standard errors.

    python examples/slab/run_slab.py inputs/clear_day/amc.inp --depth 10

The photons come from aomc-sky inside the compiled loop; the physics is in `transport.py`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from philox import transport_key
from tally import ONE_PHOTON, Tally
from transport import simulate
from water import Water, water_layer

import aomc_sky as sky

FATES = ("reflected by the surface", "leaving the water", "absorbed by the water", "absorbed by the bottom")


@dataclass(frozen=True, kw_only=True, slots=True)
class Estimate:
    """Means over replicates and their standard errors, as shares of the irradiance above the surface."""

    mean: np.ndarray
    error: np.ndarray


def estimate(values: Sequence[np.ndarray]) -> Estimate:
    """Mean and standard error over independent replicates."""
    table = np.asarray(values)
    return Estimate(mean=table.mean(axis=0), error=table.std(axis=0, ddof=1) / np.sqrt(len(table)))


def optical_depths_of(depths_m: np.ndarray, water: Water) -> np.ndarray:
    """Optical depths above the given depths, the last of which is the bottom and gets the layer's own to the bit."""
    return water.optical_depth * (depths_m / depths_m[-1])


def run(options: argparse.Namespace, water: Water, depths_m: np.ndarray) -> list[Tally]:
    """Simulate each replicate: a seed of its own for the source, a key of its own for the transport."""
    n = options.photons // options.replicates
    scene = sky.read_scene(options.amc, iterations=n, wavebands=[options.waveband])
    optical_depths = optical_depths_of(depths_m, water)
    tallies = []
    for seed in range(options.seed, options.seed + options.replicates):
        source, numbers = scene.source(seed, precision="float64"), options.numbers
        sample = source.numba_sampler(options.waveband - 1, numbers=numbers).sample
        tallies.append(
            simulate(sample, n, water, transport_key(seed), optical_depths, options.threads, numbers=numbers)
        )
    return tallies


def report(tallies: list[Tally], n_photons: int, depths_m: np.ndarray) -> str:
    """The table."""
    one = float(n_photons) * ONE_PHOTON
    fate = estimate([tally.fate / one for tally in tallies])
    lines = ["share of the irradiance above the surface      value   std. error"]
    lines += [f"{name:<42}{fate.mean[k]:10.6f}{fate.error[k]:13.1e}" for k, name in enumerate(FATES)]
    down, up = estimate([tally.down / one for tally in tallies]), estimate([tally.up / one for tally in tallies])
    lines += ["", "   depth [m]          Ed   std. error          Eu   std. error"]
    lines += [
        f"{depth:12.3f}{down.mean[k]:12.6f}{down.error[k]:13.1e}{up.mean[k]:12.6f}{up.error[k]:13.1e}"
        for k, depth in enumerate(depths_m)
    ]
    return "\n".join(lines)


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("amc", help="amc.inp, or the folder that holds it")
    parser.add_argument("--depth", type=float, default=10.0, help="of the bottom [m]")
    parser.add_argument("--absorption", type=float, default=0.05, help="of the water [1/m]")
    parser.add_argument("--scattering", type=float, default=0.15, help="of the water [1/m]")
    parser.add_argument("--asymmetry", type=float, default=0.924, help="mean cosine of Henyey and Greenstein's part")
    parser.add_argument("--rayleigh", type=float, default=0.0, help="share of Rayleigh's part in the scattering")
    parser.add_argument("--index", type=float, default=1.34, help="refractive index of the water")
    parser.add_argument("--bottom", type=float, help="reflectance of the bottom; default: that of lambbot.inp")
    parser.add_argument("--levels", type=int, default=6, help="depths to print, from surface to bottom")
    parser.add_argument("--waveband", type=int, default=1, help="1 is the first of lambbot.inp")
    parser.add_argument("--photons", type=int, default=1_000_000, help="of all replicates together")
    parser.add_argument("--replicates", type=int, default=8, help="independent runs, for the standard errors")
    parser.add_argument("--seed", type=int, default=1, help="of the first replicate; the next ones count on")
    parser.add_argument(
        "--numbers", type=int, choices=range(4), default=0, help="numbers of the photon that its first event takes"
    )
    parser.add_argument("--threads", type=int, help="default: all cores; the result is the same")
    options = parser.parse_args(arguments)
    if options.replicates < 2 or options.photons < options.replicates or options.levels < 2:
        parser.error("a standard error needs two replicates of a photon each, and a profile two levels")
    if options.threads is not None and options.threads < 1:
        parser.error("--threads must be at least 1")
    return options


def bottom_reflectance(options: argparse.Namespace) -> float:
    """What the command line says, or else lambbot.inp."""
    if options.bottom is not None:
        return float(options.bottom)
    known = sky.read_scene(options.amc).wavebands.bottom_reflectance
    if known is None or not 1 <= options.waveband <= known.size:
        raise sky.UsageError(f"lambbot.inp tells no bottom reflectance for waveband {options.waveband}")
    return float(known[options.waveband - 1])


def main(arguments: Sequence[str] | None = None) -> int:
    options = parse(arguments)
    try:
        water = water_layer(
            depth_m=options.depth,
            absorption_per_m=options.absorption,
            scattering_per_m=options.scattering,
            refractive_index=options.index,
            rayleigh_share=options.rayleigh,
            asymmetry=options.asymmetry,
            bottom_reflectance=bottom_reflectance(options),
        )
        depths_m = np.linspace(0.0, options.depth, options.levels)
        tallies = run(options, water, depths_m)
    except sky.AomcSkyError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    print(report(tallies, options.photons // options.replicates, depths_m))
    return 0


if __name__ == "__main__":
    sys.exit(main())
