"""Errors of the samplers over replicates, what they cost, and what that says of more photons: the rows of the table."""

from __future__ import annotations

import enum
import math
import statistics
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.system import n_cpus
from bench.harness import in_turns
from bench.quantities import QUANTITIES, Tally, Values
from bench.samplers import BATCH, BenchMethod, buffer_of, drain, source_of
from bench.skies import BenchSky


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


def tallied(source: PhotonSource) -> Values:
    """The quantities of all photons of a source."""
    sums = Tally()
    for batch in source.batches(0, BATCH, out=buffer_of(source)):
        sums.add_batch(batch)
    return sums.values()


def _run(sky: BenchSky, method: BenchMethod, n_photons: int, seed: int) -> Values:
    """The quantities of one replicate."""
    return tallied(source_of(sky, method, n_photons, seed=seed))


def measure_errors(
    sky: BenchSky, methods: list[BenchMethod], n_photons: int, *, replicates: int, seed: int = 1
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
        run = partial(_run, sky, method, n_photons)
        with ThreadPoolExecutor(n_cpus(), thread_name_prefix="aomc-sky-bench") as pool:
            error, bias = error_of(pool.map(run, range(seed, seed + n_runs)), sky.truth.values)
        rows[method.name] = Row(
            sky=sky.name, method=method.name, n_photons=n_photons, replicates=n_runs, error=error, bias=bias
        )
    return list(rows.values())


def measure_times(sky: BenchSky, rows: list[Row], methods: list[BenchMethod], *, turns: int) -> list[Row]:
    """The rows of one sky and one number of photons, one per method, with their times, taken in turns after a first
    one.
    """
    contenders: dict[str, Callable[[], object]] = {}
    for row, method in zip(rows, methods, strict=True):
        plan = partial(source_of, sky, method, row.n_photons, seed=1)
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


TARGETS = (1e-2, 1e-4)
"""Relative errors whose time is given: 1 % and 0.01 %."""
FLAT = -0.2
"""Where the last slope is above this, the error has met a floor: more photons do not help."""
BIASED = 0.9
"""Share of the error that is bias from which on the slope of the last two runs alone shows a floor; chance has none."""
WITHOUT_TREND = ("scalar",)
"""The mean of 1/mu has no variance: its median error has no slope and promises nothing for more photons."""
_LAST = 3
"""Numbers of photons behind an extrapolation."""


class Found(enum.Enum):
    """How the time to an error is known."""

    BETWEEN = "interpolated"
    AT_MOST = "at most"
    BEYOND = "extrapolated"
    NEVER = "never"


@dataclass(frozen=True, kw_only=True, slots=True)
class Reach:
    """What an error costs."""

    #: Relative error.
    target: float
    #: photons, seconds: Photons and time, plan included; infinite where the error has a floor above the target.
    photons: float
    seconds: float
    #: Between two measured runs; the smallest run does it; beyond the largest run; or never.
    found: Found


@dataclass(frozen=True, kw_only=True, slots=True)
class Trend:
    """One quantity of one method on one sky over all numbers of photons."""

    #: sky, method, quantity: Names.
    sky: str
    method: str
    quantity: str
    #: Of log error against log photons, least squares; NaN where an error is 0.
    slope: float
    #: One per target.
    reach: tuple[Reach, ...]


def trends(rows: list[Row]) -> list[Trend]:
    """Trends of every sky, method and quantity that has errors at two numbers of photons or more."""
    found = []
    for sky, method in dict.fromkeys((row.sky, row.method) for row in rows):
        own = [row for row in rows if (row.sky, row.method) == (sky, method) and row.error]
        own.sort(key=lambda row: row.n_photons)
        if len(own) >= 2:
            found += [_trend(own, quantity) for quantity in QUANTITIES if quantity not in WITHOUT_TREND]
    return found


def _trend(rows: list[Row], quantity: str) -> Trend:
    n = np.array([row.n_photons for row in rows], dtype=np.float64)
    error = np.array([row.error[quantity] for row in rows])
    return Trend(
        sky=rows[0].sky,
        method=rows[0].method,
        quantity=quantity,
        slope=slope_of(n, error),
        reach=tuple(_reach(target, n, error, rows, quantity) for target in TARGETS),
    )


def slope_of(n_photons: np.ndarray, error: np.ndarray) -> float:
    """Least-squares slope of log error against log photons; NaN where an error is 0."""
    if np.any(error <= 0):
        return math.nan
    return float(np.polyfit(np.log(n_photons), np.log(error), 1)[0])


def _reach(target: float, n: np.ndarray, error: np.ndarray, rows: list[Row], quantity: str) -> Reach:
    """Where the error falls below a target for good."""
    above = np.flatnonzero(error > target)
    if above.size == 0:
        return Reach(target=target, photons=float(n[0]), seconds=rows[0].seconds, found=Found.AT_MOST)
    k = int(above[-1])
    if k + 1 < n.size:
        share = math.log(error[k] / target) / math.log(error[k] / max(error[k + 1], 1e-300))
        photons = float(n[k] * (n[k + 1] / n[k]) ** share)
        between = float(np.interp(photons, n, [row.seconds for row in rows]))
        return Reach(target=target, photons=photons, seconds=between, found=Found.BETWEEN)
    slope = slope_of(n[-_LAST:], error[-_LAST:])
    is_flat = slope_of(n[-2:], error[-2:]) > FLAT and abs(rows[-1].bias.get(quantity, 0.0)) > BIASED * error[-1]
    if is_flat or not slope <= FLAT:
        return Reach(target=target, photons=math.inf, seconds=math.inf, found=Found.NEVER)
    photons = float(n[-1] * (target / error[-1]) ** (1.0 / slope))
    more = rows[-1].seconds + (photons - n[-1]) * rows[-1].emit_s / n[-1]
    return Reach(target=target, photons=photons, seconds=more, found=Found.BEYOND)
