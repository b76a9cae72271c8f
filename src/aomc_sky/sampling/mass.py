"""Masses of any scale as probabilities: float64, and exact fixed point with 62 bits."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import AllocationError
from aomc_sky.sampling.fixed_point import rounded_cumulative

_LEVELS = 3


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


def _scaled(values: np.ndarray) -> tuple[np.ndarray, float]:
    """Masses times the power of two that brings the largest into [1/2, 1), and their correctly rounded sum."""
    scaled = np.ldexp(values, -int(np.frexp(values.max())[1]))
    return scaled, exact_sum(scaled)


def exact_sum(values: np.ndarray) -> float:
    """Correctly rounded sum, equal to `math.fsum` to the bit and several times as fast for large arrays.

    Parameters
    ----------
    values : ndarray, float64, shape (n,)
        Summands. [0 to 1]

    Returns
    -------
    float
        The float64 next to the exact sum.

    References
    ----------
    S. M. Rump, T. Ogita, S. Oishi, Accurate floating-point summation I, SIAM J. Sci. Comput. 31, 189
    (2008): adding and subtracting a power of two cuts every summand at the same bit without an error,
    and the upper parts have so few bits that their plain sum is exact in any order.
    """
    bits = (values.size + 1).bit_length()
    sigma = math.ldexp(1.0, bits)
    parts = []
    rest = values
    for _ in range(_LEVELS):
        upper = rest + sigma
        upper -= sigma
        parts.append(float(upper.sum()))
        rest = np.subtract(rest, upper, out=upper)
        if not rest.any():
            break
        sigma = math.ldexp(sigma, bits - 53)
    return math.fsum([*parts, *rest[rest != 0].tolist()])


def normalise(mass: ArrayLike) -> np.ndarray:
    """Divide masses by their sum.

    Parameters
    ----------
    mass : array_like
        Any finite masses, at least one positive; from 5e-324 to 1.8e308 in one array. [>= 0]

    Returns
    -------
    ndarray, float64, shape (n_cell,)
        Probabilities. Relative error of each at most 2^-52 where the result is a normal number.

    Raises
    ------
    AllocationError
        No positive mass, or one that is negative or not finite.
    """
    values = _checked(mass)
    scaled, total = _scaled(values)
    return scaled / total


def fixed_point_cumulative(mass: ArrayLike) -> np.ndarray:
    """Exact cumulative of the masses in units of 2^-62.

    Parameters
    ----------
    mass : array_like
        As for `normalise`.

    Returns
    -------
    ndarray, uint64, shape (n_cell + 1,)
        0 ... 2^62: the exact cumulative of the masses over their sum, each entry rounded to the nearest unit. So every
        cell, and every run of neighbouring cells, is within one unit of 2^62 times its exact share. A cell of zero
        mass has zero units; a positive cell below one unit may have zero, too.
    """
    return rounded_cumulative(_checked(mass))
