"""Time per photon of the compiled emission: a table and a Perez sky, both precisions and orders; lobes; large tables.

    python bench/emission.py                                    # this tree
    python bench/emission.py --before ../other/src [--bar 1.03] # against another tree, turn and turn about

Each tree runs in a process of its own, which is asked for one row at a time; the figures are medians of processor time
over the turns. With --before the exit code is 1 where a row takes longer than the bar allows.
"""

from __future__ import annotations

import argparse
import itertools
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from aomc_sky import PhotonSource, Scene

HERE = Path(__file__).resolve().parents[1]
SCENES = {"table": "clear_day", "perez": "perez_sky", "lobes": "night_sky"}
PATCHES = {"1e6-patches": (1000, 1000), "4e6-patches": (2000, 2000)}
ROWS = [" ".join(row) for row in itertools.product(("table", "perez"), ("float32", "float64"), ("shuffled", "patch"))]
ROWS += [f"{name} float32 shuffled" for name in ("lobes", *PATCHES)]
N_PHOTONS = 500_000


def child() -> None:
    """Print the nanoseconds per photon of every row that is asked for."""
    calls: dict[str, Callable[[], object]] = {}
    for row in map(str.strip, sys.stdin):
        if row not in calls:
            name, precision, order = row.split()
            calls[row] = emission(scene(name).source(precision=precision, order=order))
            calls[row]()
        start = time.thread_time()
        calls[row]()
        print((time.thread_time() - start) / N_PHOTONS * 1e9, flush=True)


def scene(name: str) -> Scene:
    """A scene of inputs/, or a table of many patches."""
    import numpy as np

    import aomc_sky as sky

    if name in SCENES:
        return sky.read_scene(HERE / "inputs" / SCENES[name] / "amc.inp", iterations=2 * N_PHOTONS)
    grid = sky.PatchGrid.regular(*PATCHES[name])
    values = 1.0 + np.arange(grid.n_patches).reshape(1, -1) % 7
    model = sky.TabulatedSky(grid=grid, wavelength_nm=[550.0], values=values)
    return sky.Scene(wavebands=[550.0], n_photons=2 * N_PHOTONS, components=model)


def emission(source: PhotonSource) -> Callable[[], object]:
    """The kernels of the first waveband."""
    import numpy as np

    kinds = dict.fromkeys(("ux", "uy", "uz", "x", "y"), source.dtype) | {"patch": np.int32}
    return partial(
        source._emitter.fill_compiled, 0, 0, {name: np.empty(N_PHOTONS, kind) for name, kind in kinds.items()}
    )


def started(tree: Path) -> subprocess.Popen[str]:
    """A process that times the package of a tree."""
    environment = {**os.environ, "PYTHONPATH": str(tree)}
    command = [sys.executable, str(Path(__file__).resolve()), "--child"]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment)


def asked(process: subprocess.Popen[str], row: str) -> float:
    """Nanoseconds per photon of one turn of a row."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(row + "\n")
    process.stdin.flush()
    return float(process.stdout.readline())


def main() -> int:
    """Print a line for each row."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--before", type=Path, help="the folder that holds another tree's package aomc_sky")
    parser.add_argument("--bar", type=float, default=1.03, help="largest ratio of the times")
    parser.add_argument("--turns", type=int, default=61)
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        child()
        return 0
    trees = [HERE / "src"] if options.before is None else [options.before.resolve(), HERE / "src"]
    processes = [started(tree) for tree in trees]
    times: dict[str, list[list[float]]] = {row: [[] for _ in trees] for row in ROWS}
    for row in ROWS:
        for process in processes:
            asked(process, row)  # compiles, or reads what is compiled
    for _ in range(options.turns):
        for row, (process, of_tree) in itertools.product(ROWS, enumerate(processes)):
            times[row][process].append(asked(of_tree, row))
    for process in processes:
        process.terminate()
        process.wait()
    too_slow = False
    for row, of_row in times.items():
        medians = [statistics.median(turns) for turns in of_row]
        line = "  ".join(f"{value:6.2f} ns" for value in medians)
        if len(medians) > 1:
            ratio = statistics.median(b / a for a, b in zip(*of_row, strict=True))
            too_slow |= ratio > options.bar
            line += f"  ratio {ratio:.3f}" + ("  TOO SLOW" if ratio > options.bar else "")
        print(f"{row:24} {line}")
    return 1 if too_slow else 0


if __name__ == "__main__":
    sys.exit(main())
