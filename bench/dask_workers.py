"""Photons per second of `run --engine dask` with one worker and with two, interleaved, in one run.

    python bench/dask_workers.py [--iterations 2e7] [--repeats 3]

Workers are processes of one thread. Times are those of whole runs: photons, hashes of the files, counts, manifest.
What two processes that share nothing make, each a run of its own, is the limit of the machine.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from pathlib import Path

import distributed

import aomc_sky as sky
from aomc_sky.engine.cluster import run_on_dask
from aomc_sky.engine.run import JobOptions, run_job

SCENE = Path(__file__).resolve().parent.parent / "inputs" / "clear_day"


def seconds(iterations: int, address: str) -> float:
    """Time of a run by the workers of a cluster."""
    scene = sky.read_scene(SCENE, iterations=iterations)
    source = scene.source(1)
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        result = run_on_dask(source, scene, Path(folder) / "out", JobOptions(), scheduler=address)
        assert result.emitted == source.total
        return time.perf_counter() - start


def seconds_alone(iterations: int) -> float:
    """Time of the whole run by one thread of this process."""
    scene = sky.read_scene(SCENE, iterations=iterations)
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        run_job(scene.source(1), scene, Path(folder) / "out", JobOptions(threads=1))
        return time.perf_counter() - start


def seconds_of_processes(iterations: int, cluster: distributed.LocalCluster) -> tuple[float, float]:
    """Time of the run by one thread of one worker, and of two such runs by two workers at once."""
    with distributed.Client(cluster) as client:
        workers = list(client.nthreads())
        one = client.submit(seconds_alone, iterations, workers=workers[:1], pure=False).result()
        both = [client.submit(seconds_alone, iterations, workers=[worker], pure=False) for worker in workers]
        return one, max(client.gather(both))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--iterations", type=float, default=2e7, help="photons of each of three wavebands")
    parser.add_argument("--repeats", type=int, default=3)
    arguments = parser.parse_args()
    n = int(arguments.iterations)
    clusters = {
        k: distributed.LocalCluster(n_workers=k, threads_per_worker=1, dashboard_address=None, silence_logs=50)
        for k in (1, 2)
    }
    try:
        by_workers: dict[int, list[float]] = {1: [], 2: []}
        alone: list[tuple[float, float]] = []
        for _ in range(arguments.repeats + 1):
            for k, cluster in clusters.items():
                by_workers[k].append(seconds(n, cluster.scheduler_address))
            alone.append(seconds_of_processes(n, clusters[2]))
        one, two = (statistics.median(by_workers[k][1:]) for k in (1, 2))  # the first loads the kernels
        single, both = (statistics.median(pair[k] for pair in alone[1:]) for k in (0, 1))
        print(f"{3 * n / single / 1e6:6.1f} million photons/s by one thread, without Dask")
        print(f"{6 * n / both / 1e6:6.1f} by two processes that share nothing, {2 * single / both:.2f} times as many")
        print(f"{3 * n / one / 1e6:6.1f} by one worker")
        print(f"{3 * n / two / 1e6:6.1f} by two workers, {one / two:.2f} times as many as by one")
    finally:
        for cluster in clusters.values():
            cluster.close()


if __name__ == "__main__":
    main()
