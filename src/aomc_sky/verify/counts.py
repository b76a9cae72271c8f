"""Tests of photon counts against the masses they come from: for our own counts and for anybody's."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import UsageError, floats, member_of, require_one_of, unmasked
from aomc_sky.kernels.arithmetic.error_free import FIXED_POINT_BITS
from aomc_sky.plan.allocation import AllocationMethod, WalkedGrid, fixed_point_cumulative, normalise, walk_of_cells
from aomc_sky.verify.report import chi_square_tails, pooled, sidak_level, two_sided
from aomc_sky.whole_number import as_index_within

FAMILY_LEVEL = 1e-6
"""Chance that correct counts fail any statistical test of one report."""

MIN_EXPECTED = 20.0
"""Cells are pooled until each group expects so many photons."""

MAX_COUNT = 2**62
_ROUNDING = 2.0**-52
"""Rounding of masses that were divided by their sum, relative to the mass of a cell or a run."""

_UNIT = 2.0**-62
"""In fixed point, a cell or a run of cells is within one unit of its exact share."""


@dataclass(frozen=True, kw_only=True, slots=True)
class CountCheck:
    """One check of one band."""

    band: int  #: [0-based]
    name: str
    passed: bool
    found: float  #: the statistic, or its p-value
    allowed: float  #: the bound, or the level
    cell: int | None = None  #: the worst cell


@dataclass(frozen=True, kw_only=True, slots=True)
class CountsReport:
    """The outcome of `verify_counts`."""

    checks: tuple[CountCheck, ...]

    @property
    def passed(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)

    def __bool__(self) -> bool:
        return self.passed


CheckedWord = Literal["systematic", "largest-remainder", "multinomial"]
"""Allocations whose counts follow from the masses by a law; those of AOMC are compared with the program's."""


def verify_counts(
    counts: ArrayLike,
    mass: ArrayLike,
    *,
    method: AllocationMethod | CheckedWord = AllocationMethod.SYSTEMATIC,
    n_photons: ArrayLike | None = None,
    n_columns: int | None = None,
) -> CountsReport:
    """Check photon counts against the masses they were shared out over.

    Parameters
    ----------
    counts : array_like, int, shape (n_cell,) or (n_band, n_cell)
        Photons of each cell. [>= 0]
    mass : array_like, shape of `counts`, or (n_cell,) for all bands
        Masses of any scale. [>= 0]
    method : {"systematic", "largest-remainder", "multinomial"}
        How the photons were shared out. Those of the AOMC program equal ``allocate(mass, n, method="aomc")``.
    n_photons : int or array_like of int, shape (n_band,), optional
        Photons that were requested; where given, the sums are compared with it.
    n_columns : int, optional
        Columns of the grid whose patches the cells are, ring by ring from overhead. Systematic counts of a scene walk
        through each ring from a column of its own (`Scene.source`), and runs of cells are checked in that order.
        None: in the order of the cells, as `allocate` shares photons out. [1 or more, a divisor of n_cell]

    Returns
    -------
    CountsReport
        True in a condition if every check passed. Zero masses must have zero counts. Systematic and largest
        remainder: |count - N p| < 1 + N 2^-52 p + N 2^-62, in rational arithmetic where float64 cannot decide.
        Systematic also: every contiguous run of cells (with `n_columns`: of the walk, so also every run of whole
        rings) within 1 + N 2^-52 + N 2^-62 photons. The second term is the rounding of masses that were divided by
        their sum in float64, 0.2 photons at 1e15; the third is a unit of the fixed point. Multinomial: two-sided
        chi-square, cells pooled to an expectation of at least 20, at a level at which the whole report fails correct
        counts with a chance of 1e-6 (Sidak).

    Raises
    ------
    ValueError
        Shapes do not fit, counts are not whole numbers from 0, or masses are negative or not finite.
    UsageError
        An unknown method.

    Examples
    --------
    >>> mass = [0.5, 0.3, 0.2]
    >>> (
    ...     bool(sky.verify_counts(sky.allocate(mass, 1000), mass)),
    ...     bool(sky.verify_counts([510, 290, 200], mass)),
    ... )
    (True, False)
    """
    chosen = member_of(AllocationMethod, method, "method")
    require_one_of(get_args(CheckedWord), chosen.value, "method")
    photons = _checked_counts(unmasked("counts", counts))
    masses = np.atleast_2d(floats("mass", mass))
    if not np.all(np.isfinite(masses)) or np.any(masses < 0):
        raise UsageError("masses must be finite and not negative")
    bands = np.atleast_2d(photons)
    if bands.size == 0 or bands.ndim != 2 or masses.shape not in (bands.shape, (1, bands.shape[1])):
        raise UsageError(f"counts {photons.shape} and mass {np.shape(mass)} do not fit")
    requested = None if n_photons is None else np.broadcast_to(np.asarray(n_photons), bands.shape[:1])
    rings: tuple[WalkedGrid, ...] = ()
    if n_columns is not None:
        n_cells, n_columns = bands.shape[1], as_index_within(n_columns, "n_columns", 1, bands.shape[1])
        if n_cells % n_columns:
            raise UsageError(f"{n_cells} cells are no whole number of rings of {n_columns} columns")
        rings = (WalkedGrid(first_cell=0, n_rings=n_cells // n_columns, n_columns=n_columns),)
    level = sidak_level(FAMILY_LEVEL, bands.shape[0])
    checks: list[CountCheck] = []
    for band, row in enumerate(bands):
        if requested is not None:
            found, n = int(row.sum()), int(requested[band])
            checks.append(CountCheck(band=band, name="sum of the counts", passed=found == n, found=found, allowed=n))
        checks += _band_checks(band, row, masses[band if len(masses) > 1 else 0], chosen, level, rings)
    return CountsReport(checks=tuple(checks))


def _checked_counts(counts: ArrayLike) -> np.ndarray:
    photons = np.asarray(counts)
    if photons.dtype.kind not in "iuf":
        raise UsageError(f"counts must be whole numbers, got an array of {photons.dtype}")
    if photons.dtype.kind == "f" and not np.all(np.isfinite(photons) & (photons == np.rint(photons))):
        raise UsageError("counts must be whole numbers")
    if np.any(photons < 0):
        raise UsageError("counts must not be negative")
    if photons.size and photons.max() > MAX_COUNT:
        raise UsageError(f"counts must not exceed 2^62, got {photons.max()}")
    return photons.astype(np.int64)


def _band_checks(
    band: int,
    counts: np.ndarray,
    mass: np.ndarray,
    method: AllocationMethod,
    level: float,
    rings: tuple[WalkedGrid, ...],
) -> list[CountCheck]:
    wrong = np.where(mass == 0, counts, 0)
    worst = int(wrong.argmax())
    found, cell = float(wrong[worst]), worst if wrong[worst] else None
    checks = [
        CountCheck(band=band, name="zero mass, no photon", passed=found == 0, found=found, allowed=0.0, cell=cell)
    ]
    if not mass.max() > 0:  # a dark band: nothing else to compare with
        return checks
    p = normalise(mass)
    if method is AllocationMethod.MULTINOMIAL:
        return [*checks, _chi_square_check(band, counts, p, level)]
    checks.append(_cell_check(band, counts, p, mass))
    if method is AllocationMethod.SYSTEMATIC:
        checks.append(_run_check(band, counts, p, mass, rings))
    return checks


def _cell_check(band: int, counts: np.ndarray, p: np.ndarray, mass: np.ndarray) -> CountCheck:
    n = int(counts.sum())
    expected = n * p
    allowed = 1.0 + expected * _ROUNDING + n * _UNIT
    ratio = np.abs(counts - expected) / allowed
    worst = int(ratio.argmax())
    # float64 decides, except if a ratio is within its own error of 1; this error grows with the counts
    doubtful = np.flatnonzero(ratio >= 1.0 - 1e-9 - expected * 8 * _ROUNDING)
    failed = bool(doubtful.size) and _exactly_outside(counts, mass, n, doubtful[np.argsort(-ratio[doubtful])])
    return CountCheck(
        band=band,
        name="each cell within one photon",
        passed=not failed,
        found=float(np.abs(counts - expected)[worst]),
        allowed=float(allowed[worst]),
        cell=worst,
    )


def _exactly_outside(counts: np.ndarray, mass: np.ndarray, n: int, cells: np.ndarray) -> bool:
    """Whether any cell differs from both the mass and its 62-bit fixed point, in rational arithmetic."""
    total = sum((Fraction(float(m)) for m in mass), Fraction(0))
    fixed = np.diff(fixed_point_cumulative(mass))
    for cell in cells.tolist():
        expected = n * Fraction(float(mass[cell])) / total
        off_mass = abs(int(counts[cell]) - expected) >= 1 + expected / 2**52 + Fraction(n, 2**62)
        off_fixed = abs(int(counts[cell]) * 2**FIXED_POINT_BITS - n * int(fixed[cell])) >= 2**FIXED_POINT_BITS
        if off_mass and off_fixed:
            return True
    return False


def _run_check(
    band: int, counts: np.ndarray, p: np.ndarray, mass: np.ndarray, rings: tuple[WalkedGrid, ...]
) -> CountCheck:
    """Largest deviation over all runs in the order of the walk: the spread of the running difference."""
    n = int(counts.sum())
    order = walk_of_cells(fixed_point_cumulative(mass), n, rings) if rings else np.arange(mass.size)
    counts, p, mass = counts[order], p[order], mass[order]
    difference = np.cumsum(counts - n * p)
    spread = float(difference.max(initial=0.0) - difference.min(initial=0.0))
    # float64 decides if the spread is far below 1; otherwise integers do
    passed = spread < 1 - n * _ROUNDING * 4 - 1e-9 or _spread(counts, _integer_masses(mass)) < 1 + n * (
        Fraction(1, 2**52) + Fraction(1, 2**62)
    )
    return CountCheck(
        band=band,
        name="each run of the walk within one photon" if rings else "each contiguous run within one photon",
        passed=passed,
        found=spread,
        allowed=1.0 + n * (_ROUNDING + _UNIT),
        cell=int(order[np.abs(difference).argmax()]),
    )


def _integer_masses(mass: np.ndarray) -> list[int]:
    """The float masses as whole numbers of a common power of two, exactly."""
    ratios = [float(m).as_integer_ratio() for m in mass]
    finest = max(denominator for _, denominator in ratios)
    return [numerator * (finest // denominator) for numerator, denominator in ratios]


def _spread(counts: np.ndarray, units: list[int]) -> Fraction:
    """Spread of the running difference of counts and N p, p = units / sum, exactly. [photons]"""
    n, total = int(counts.sum()), sum(units)
    running = low = high = 0
    for count, unit in zip(counts.tolist(), units, strict=True):
        running += count * total - n * unit
        low, high = min(low, running), max(high, running)
    return Fraction(high - low, total)


def _chi_square_check(band: int, counts: np.ndarray, p: np.ndarray, level: float) -> CountCheck:
    """Two-sided: too even counts are as wrong as too uneven ones."""
    n = int(counts.sum())
    observed, expected = pooled(counts, n * p, MIN_EXPECTED)
    degrees = expected.size - 1
    if degrees < 1:  # one group holds all photons
        return CountCheck(band=band, name="chi-square (too few photons)", passed=True, found=1.0, allowed=level)
    pull = (observed - expected) / np.sqrt(expected)
    p_value = two_sided(*chi_square_tails(float(pull @ pull), degrees))
    name = f"chi-square, {degrees} degrees of freedom"
    return CountCheck(band=band, name=name, passed=p_value >= level, found=p_value, allowed=level)
