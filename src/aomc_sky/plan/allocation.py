"""Masses of any scale as probabilities, and photons shared out over them in integers: the counts of a plan."""

from __future__ import annotations

import enum
import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component
from aomc_sky.errors import AllocationError, InputWarning, UsageError, floats, member_of
from aomc_sky.float_mode import in_default_mode
from aomc_sky.kernels.arithmetic import rng
from aomc_sky.kernels.arithmetic.error_free import (
    FIXED_POINT_BITS,
    exact_sum,
    product_over_2_62,
    rounded_cumulative,
)
from aomc_sky.plan.streams import ALLOCATION, checked_seed, stream_key
from aomc_sky.whole_number import as_number_of

MAX_PHOTONS = 2**62
MAX_MULTINOMIAL = 2**53


AllocationWord = Literal["systematic", "largest-remainder", "multinomial", "aomc"]


class AllocationMethod(enum.Enum):
    """How integers are shared out.

    SYSTEMATIC
        One uniform offset per band: every count is the floor or the ceiling of N p, and its mean is exactly N p. Any
        contiguous run of cells is within one photon. In a scene, the rings of a grid begin at columns of their own
        (`walk_of_cells`). Runs of whole rings, and runs in the order of that walk, are then within one
        photon, and other runs of cells within three.
    LARGEST_REMAINDER
        No randomness: floors, and one more for the largest remainders. Biased where photons are
        fewer than cells.
    MULTINOMIAL
        Independent photons: conditional binomials from counters of their own.
    AOMC
        The AOMC 1.2.2 program's float32 rounding, which loses or gains photons.

    Examples
    --------
    >>> sky.allocate(
    ...     [0.5, 0.3, 0.2],
    ...     7,
    ...     method=sky.plan.allocation.AllocationMethod.LARGEST_REMAINDER,
    ... )
    array([4, 2, 1])
    """

    SYSTEMATIC = "systematic"
    LARGEST_REMAINDER = "largest-remainder"
    MULTINOMIAL = "multinomial"
    AOMC = "aomc"


_FAMILY = {AllocationMethod.SYSTEMATIC: "stratified", AllocationMethod.MULTINOMIAL: "iid"}
"""The method of photons whose counts these are, unless a run says otherwise: it is part of the key."""


def checked_photons(n_photons: object, method: AllocationMethod) -> int:
    """A number of photons that a method can share out, as a Python integer, else an AllocationError."""
    limit = MAX_MULTINOMIAL if method is AllocationMethod.MULTINOMIAL else MAX_PHOTONS
    name = f"the number of photons of {method.value} allocation"
    return as_number_of(n_photons, name, 0, limit, error=AllocationError)


def _checked(mass: ArrayLike) -> np.ndarray:
    values = np.ascontiguousarray(np.asarray(mass, dtype=np.float64).ravel())
    if values.size == 0:
        raise AllocationError("there are no cells to share photons over")
    if not (values.min() >= 0 and values.max() < math.inf):
        first = int(np.flatnonzero(~(np.isfinite(values) & (values >= 0)))[0])
        raise AllocationError(f"masses must be finite and not negative, cell {first} has {values[first]}")
    if not values.max() > 0:
        raise AllocationError("all masses are zero, so there is nothing to share photons over")
    return values


def normalise(mass: ArrayLike) -> np.ndarray:
    """Divide masses by their sum: (n_cell,), relative errors at most 2^-52 where the result is a normal number.

    One array may hold masses from 5e-324 to 1.8e308. AllocationError where none is positive, or one is negative or not
    finite.
    """
    values = _checked(mass)
    scaled = np.ldexp(values, -int(np.frexp(values.max())[1]))  # the largest lies in [1/2, 1)
    return scaled / exact_sum(scaled)


def fixed_point_cumulative(mass: ArrayLike) -> np.ndarray:
    """Exact cumulative of the masses over their sum, in units of 2^-62: uint64 (n_cell + 1,), 0 to 2^62.

    Each entry is rounded to the nearest unit. Every cell, and every run of neighbouring cells, is therefore within one
    unit of 2^62 times its exact share. A cell of zero mass has zero units; a positive cell below one unit may have
    zero, too. Masses and errors are those of `normalise`.
    """
    return rounded_cumulative(_checked(mass))


@in_default_mode
def allocate(
    mass: ArrayLike,
    n_photons: int,
    *,
    method: AllocationMethod | AllocationWord = AllocationMethod.SYSTEMATIC,
    seed: int = 0,
) -> np.ndarray:
    """Share photons out over masses.

    Parameters
    ----------
    mass : array_like
        Non-negative masses of any shape and scale; normalised inside. For ``"aomc"`` a table
        (n_zenith, n_azimuth) of the program's weights. [>= 0]
    n_photons : int
        Photons to share out. [0 to 2^62; multinomial 0 to 2^53]
    method : {"systematic", "largest-remainder", "multinomial", "aomc"}
        See `AllocationMethod`.
    seed : int
        Seed of the offset or the draws; of no effect where there is no randomness.

    Returns
    -------
    ndarray, int64, shape of `mass`
        Sum exactly `n_photons`, except for ``"aomc"``. With p the fixed-point probability,
        |count - N p| < 1 for systematic and largest remainder, and for any run of cells by systematic; against the
        exact ratio of the masses add N 2^-62, 0.22 at 1e18 photons. A zero mass gets no photon.

    Accuracy
    --------
    Multinomial: the probability of each conditional binomial has a relative error below 2^-51. Where fewer
    than 10 photons are expected its values come by inversion of a 53-bit uniform number, else by
    rejection (Hoermann 1993), with an acceptance off by at most 1e-6 at 2^53 photons and 1e-10 at 1e9.

    Raises
    ------
    AllocationError
        No positive mass, a mass that is negative or not finite, too many photons, or not a whole number.
    UsageError
        A method that does not exist; ``"aomc"`` with more than two dimensions.

    References
    ----------
    W. Hoermann, The generation of binomial random variates, J. Stat. Comput. Simul. 46, 101 (1993).

    Examples
    --------
    >>> sky.allocate([0.5, 0.3, 0.2], 10, seed=1)
    array([5, 3, 2])
    """
    chosen = member_of(AllocationMethod, method, "allocation")
    values = floats("mass", mass)
    n = checked_photons(n_photons, chosen)
    if chosen is AllocationMethod.AOMC:
        return _aomc(values, n)
    counts = allocate_bands(values, [n], [0], method=chosen, seed=checked_seed(seed))
    return counts.reshape(values.shape)


def allocate_bands(
    mass: ArrayLike,
    n_photons: Sequence[int],
    band_index: Sequence[int],
    *,
    method: AllocationMethod = AllocationMethod.SYSTEMATIC,
    seed: int = 0,
    family: str | None = None,
    rings: tuple[WalkedGrid, ...] = (),
) -> np.ndarray:
    """Share the photons of several bands out over one set of masses, normalised once: int64 (k, n_cell).

    Any method but AOMC; each row sums exactly to its request, which is one of `checked_photons`. The number of a band
    is the address of its random numbers. `family` is the method of the photons that the counts are for. By default it
    is "iid" for multinomial counts and "stratified" for others. Systematic allocation walks through the grids of
    `rings` ring by ring.

    Cost: per cell and band about 50 ns (systematic), 90 ns (largest remainder), 200 ns (multinomial), and 60 ns per
    cell for the normalisation, which the bands share.
    """
    cumulative = fixed_point_cumulative(mass)
    counts = np.empty((len(band_index), cumulative.size - 1), dtype=np.int64)
    key = np.uint64(stream_key(seed, ALLOCATION, family or _FAMILY.get(method, "stratified")))
    for row, n, band in zip(counts, n_photons, band_index, strict=True):
        if method is AllocationMethod.SYSTEMATIC:
            _systematic(cumulative, n, key, band, rings, row)
        elif method is AllocationMethod.LARGEST_REMAINDER:
            _largest_remainder(_tying_units(cumulative, mass, n), n, row)
        elif method is AllocationMethod.MULTINOMIAL:
            from aomc_sky.kernels.allocate import multinomial_counts

            multinomial_counts(cumulative, n, key, np.uint64(band), row)
        else:
            raise UsageError("aomc allocation needs a table", "call allocate with method='aomc'")
    return counts


def _systematic(
    cumulative: np.ndarray, n: int, key: np.uint64, band: int, rings: tuple[WalkedGrid, ...], counts: np.ndarray
) -> None:
    word, _ = rng.philox_pair(key, np.uint64(0), np.uint64(band), np.uint64(0))
    order = walk_of_cells(cumulative, n, rings) if rings else slice(None)
    walked = np.zeros_like(cumulative)
    np.cumsum(np.diff(cumulative)[order], out=walked[1:])
    quotient, _ = product_over_2_62(walked, n, int(word) >> 2)
    counts.view(np.uint64)[order] = np.diff(quotient)


def _tying_units(cumulative: np.ndarray, mass: ArrayLike, n: int) -> np.ndarray:
    """Units of each cell; of cells of one mass the fewest, so that equal masses tie and the first of them comes first.

    Rounding the cumulative gives equal masses units that differ by one. If the part left out makes up a whole photon,
    the units stay as they are, and the bound of one photon still holds.
    """
    units = np.diff(cumulative)
    if n * units.size < 1 << FIXED_POINT_BITS:
        _, group = np.unique(np.asarray(mass, dtype=np.float64).ravel(), return_inverse=True)
        least = np.full(units.size, 1 << FIXED_POINT_BITS, dtype=np.uint64)
        np.minimum.at(least, group, units)
        units = least[group]
    return units


def _largest_remainder(units: np.ndarray, n: int, counts: np.ndarray) -> None:
    quotient, remainder = product_over_2_62(units, n, 0)
    counts[:] = quotient
    missing = n - int(counts.sum())
    if missing == 0:
        return
    last = np.partition(remainder, counts.size - missing)[counts.size - missing]
    above = remainder > last
    counts += above
    counts[np.flatnonzero(remainder == last)[: missing - int(above.sum())]] += 1


def _aomc(weight: np.ndarray, n: int) -> np.ndarray:
    from aomc_sky.kernels.allocate import aomc_counts

    if weight.ndim > 2:
        raise UsageError(f"aomc allocation needs a table (n_zenith, n_azimuth), got {weight.ndim} dimensions")
    if not np.all(np.isfinite(weight)) or np.any(weight < 0):
        raise AllocationError("weights must be finite and not negative")
    with np.errstate(over="ignore"):
        table = np.atleast_2d(weight).astype(np.float32)
        total = np.cumsum(table.ravel("F"))[-1:]  # one after the other, as the program adds
    if not np.all(np.isfinite(total)):
        raise AllocationError(f"weights up to {weight.max():g} overflow the 32-bit sum of the AOMC program")
    if not table.max(initial=0) > 0:
        warnings.warn("all weights are zero: the AOMC program launches no photons, and so do we", InputWarning, 2)
    counts = np.zeros(table.shape, dtype=np.int64)
    aomc_counts(np.ascontiguousarray(table), n, counts)
    return counts.reshape(weight.shape)


# The order in which systematic allocation goes through the patches of a grid. Systematic allocation gives a photon to
# every N-th part of the cumulative mass. If all patches of a ring are equal, those with a photon more are therefore
# evenly spaced. If every ring began at the same column, rings of equal mass would fill the same columns. Therefore each
# ring begins its walk at a column of its own and closes the circle.

_SHIFT_STEP = np.uint64(0x6A09E667F3BCC909)
_COLUMN_STEP = np.uint64(0x4D82B446159F360F)
"""From ring to ring, in units of 2^-64: frac(sqrt 2) and (sqrt 13 - 3) / 2, rounded to an odd number. Their multiples
spread nearly as evenly as those of the golden ratio, which the places in the cells take from ring to ring."""

_SCATTER = 1 / 16
_TO_FRACTION = 2.0**-64
_ONE_PHOTON = 0.999  # below 1: a ring of exactly one photon must not change sides by a rounding
_HALF = 0.5001  # above 1/2, for the same reason


class WalkedGrid(NamedTuple):
    """One grid among the cells of all components, whose rings are walked."""

    first_cell: int  #: the number of the grid's first cell
    n_rings: int
    n_columns: int


def first_columns(units_before: np.ndarray, n_photons: int, n_columns: int) -> np.ndarray:
    """The column at which the walk through each ring begins, int64 (n_ring,).

    `units_before`, uint64 (n_ring + 1,), is the fixed-point cumulative mass before each ring, and at the end.

    Write E for the photons that a ring expects, and C for those of the rings before it in the grid. Write x in [0, 1)
    for the share of the ring before its first column. The pattern of patches with a photon more is shifted by E x - C
    of its period. Ring q takes an x that makes this shift frac(q sqrt 2). The shifts of successive rings are then
    spread evenly whatever E is. Among these x it takes the one next to frac(q (sqrt 13 - 3) / 2 + w / 16), where w is a
    pseudo-random number (Philox, counter q). E counts modulo the columns; where more than half of the patches have a
    photon more, those without one are the pattern. A ring that expects less than one photon takes x = w. The first ring
    begins at column 0.
    """
    quotient, remainder = product_over_2_62(units_before - units_before[0], n_photons, 0)
    unit = 2.0**-FIXED_POINT_BITS
    expected = np.diff(quotient.view(np.int64)) + np.diff(remainder.view(np.int64)) * unit
    excess = np.mod(expected, n_columns)
    is_gap = excess > _HALF * n_columns
    fewer = np.where(is_gap, n_columns - excess, excess)
    ring = np.arange(expected.size, dtype=np.uint64)
    random = rng.philox_pair(np.uint64(0), ring, np.uint64(0), np.uint64(0))[0] * _TO_FRACTION
    near = (ring * _COLUMN_STEP) * _TO_FRACTION + random * _SCATTER
    before = np.where(is_gap, -1.0, 1.0) * (remainder[:-1] * unit)
    off = (ring * _SHIFT_STEP) * _TO_FRACTION + before - fewer * near
    share = np.where(fewer < _ONE_PHOTON, near, near + (off - np.rint(off)) / np.maximum(fewer, 1.0))
    share = np.where(np.less(expected, _ONE_PHOTON), random, share)
    share[0] = 0.0
    return np.floor((share - np.floor(share)) * n_columns).astype(np.int64) % n_columns


def walk_of_cells(cumulative: np.ndarray, n_photons: int, rings: tuple[WalkedGrid, ...]) -> np.ndarray:
    """The cells in the order of the walk, int64 (n_cell,).

    `cumulative`, uint64 (n_cell + 1,), is the fixed-point cumulative mass in the order of the cells. Cells outside all
    grids, grids of one column and grids of one ring keep their order.
    """
    order = np.arange(cumulative.size - 1)
    for first_cell, n_rings, n_columns in rings:
        if n_columns == 1 or n_rings == 1:
            continue
        edges = first_cell + n_columns * np.arange(n_rings + 1)
        first = first_columns(cumulative[edges], n_photons, n_columns)
        column = (first[:, None] + np.arange(n_columns)) % n_columns
        order[edges[0] : edges[-1]] = (edges[:-1, None] + column).ravel()
    return order


@dataclass(frozen=True, kw_only=True, slots=True)
class PlanBand:
    """One waveband of a plan."""

    wavelength_nm: float  #: [nm]
    sky_wavelength_nm: float  #: of the sky that it takes; NaN where the sky has none [nm]
    requested: int  #: photons of all replicates together
    row: int  #: of the components' masses, weights and slopes
    #: Irradiance of each component on a horizontal plane, None where it is not known. [W m-2 nm-1]
    irradiance_W_m2_nm: tuple[float, ...] | None = None  # noqa: N815
    #: Of the light of the lobes, the share that comes from below the horizon and sends no photons. [0 to 1]
    horizon_loss: float = 0.0


def cumulative_counts(
    bands: Sequence[PlanBand],
    components: Sequence[Component],
    options: Mapping[str, Any],
    bias: np.ndarray | None = None,
) -> np.ndarray:
    """Member `cumulative` of a plan, int64 (n_replicate_band, n_cell + 1), from its masses, bias and options.

    Any allocation but `aomc`, which rounds the table itself. A band without light has no photons. The replicates of a
    band share its photons evenly; the first ones take one more where some are left.
    """
    replicates = options["replicates"]
    starts = [0, *accumulate(component.n_cells for component in components)]
    each, left = np.divmod(np.array([band.requested for band in bands]), replicates)
    photons = np.concatenate([each + (left > r) for r in range(replicates)])
    row_of = np.tile([band.row for band in bands], replicates)
    cumulative = np.zeros((photons.size, starts[-1] + 1), dtype=np.int64)
    rings = tuple(
        WalkedGrid(first_cell=start, n_rings=component.grid.n_zenith, n_columns=component.grid.n_azimuth)
        for start, component in zip(starts, components, strict=False)
        if component.grid is not None
    )
    for row in range(len(components[0].mass)):
        launch = np.concatenate([component.mass[row] for component in components])
        if not launch.any():
            continue
        if bias is not None:
            launch = launch * bias[row]
        own = np.flatnonzero(row_of == row)
        counts = allocate_bands(
            launch,
            photons[own].tolist(),
            own.tolist(),
            method=AllocationMethod(options["allocation"]),
            seed=options["seed"],
            family=options["method"],
            rings=rings,
        )
        cumulative[own, 1:] = np.cumsum(counts, axis=1)
    return cumulative
