"""What the rows say together: convergence slopes, and the time until an error is reached."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

import numpy as np

from aomc_sky.benchmark.accuracy import Row
from aomc_sky.benchmark.quantities import QUANTITIES

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
