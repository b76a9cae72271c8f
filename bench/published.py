"""The published problems of ocean optics by `examples/c/ocean.c`, and what expected values in place of crossings gain.

    python bench/published.py [--photons 4000000] [--replicates 32]
    python bench/published.py --gains [--photons 100000] [--replicates 100] [--water clear]

The first prints 36 values of problems 1 (molecules) and 2 (Petzold's phase function) of Mobley et al. (1993) beside
the mean and the spread of their seven models. The sun is a beam at a zenith angle of 60 degrees over a flat surface.

The second prints factors: the variance of independent photons (method iid) over that of ours, in the same program with
the same number of photons. The light is that of inputs/clear_day and inputs/overcast. Waters are Petzold's, the
tallies are taken at 1 m. Each replicate has the photons that are asked for. A variance from R replicates is known to
the root of 2 / (R - 1), and a factor to that of 4 / (R - 1). A second table has what the estimator alone gains: the
variance of independent photons by crossings over that by expected values.

gcc with OpenMP compiles the program. OMP_NUM_THREADS sets its threads.
"""

from __future__ import annotations

import argparse
import csv
import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from harness import count, machine, markdown_table

import aomc_sky as sky
from aomc_sky.cli.commands.info import include_dir

ROOT = Path(__file__).resolve().parents[1]
EXAMPLE = ROOT / "examples" / "c"
PETZOLD = str(EXAMPLE / "petzold.csv")
PHASES = {1: "rayleigh", 2: PETZOLD}
STRETCH = {(1, 0.2): 0.7, (1, 0.9): 0.2, (2, 0.2): 0.7, (2, 0.9): 0.05}
"""By problem and albedo: about what makes the errors at 10 optical depths small without spoiling those at 1."""
WATERS = {"clear": (0.114, 0.037), "coastal": (0.179, 0.219), "harbour": (0.366, 1.824)}
"""Absorption and scattering. [1/m]"""
QUANTITIES = ("Ed", "Ld", "Eu", "Eou", "Lu")
FLAGS = ("-std=gnu99", "-O3", "-march=native", "-fno-math-errno", "-fopenmp")

Table = dict[tuple[str, float], tuple[float, float]]
"""Value and standard error by quantity and optical depth."""


def compiled(folder: Path) -> Path:
    program = folder / "ocean"
    command = ["gcc", *FLAGS, f"-I{include_dir()}", "-o", str(program), str(EXAMPLE / "ocean.c"), "-lm"]
    subprocess.run(command, check=True)
    return program


def table_of(program: Path, source: Path, *options: object) -> Table:
    """What the program prints for a source file."""
    command = [str(program), str(source), *map(str, options)]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()[2:]
    rows = [line.split() for line in lines]
    return {(name, float(depth)): (float(value), float(error)) for depth, name, value, error in rows}


def published() -> list[dict[str, str]]:
    lines = (EXAMPLE / "mobley_1993.csv").read_text().splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def print_problems(program: Path, folder: Path, photons: int, replicates: int) -> None:
    scene = sky.Scene(wavebands=[500.0], n_photons=photons, components=sky.DirectBeam(sun_zenith_deg=60.0))
    source = folder / "beam.sky"
    sky.write_source(scene.source(seed=1, replicates=replicates), source)
    ours: dict[tuple[int, float], Table] = {}
    begin = time.perf_counter()
    for (problem, albedo), stretch in STRETCH.items():
        words = ("-d", "1,5,10", "-i", 0.5, "-a", albedo, "-p", PHASES[problem], "-s", stretch)
        ours[problem, albedo] = table_of(program, source, *words)
    seconds = time.perf_counter() - begin
    rows: list[tuple[str, ...]] = []
    for row in published():
        problem, albedo = int(row["problem"]), float(row["albedo"])
        value, error = ours[problem, albedo][row["quantity"], float(row["optical_depth"])]
        place = (row["problem"], row["albedo"], row["optical_depth"], row["quantity"])
        mean, spread = float(row["mean"]), 100 * float(row["coefficient_of_variation"])
        ratio = f"{value / mean:.3f}"
        rows.append((*place, row["mean"], f"{spread:.1f} %", f"{value:.4g}", f"{100 * error / value:.2g} %", ratio))
    head = ("problem", "albedo", "depth", "quantity", "published mean", "spread", "ours", "standard error", "ratio")
    print(markdown_table(rows, head))
    print(f"\n{photons} photons in {replicates} replicates for each albedo of a problem; {seconds:.0f} s in all")


def factors(one: Table, other: Table) -> list[str]:
    """Variance of one over that of the other, of each quantity."""
    depths = {depth for _, depth in one}
    errors = [(one[key, depth][1], other[key, depth][1]) for key in QUANTITIES for depth in depths]
    found = [(a / b) ** 2 if b > 0 else math.nan for a, b in errors]
    return [f"{factor:.1f}" if factor < 99.95 else f"{factor:.0f}" for factor in found]


def print_gains(program: Path, folder: Path, photons: int, replicates: int, water: str) -> None:
    absorption, scattering = WATERS[water]
    depth = absorption + scattering
    for name in ("clear_day", "overcast"):
        scene = sky.read_scene(ROOT / "inputs" / name, iterations=photons * replicates)
        for method in ("iid", "stratified"):
            made = scene.source(seed=1, replicates=replicates, method=method)
            sky.write_source(made, folder / f"{name}_{method}.sky")
    print(f"{water} water: {absorption} / m absorbed, {scattering} / m scattered; 1 m is {depth:.3g} optical depths")
    print(f"{replicates} replicates of {photons} photons: factors are known to {math.sqrt(4 / (replicates - 1)):.0%}\n")
    rows: list[tuple[str, ...]] = []
    alone: list[tuple[str, ...]] = []
    for name in ("clear_day", "overcast"):
        for phase in ("rayleigh", PETZOLD):
            first: list[Table] = []
            for estimator, flags in (("crossings", ("-c",)), ("expected", ())):
                for numbers in (0, 1, 3):
                    words = ("-d", depth, "-a", scattering / depth, "-p", phase, "-n", numbers, *flags)
                    iid, mine = (
                        table_of(program, folder / f"{name}_{method}.sky", *words) for method in ("iid", "stratified")
                    )
                    first += [iid] if numbers == 0 else []
                    rows.append((name, Path(phase).stem, estimator, str(numbers), *factors(iid, mine)))
                    print(" ".join(rows[-1]), file=sys.stderr, flush=True)
            alone.append((name, Path(phase).stem, *factors(*first)))
    print(markdown_table(rows, ("sky", "phase function", "estimator", "numbers", *QUANTITIES)))
    print("\nindependent photons, crossings over expected values\n")
    print(markdown_table(alone, ("sky", "phase function", *QUANTITIES)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--gains", action="store_true", help="print the factors in place of the problems")
    parser.add_argument("--photons", type=count, help="of each run, with --gains of each replicate")
    parser.add_argument("--replicates", type=count)
    parser.add_argument("--water", choices=WATERS, default="clear")
    options = parser.parse_args()
    print(machine() + "\n")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        program = compiled(folder)
        if options.gains:
            print_gains(program, folder, options.photons or 100_000, options.replicates or 100, options.water)
        else:
            print_problems(program, folder, options.photons or 4_000_000, options.replicates or 32)


if __name__ == "__main__":
    main()
