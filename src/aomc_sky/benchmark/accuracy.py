"""Errors of the samplers over replicates, and what they cost: the rows of the benchmark's table."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from aomc_sky.benchmark.methods import BenchMethod
from aomc_sky.benchmark.quantities import QUANTITIES, Tally, Values
from aomc_sky.benchmark.skies import BenchSky
from aomc_sky.benchmark.timing import in_turns
from aomc_sky.outputs.blocks.blocks import n_cpus
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import PhotonBatch

BATCH = 65_536
"""Photons per call, into the same buffers."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Row:
    """One method on one sky at one number of photons."""

    #: sky, method: Names.
    sky: str
    method: str
    #: Photons asked for.
    n_photons: int
    #: Independent runs behind the errors; 0 where only time was taken.
    replicates: int = 0
    #: plan_s, emit_s: Median time to settle the counts and to emit all photons into reused buffers, one thread. [s]
    plan_s: float = math.nan
    emit_s: float = math.nan
    #: Relative root mean square error of each quantity over the replicates; of scalar irradiance the median of the
    #: absolute error.
    error: dict[str, float] = field(default_factory=dict)
    #: Mean of the signed relative error; absent for the histogram.
    bias: dict[str, float] = field(default_factory=dict)

    @property
    def seconds(self) -> float:
        """Plan and photons. [s]"""
        return self.plan_s + self.emit_s

    @property
    def ns_per_photon(self) -> float:
        """Emission alone. [ns]"""
        return 1e9 * self.emit_s / self.n_photons


def error_of(values: Iterable[Values], truth: Values) -> tuple[dict[str, float], dict[str, float]]:
    """Relative RMSE and mean signed error of every quantity over replicates.

    Of `scalar` the median absolute error, for the mean of 1/mu has no variance; the histogram has no bias.
    """
    found = list(values)
    error, bias = {}, {}
    for quantity in QUANTITIES:
        each = np.array([value.relative_error(truth, quantity) for value in found])
        is_heavy = quantity == "scalar"
        error[quantity] = float(np.median(np.abs(each)) if is_heavy else np.sqrt(np.mean(each**2)))
        if quantity != "histogram":
            bias[quantity] = float(np.mean(each))
    return error, bias


def source_of(sky: BenchSky, method: BenchMethod, n_photons: int, *, seed: int, precision: str) -> PhotonSource:
    """The source of a method, its counts settled."""
    scene = sky.scene(n_photons, as_table=method.needs_table)
    options: dict[str, Any] = dict(method.options)
    return scene.source(seed=seed, precision=precision, **options)


def buffer_of(source: PhotonSource) -> PhotonBatch:
    """Buffers for batches of a source, touched once."""
    return source.photons(0, 0, min(BATCH, source.n_photons(0)))


def drain(source: PhotonSource, out: PhotonBatch) -> None:
    """Emit all photons of a source into the same buffers."""
    for _ in source.batches(0, BATCH, out=out):
        pass


def tallied(source: PhotonSource) -> Values:
    """The quantities of all photons of a source."""
    sums = Tally()
    for batch in source.batches(0, BATCH, out=buffer_of(source)):
        sums.add_batch(batch)
    return sums.values()


def _run(sky: BenchSky, method: BenchMethod, n_photons: int, precision: str, seed: int) -> Values:
    """The quantities of one replicate."""
    return tallied(source_of(sky, method, n_photons, seed=seed, precision=precision))


def measure_errors(
    sky: BenchSky, methods: list[BenchMethod], n_photons: int, *, replicates: int, seed: int, precision: str
) -> list[Row]:
    """Rows without times: errors over replicates with seeds `seed`, `seed` + 1 ...; a method without randomness runs
    once.

    Replicates run on all processors; the numbers do not depend on how many there are.
    """
    rows: dict[str, Row] = {}
    for method in methods:
        n_runs = replicates if method.is_random else 1
        twin = rows.get(method.same_photons_as)
        if twin is not None:
            rows[method.name] = replace(twin, method=method.name)
            continue
        run = partial(_run, sky, method, n_photons, precision)
        with ThreadPoolExecutor(n_cpus(), thread_name_prefix="aomc-sky-bench") as pool:
            error, bias = error_of(pool.map(run, range(seed, seed + n_runs)), sky.truth.values)
        rows[method.name] = Row(
            sky=sky.name, method=method.name, n_photons=n_photons, replicates=n_runs, error=error, bias=bias
        )
    return list(rows.values())


def measure_times(
    sky: BenchSky, rows: list[Row], methods: list[BenchMethod], *, turns: int, seed: int, precision: str
) -> list[Row]:
    """The rows of one sky and one number of photons, one per method, with their times, taken in turns after a first
    one.
    """
    contenders: dict[str, Callable[[], object]] = {}
    for row, method in zip(rows, methods, strict=True):
        plan = partial(source_of, sky, method, row.n_photons, seed=seed, precision=precision)
        source = plan()
        contenders[f"{method.name} plan"] = plan
        contenders[f"{method.name} emit"] = partial(drain, source, buffer_of(source))
    times = in_turns(contenders, turns)
    return [
        replace(
            row,
            plan_s=statistics.median(times[f"{row.method} plan"]),
            emit_s=statistics.median(times[f"{row.method} emit"]),
        )
        for row in rows
    ]
