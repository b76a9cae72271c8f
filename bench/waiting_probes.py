"""What one process of `waiting.py` measures: it is called with the name of a function, and prints its figures as JSON.

Times of photons are processor times of the calling thread, the least of a few turns inside the process, for what
disturbs them only adds; peers take turns with ours in a process of their own.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(1, str(Path(__file__).resolve().parents[1]))

INPUTS = Path(__file__).resolve().parents[1] / "inputs"
N_WAVELENGTHS, N_ZENITH, N_AZIMUTH = 20, 90, 360
BATCH = 65_536
N_PHOTONS = 2_000_000
REPEATS = 5


def first_kernels(kind: str) -> dict[str, float]:
    """Seconds from a scene to its first compiled photons, numba itself loaded before."""
    import numba  # noqa: F401

    import aomc_sky as sky
    from aomc_sky.kernels.backend import announce_photons

    start = time.process_time()
    scene = sky.read_scene(INPUTS / ("perez_sky" if kind == "perez" else "clear_day") / "amc.inp", iterations=10**6)
    source = scene.source()
    if kind == "host":
        source.numba_sampler(0).fill(0, np.empty((3, BATCH), np.float32))
    else:
        announce_photons(10**9)
        source.photons(0, 0, BATCH)
    return {"": time.process_time() - start}


def stored_bytes(n_bytes: str, folder: str) -> dict[str, float]:
    """numpy.save of so many bytes, and one SHA-256 of them."""
    piece = np.random.default_rng(1).random((int(n_bytes) // 4,), dtype=np.float32)
    start = time.process_time()
    np.save(Path(folder) / "stored.npy", piece)
    saved = time.process_time() - start
    (Path(folder) / "stored.npy").unlink()
    return {"numpy.save": saved, **hashed(n_bytes)}


def hashed(n_bytes: str) -> dict[str, float]:
    """One SHA-256 of so many bytes that are in the cache."""
    import hashlib

    piece, digest, left = bytes(BATCH * 12), hashlib.sha256(), int(n_bytes)
    start = time.process_time()
    while left > 0:
        digest.update(piece)
        left -= len(piece)
    return {"one SHA-256": time.process_time() - start}


def write_fine_table(folder: Path) -> None:
    """A scene whose sky file has 20 wavelengths x 32 400 patches, values of five digits."""
    from inputs.make_scenes import amc, lambbot, skydist

    values = np.random.default_rng(1).lognormal(size=(N_WAVELENGTHS, N_ZENITH, N_AZIMUTH))
    wavelengths = [400.0 + 15 * k for k in range(N_WAVELENGTHS)]
    (folder / "amc.inp").write_text(amc(10**6, flag=1, n_wavebands=N_WAVELENGTHS, zenith=35))
    (folder / "lambbot.inp").write_text(lambbot(wavelengths))
    (folder / "skydist.inp").write_text(skydist(wavelengths, values))


def shared_out(folder: str) -> dict[str, float]:
    """Reading a scene, and settling its counts."""
    import aomc_sky as sky

    sky.read_scene(INPUTS / "sparse_sky" / "amc.inp").source()
    start = time.process_time()
    scene = sky.read_scene(Path(folder) / "amc.inp")
    read = time.process_time()
    scene.source()
    return {"read": read - start, "share out": time.process_time() - read}


def other_readers(path: str) -> dict[str, float]:
    """numpy.loadtxt, and a loop of list-directed reads of gfortran where it is installed."""
    start = time.process_time()
    np.loadtxt(path, skiprows=2)
    times = {"numpy.loadtxt": time.process_time() - start}
    compiler = shutil.which("gfortran")
    if compiler is None:
        return times
    with tempfile.TemporaryDirectory() as folder:
        program = str(Path(folder) / "read")
        text = str(Path(__file__).with_name("read_skydist.f90"))
        subprocess.run([compiler, "-O2", "-o", program, text], check=True, cwd=folder)
        before = os.times()
        subprocess.run([program, path], check=True, stdout=subprocess.DEVNULL)
        after = os.times()
    times["gfortran read"] = sum(after[2:4]) - sum(before[2:4])
    return times


def photons(order: str) -> dict[str, float]:
    """A table of 90 x 360 patches."""
    return {"": least({"": drained(_table_source(order=order))})[""]}


def others(order: str) -> dict[str, float]:
    """Peers for the same table, and stores of 12 bytes."""
    from aomc_sky.benchmark.samplers import CHOICE
    from aomc_sky.benchmark.skies import bench_sky
    from bench.peers import MITSUBA, MULTINOMIAL, StoreLimit, peers_of_table

    sky = bench_sky("clear-uniform")
    peers, _ = peers_of_table(sky.grid, sky.mass)
    wanted = (CHOICE, MITSUBA) if order == "shuffled" else (MULTINOMIAL,)
    contenders: dict[str, Callable[[], object]] = {
        name: partial(peers[name], N_PHOTONS) for name in wanted if name in peers
    }
    stores = StoreLimit(BATCH, 12)
    contenders["12-byte stores"] = partial(stores, N_PHOTONS)
    return least(contenders)


def large_tables() -> dict[str, float]:
    """Tables larger than the cache."""
    contenders = {}
    for name, shape in (("1e6", (1000, 1000)), ("4e6", (2000, 2000))):
        contenders[name] = drained(_large_source(*shape))
    return least(contenders)


def session() -> dict[str, float]:
    """The same photons five times, nothing announced."""
    import aomc_sky as sky

    n = 3_000_000
    source = sky.read_scene(INPUTS / "clear_day" / "amc.inp", iterations=n).source()
    times = {}
    for draw in ("1st", "2nd", "3rd", "4th", "5th"):
        start = time.process_time()
        for _ in source.batches(0, BATCH):
            pass
        times[draw] = (time.process_time() - start) / n * 1e9
    return times


def host() -> dict[str, float]:
    """A jitted loop that asks for one photon after the other, beside batches."""
    from aomc_sky.kernels.hosts.sampler import make_loop

    source = _table_source()
    loop = make_loop(source.numba_sampler(0).sample)
    return least({"sample(i)": lambda: loop(N_PHOTONS), "batches": drained(source)})


def two_threads() -> dict[str, float]:
    """Wall-clock ratios of two threads, and of two processes that share nothing, to one thread."""
    from aomc_sky.kernels.backend import announce_photons
    from bench.threads import ONE, TWO_PROCESSES, TWO_THREADS, thread_times

    announce_photons(10**12)
    from aomc_sky.benchmark.timing import ratio

    times = thread_times(_table_source(n=10_000_000), 9)
    return {
        "threads": ratio(times[ONE], times[TWO_THREADS]),
        "processes": 2 * ratio(times[ONE], times[TWO_PROCESSES]),
    }


def perez_over_uniform() -> dict[str, float]:
    """Perez's law inside every patch over the same sky constant in its patches."""
    from aomc_sky.benchmark.samplers import speed_source
    from aomc_sky.benchmark.skies import bench_sky

    times = least(
        {
            name: drained(speed_source(bench_sky(sky), "default", N_PHOTONS))
            for name, sky in (("exact", "clear"), ("uniform", "clear-uniform"))
        }
    )
    return {"": times["exact"] / times["uniform"]}


def _table_source(order: str = "shuffled", n: int = N_PHOTONS) -> Any:
    from aomc_sky.benchmark.samplers import speed_source
    from aomc_sky.benchmark.skies import bench_sky

    return speed_source(bench_sky("clear-uniform"), "default" if order == "shuffled" else "patch-order", n)


def _large_source(n_zenith: int, n_azimuth: int) -> Any:
    import aomc_sky as sky

    values = np.random.default_rng(1).lognormal(size=(1, n_zenith, n_azimuth))
    table = sky.TabulatedSky(
        wavelength_nm=np.array([550.0]), values=values, grid=sky.PatchGrid.regular(n_zenith, n_azimuth)
    )
    # several photons a patch, as users of so many patches launch; a part of them is timed
    scene: Any = sky.Scene  # lists and single components are welcome
    return scene(wavebands=[550.0], n_photons=4 * values.size, components=table).source(seed=1)


def drained(source: Any) -> Callable[[], object]:
    """The first photons of a source by compiled kernels, batch by batch into the same buffers."""
    from aomc_sky.kernels.backend import announce_photons

    announce_photons(10**12)
    buffer = source.photons(0, 0, BATCH)

    def work() -> None:
        for start in range(0, N_PHOTONS, BATCH):
            source.photons(0, start, min(start + BATCH, N_PHOTONS), out=buffer)

    return work


def least(contenders: Mapping[str, Callable[[], object]]) -> dict[str, float]:
    """Nanoseconds a photon of each, turn about. [ns]"""
    from bench.harness import best_cpu_time

    return {name: taken / N_PHOTONS * 1e9 for name, taken in best_cpu_time(contenders, REPEATS).items()}


PROBES: dict[str, Callable[..., dict[str, float]]] = {
    probe.__name__: probe
    for probe in (
        first_kernels,
        stored_bytes,
        hashed,
        shared_out,
        other_readers,
        photons,
        others,
        large_tables,
        session,
        host,
        two_threads,
        perez_over_uniform,
    )
}

if __name__ == "__main__":
    print(json.dumps(PROBES[sys.argv[1]](*sys.argv[2:])))
