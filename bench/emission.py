"""Time per photon of the compiled emission: a table, Perez skies, lobes, and tables of 1e6 and 4e6 patches.

    python bench/emission.py                                    # this tree
    python bench/emission.py --before ../other/src [--bar 1.03] # against another tree, turn and turn about

Each tree runs in a process of its own, which is asked for one row at a time. The figures are medians over the turns of
the slope of processor time between two numbers of photons. Three quarters of the photons of the row "perez" come from
the disc of the sun, those of "diffuse" from its sky alone. Where gcc is there, hand_written.c makes the photons of the
table, too, in the process of this tree and with the same bits. NUMBA_CPU_NAME=znver3 NUMBA_CPU_FEATURES= compiles all
for another processor. With --before the exit code is 1 where a row takes longer than the bar allows.
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
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from aomc_sky import PhotonSource, Scene

HERE = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(HERE))
from bench.hand_written import COMPILER, by_hand  # noqa: E402
from bench.harness import machine  # noqa: E402

SCENES = {"table": "clear_day", "perez": "perez_sky", "diffuse": "perez_sky", "lobes": "night_sky"}
RINGS = {"1e6-patches": 1000, "4e6-patches": 2000}
ROWS = [" ".join(row) for row in itertools.product(SCENES, ("float32", "float64"), ("shuffled", "patch"))]
ROWS += [f"{name} float32 shuffled" for name in RINGS]
BY_HAND = "by hand"
SIZES = 100_000, 500_000
N_PHOTONS = 2 * max(SIZES)


def child() -> None:
    """Print the nanoseconds per photon of every row that is asked for."""
    calls: dict[str, list[Callable[[], object]]] = {}
    for row in map(str.strip, sys.stdin):
        if row not in calls:
            scene, precision, order = row.removesuffix(BY_HAND).split()
            source = described(scene).source(precision=precision, order=order)
            make = by_hand_checked if row.endswith(BY_HAND) else emission
            calls[row] = [make(source, n) for n in SIZES]
        short, long = (processor_time(call) for call in calls[row])
        print((long - short) / (SIZES[1] - SIZES[0]) * 1e9, flush=True)


def processor_time(call: Callable[[], object]) -> float:
    """Seconds of this thread, once what the call reads and writes is near."""
    call()
    start = time.thread_time()
    call()
    return time.thread_time() - start


def described(scene: str) -> Scene:
    """A scene of `inputs`, or a table of as many rings as columns."""
    import numpy as np

    import aomc_sky as sky

    if scene in SCENES:
        read = sky.read_scene(HERE / "inputs" / SCENES[scene] / "amc.inp", iterations=N_PHOTONS)
        if scene != "diffuse":
            return read
        skies = [component for component in read.components if component.name != "direct"]
        return sky.Scene(wavebands=read.wavebands, n_photons=N_PHOTONS, components=skies)
    n = RINGS[scene]
    values = 0.5 + np.random.default_rng(1).random((1, n, n))
    table = sky.TabulatedSky(wavelength_nm=[550.0], values=values, grid=sky.PatchGrid.regular(n, n))
    bands = sky.Wavebands(wavelength_nm=np.array([550.0]))
    return sky.Scene(wavebands=bands, n_photons=2 * 10**7, components=[table])


def emission(source: PhotonSource, n: int) -> Callable[[], object]:
    """The kernels for the first n photons of the first waveband."""
    return partial(source._emitter.fill_compiled, 0, 0, outputs(source, n))


def outputs(source: PhotonSource, n: int) -> dict[str, Any]:
    """Arrays for n photons."""
    import numpy as np

    kinds = dict.fromkeys(("ux", "uy", "uz", "x", "y"), source.dtype) | {"patch": np.int32}
    return {name: np.zeros(n, kind) for name, kind in kinds.items()}


def by_hand_checked(source: PhotonSource, n: int) -> Callable[[], object]:
    """Hand-written C for the same photons, which must have the same bits."""
    ours, theirs = outputs(source, n), outputs(source, n)
    source._emitter.fill_compiled(0, 0, ours)
    call = by_hand(source, theirs)
    call()
    differ = [name for name in ("ux", "uy", "uz", "patch") if (ours[name] != theirs[name]).any()]
    assert not differ, f"hand-written C gives other {differ}"
    return call


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
    asked_of = {row: [(process, row) for process in processes] for row in ROWS}
    for row in ROWS if COMPILER else ():
        if row.startswith("table"):
            asked_of[row].append((processes[-1], f"{row} {BY_HAND}"))
    times: dict[str, list[list[float]]] = {row: [[] for _ in pairs] for row, pairs in asked_of.items()}
    for turn in range(-1, options.turns):  # the first turn compiles, or reads what is compiled
        for row, pairs in asked_of.items():
            for one_times, pair in zip(times[row], pairs, strict=True):
                time_asked = asked(*pair)
                if turn >= 0:
                    one_times.append(time_asked)
    for process in processes:
        process.terminate()
        process.wait()
    print(f"{machine()}, code for {os.environ.get('NUMBA_CPU_NAME', 'this processor')}")
    too_slow = False
    for row, row_times in times.items():
        ours = row_times[len(trees) - 1]
        line = "  ".join(f"{statistics.median(turns):6.2f} ns" for turns in row_times[: len(trees)])
        if len(trees) > 1:
            ratio = statistics.median(after / before for before, after in zip(row_times[0], ours, strict=True))
            too_slow |= ratio > options.bar
            line += f"  ratio {ratio:.3f}" + ("  TOO SLOW" if ratio > options.bar else "")
        if len(row_times) > len(trees):
            to_c = statistics.median(own / c for own, c in zip(ours, row_times[-1], strict=True))
            line += f"  gcc {statistics.median(row_times[-1]):6.2f} ns, ours to it {to_c:.3f}"
        print(f"{row:28} {line}")
    return 1 if too_slow else 0


if __name__ == "__main__":
    sys.exit(main())
