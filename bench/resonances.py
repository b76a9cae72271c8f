"""Relative RMSE over seeds on grids of equal patches whose rings are nearly a period of the places' lattice.

    python bench/resonances.py [--seeds 64] [--grid 60x86x1 ...] [--all]

One line per grid and quantity: the package's photons (`default`), places by rank alone, that with ring x golden ratio,
places with plain jitter, independent photons. `--all` takes every grid of 33, 60 and 90 rings whose ring x photons is a
denominator of a convergent or of an intermediate fraction of either step, up to 400, and prints the worst of each.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.support.resonances import EqualPatches, grids

GRIDS = ("60x86x1", "40x86x1", "90x7x1", "33x172x1", "90x49x1", "60x27x1", "90x120x1")


def measured(grid: tuple[int, int, int], seeds: int) -> dict[str, dict[str, float]]:
    patches = EqualPatches(*grid)
    laws = {
        "default": patches.emitted(),
        "by rank": patches.by_rank(),
        "golden": patches.by_rank(golden=True),
        "jitter": patches.jittered(),
        "independent": patches.independent(),
    }
    return {law: patches.errors(places, seeds) for law, places in laws.items()}


def show(grid: tuple[int, int, int], found: dict[str, dict[str, float]]) -> None:
    print(f"\n{grid[0]} x {grid[1]}, {grid[2]} photons each")
    print(f"{'':22s}" + "".join(f"{law:>13s}" for law in found))
    for quantity in found["default"]:
        print(f"{quantity:22s}" + "".join(f"{errors[quantity]:13.2e}" for errors in found.values()))


def show_worst(grid: tuple[int, int, int], found: dict[str, dict[str, float]]) -> None:
    words = [f"{grid[0]:3d} x {grid[1]:3d} x {grid[2]}"]
    for law in ("default", "by rank", "golden"):
        for other in ("jitter", "independent"):
            ratio = {q: found[law][q] / found[other][q] for q in found[law]}
            worst = max(ratio, key=ratio.__getitem__)
            words.append(f"{law} / {other} {ratio[worst]:5.2f} ({worst})")
    print("; ".join(words), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=64)
    parser.add_argument("--grid", nargs="+", default=GRIDS, help="rings x columns x photons of a patch")
    parser.add_argument("--all", action="store_true")
    options = parser.parse_args()
    if options.all:
        for grid in grids((33, 60, 90)):
            show_worst(grid, measured(grid, options.seeds))
        return
    for text in options.grid:
        rings, columns, each = map(int, text.split("x"))
        show((rings, columns, each), measured((rings, columns, each), options.seeds))


if __name__ == "__main__":
    main()
