"""The records of an MCPL file: energies and directions as they are packed, and what is no particle."""

from __future__ import annotations

import numpy as np

from aomc_sky.formats.mcpl.header import McplFault, McplHeader

DIRECTION_TOLERANCE = 1e-5
"""How far the squares of a direction may be from 1, as libmcpl has it."""


def unpack(packed: np.ndarray, version: int) -> tuple[np.ndarray, np.ndarray]:
    """Energies [MeV] (n,) and unit vectors (n, 3) of packed triples (n, 3), float64.

    A triple is two numbers of the direction, octahedral in version 2 and an adaptive projection in version 3, and the
    energy with the sign of the third.
    """
    return (_octahedral if version == 2 else _adaptive)(packed)


def _adaptive(packed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The smaller components as they are, with 1/z in the place of the largest; its sign is that of the energy."""
    a, b, c = packed.T
    is_x, is_y = np.abs(a) > 1.0, np.abs(b) > 1.0
    is_y &= ~is_x
    first = np.where(is_x, b, a)
    with np.errstate(divide="ignore"):
        second = np.where(is_x, 1.0 / a, np.where(is_y, 1.0 / b, b))
    largest = np.copysign(np.sqrt(np.maximum(0.0, 1.0 - (first * first + second * second))), c)
    direction = np.empty_like(packed)
    direction[:, 0] = np.where(is_x, largest, a)
    direction[:, 1] = np.where(is_y, largest, b)
    direction[:, 2] = np.where(is_x | is_y, second, largest)
    return np.abs(c), direction


def _octahedral(packed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    a, b, c = packed.T
    z = 1.0 - np.abs(a) - np.abs(b)
    is_lower = z < 0
    x = np.where(is_lower, (1.0 - np.abs(b)) * np.where(a >= 0.0, 1.0, -1.0), a)
    y = np.where(is_lower, (1.0 - np.abs(a)) * np.where(b >= 0.0, 1.0, -1.0), b)
    scale = 1.0 / np.sqrt(x * x + y * y + z * z)
    direction = np.stack([x * scale, y * scale, z * scale], axis=-1)
    direction[np.signbit(c), 2] = 0.0  # the sign of the energy marks a horizontal direction
    return np.abs(c), direction


def record_faults(records: np.ndarray, header: McplHeader, start: int, limit: int) -> list[McplFault]:
    """What is wrong with stored records, at most `limit` faults in their order; `start` is the index of the first."""
    found: list[tuple[int, str, str]] = []
    for name in ("polarisation", "position", "time", "weight"):
        if name in (records.dtype.names or ()) and not _is_surely_finite(records[name]):
            is_bad = ~np.isfinite(records[name])
            found += _first(is_bad.any(axis=1) if is_bad.ndim == 2 else is_bad, name, "not a finite number", limit)
    first, second, energy = (records["packed"][:, k].astype(np.float64) for k in range(3))
    found += _first(~np.isfinite(energy), "energy", "not a finite number", limit)
    found += _first(_no_direction(first, second, header.version), "direction", "not a unit vector", limit)
    found.sort()
    return [McplFault("E805", name, f"record {start + k}: {what}") for k, name, what in found[:limit]]


def _is_surely_finite(values: np.ndarray) -> bool:
    """Whether a look at the sum says so, which spares the look at each; a sum of large numbers says nothing."""
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.isfinite(values.sum(dtype=np.float64)))


def _first(is_bad: np.ndarray, name: str, what: str, limit: int) -> list[tuple[int, str, str]]:
    return [(int(k), name, what) for k in np.flatnonzero(is_bad)[:limit]]


def _no_direction(a: np.ndarray, b: np.ndarray, version: int) -> np.ndarray:
    """Whether the two numbers of a direction come from no unit vector; also where one is not a number."""
    if version == 2:
        return ~((np.abs(a) <= 1.0 + DIRECTION_TOLERANCE) & (np.abs(b) <= 1.0 + DIRECTION_TOLERANCE))
    is_x = np.abs(a) > 1.0
    is_y = ~is_x & (np.abs(b) > 1.0)
    with np.errstate(divide="ignore", over="ignore"):  # 1/z is infinite where z is 0
        first, second = np.where(is_x, 1.0 / a, a), np.where(is_y, 1.0 / b, b)
        return ~(first * first + second * second <= 1.0 + DIRECTION_TOLERANCE)
