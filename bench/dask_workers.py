"""Photons per second of `run --engine dask` with one worker and with two, interleaved, in one run.

    python bench/dask_workers.py [--iterations 2e7] [--repeats 3]

Workers are processes of one thread. Beside the whole run (shards, joining, manifest) it prints the shards alone.
Two processes that share nothing reach 1.84 of one on a machine of two virtual cores: that is the limit.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from pathlib import Path

import distributed

import aomc_sky as sky
from aomc_sky.engine import dask_run
from aomc_sky.engine.run import JobOptions

SCENE = Path(__file__).resolve().parent.parent / "inputs" / "clear_day"


class Clock:
    """Moments at which the shards were done and at which the run was."""

    def __init__(self) -> None:
        self.start = time.perf_counter()
        self.shards = 0.0

    def progress(self, done: int, total: int) -> None:
        """Note when the last shard ends; joining reports nothing."""
        if done == total:
            self.shards = time.perf_counter() - self.start


def seconds(iterations: int, address: str) -> tuple[float, float]:
    """Time of the shards and of the whole run."""
    scene = sky.read_scene(SCENE, iterations=iterations)
    source = scene.source(1)
    with tempfile.TemporaryDirectory() as folder:
        clock = Clock()
        result = dask_run.run_on_dask(
            source, scene, Path(folder) / "out", JobOptions(), scheduler=address, progress=clock.progress
        )
        assert result.emitted == source.total
        return clock.shards, time.perf_counter() - clock.start


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
        taken: dict[int, list[tuple[float, float]]] = {1: [], 2: []}
        for repeat in range(arguments.repeats + 1):
            for k, cluster in clusters.items():
                spent = seconds(n, cluster.scheduler_address)
                if repeat:  # the first one loads the kernels
                    taken[k].append(spent)
        for part, name in enumerate(("shards", "whole run")):
            one, two = (statistics.median(spent[part] for spent in taken[k]) for k in (1, 2))
            print(
                f"{name:10s} {3 * n / one / 1e6:6.1f} {3 * n / two / 1e6:6.1f} million photons/s, ratio {one / two:.2f}"
            )
    finally:
        for cluster in clusters.values():
            cluster.close()


if __name__ == "__main__":
    main()
