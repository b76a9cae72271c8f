"""Cost of a photon in each kind of host against batches in Python, one thread, in one run.

    python bench/hosts.py [--photons 4000000] [--repeats 7] [--batch 65536]

The sky is Perez's clear one in 90 x 360 patches, as a table and with its own law inside them.
Contenders take turns: batches into reused buffers (`PhotonSource.batches`), `fill` in batches, the C function
called from a loop in C and from one in Fortran, and `sample(i)` in a jitted loop that adds the directions
up. The loops are compiled here, by gcc and gfortran at -O2, and left out with a line where these are not
installed.
"""

from __future__ import annotations

import argparse
import ctypes
import shutil
import statistics
import subprocess
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numba
import numpy as np
from harness import in_turns, machine, ratio, verdict

import aomc_sky as sky
from aomc_sky.benchmark.skies import bench_sky
from aomc_sky.cli.commands.info import embed_flags, include_dir
from aomc_sky.kernels.backend import announce_photons

HERE = Path(__file__).parent
BARS = {"fill": 1.1, "C": 1.05, "Fortran": 1.05, "sample(i)": 6.0}
SETTINGS: dict[str, tuple[str, dict[str, Any]]] = {
    "shuffled": ("clear-uniform", {}),
    "patch order": ("clear-uniform", {"order": "patch"}),
    "philox": ("clear-uniform", {"placement": "philox"}),
    "shuffled, exact Perez law": ("clear", {}),
}


def compiled_loops(folder: Path) -> dict[str, Any]:
    """The loops of host_loop.c and host_loop.f90 as functions, where their compilers are installed."""
    include = include_dir()
    module = [f"-J{folder}", str(include / "aomc_sky.f90"), str(include / "aomc_sky_embed.c")]
    commands = {
        "C": ("gcc", [str(HERE / "host_loop.c")], "c_loop"),
        "Fortran": ("gfortran", [*module, str(HERE / "host_loop.f90")], "fortran_loop"),
    }
    found = {}
    for name, (compiler, files, function) in commands.items():
        if shutil.which(compiler) is None:
            print(f"{compiler} is not installed: no loop in {name}")
            continue
        library = str(folder / f"{function}.so")
        subprocess.run([compiler, "-O2", "-shared", "-fPIC", "-o", library, *files, *embed_flags()], check=True)
        loop = getattr(ctypes.CDLL(library), function)
        loop.restype = ctypes.c_double
        loop.argtypes = [*[ctypes.c_void_p] * 2, *[ctypes.c_int64] * 2, *[ctypes.c_void_p] * 3, ctypes.c_int]
        found[name] = loop
    return found


def python_batches(source: sky.PhotonSource, out: sky.PhotonBatch) -> None:
    for _ in source.batches(0, len(out), out=out):
        pass


def filled(fill: Any, n: int, out: np.ndarray) -> None:
    for start in range(0, n, out.shape[1]):
        fill(start, out)


def sample_loop(sample: Any) -> Any:
    @numba.njit(nogil=True)
    def loop(n: int) -> float:
        total = 0.0
        for i in range(n):
            ux, uy, uz = sample(i)
            total += ux + uy + uz
        return total

    return loop


def contenders_of(
    source: sky.PhotonSource, stream: Any, loops: dict[str, Any], n: int, batch: int
) -> dict[str, Callable[[], object]]:
    """Every host of a source, ready to be timed."""
    sampler = source.numba_sampler(0)
    out = np.empty((3, batch), source.dtype)
    pointers = [row.ctypes.data for row in out]
    contenders: dict[str, Callable[[], object]] = {
        "batches in Python": partial(python_batches, source, source.photons(0, 0, batch)),
        "fill": partial(filled, sampler.fill, n, out),
    }
    for name, loop in loops.items():
        contenders[name] = partial(loop, stream.address, stream.context, n, batch, *pointers, 0)
    contenders["sample(i)"] = partial(sample_loop(sampler.sample), n)
    return contenders


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--photons", type=int, default=4_000_000)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--batch", type=int, default=65_536, help="photons per call")
    options = parser.parse_args()
    announce_photons(10**12)  # compiled from the first photon on

    print(f"{machine()}, {options.photons} photons, batches of {options.batch}")
    with tempfile.TemporaryDirectory() as folder:
        loops = compiled_loops(Path(folder))
        for title, (name, chosen) in SETTINGS.items():
            source = bench_sky(name).scene(options.photons).source(seed=1, **chosen)
            with source.c_source(0) as stream:
                contenders = contenders_of(source, stream, loops, options.photons, options.batch)
                times = in_turns(contenders, options.repeats)
            print(f"\n{title}, median of {options.repeats} turns")
            for host, taken in times.items():
                cost = f"  {host:18s} {statistics.median(taken) / options.photons * 1e9:8.2f} ns"
                if host in BARS:
                    against = ratio(taken, times["batches in Python"])
                    cost += f"   times batches {verdict(against, BARS[host], at_least=False)}"
                print(cost)


if __name__ == "__main__":
    main()
