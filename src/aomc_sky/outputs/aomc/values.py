"""Radiances from which the AOMC 1.2.2 program, in its 32-bit arithmetic, launches given integer counts."""

from __future__ import annotations

import numpy as np

from aomc_sky.errors import AllocationError
from aomc_sky.sampling.allocation import AllocationMethod, allocate
from aomc_sky.skies.aomc_weight import aomc_weight

MOST_PHOTONS = 16_000_000
"""Photons of a band up to which shares of the total in 32-bit floats tell every integer apart (below 2^24)."""

_NEIGHBOURS = 3
"""Floats on each side of a first guess among which the four products of the program reach every weight they can."""

_STEPS = 24
_SCALES = 32
_PROGRAM_SCALES, _PROGRAM_EXPONENT = 256, 20


def exact_radiances(counts: np.ndarray) -> np.ndarray:
    """Radiances on whole degrees that make the AOMC program launch these photons, checked by its own rule; float32.

    Weights equal to the counts would do, since up to 1.6e7 photons the program's share of a total is good to
    half a photon; but its four products round, and cannot reach every weight. Where that matters (patches
    with a quarter of the photons and more), values move by units of the last place, and where no such move
    helps, all values are scaled a little, which changes which weights can be reached: about 10 ms for a full table
    of 89 x 360, ten times that where many scales are tried. AllocationError where no values were found.
    """
    total = int(counts.sum())
    if total > MOST_PHOTONS:
        raise AllocationError(
            f"{total} photons in a band are more than the {MOST_PHOTONS} that the program can share out"
        )
    if total == 0:
        return np.zeros(counts.shape, dtype=np.float32)
    for trial in range(_SCALES):
        radiance = _refined(counts, total, 1.0 + trial / 4096.0)
        if radiance is not None:
            return radiance
    raise AllocationError(
        "no 32-bit radiances make the AOMC program launch exactly these counts; export another seed or photon number"
    )


def program_radiances(mass: np.ndarray, counts: np.ndarray, iterations: int) -> np.ndarray:
    """Radiances on whole degrees from which the program rounds these masses to these photons, drift included; float32.

    The masses of a run with ``--compat aomc`` are the program's 32-bit weights over their sum. Multiplied by
    some number they are weights again, to a rounding; the scale is chosen so that all roundings fall as in the run.
    AllocationError where none does. `mass` (n_zenith, n_azimuth) begins at zenith index 1 and has at most 89 rows,
    `counts` has 89.
    """
    table = np.zeros(counts.shape)
    table[: len(mass)] = mass
    if not table.any():
        return np.zeros(counts.shape, dtype=np.float32)
    for trial in range(_PROGRAM_SCALES):
        radiance = _nearest(table * np.ldexp(1.0 + trial / 4096.0, _PROGRAM_EXPONENT))
        if np.array_equal(allocate(aomc_weight(radiance), iterations, method=AllocationMethod.AOMC), counts):
            return radiance
    raise AllocationError(
        "no 32-bit radiances were found that the AOMC program rounds to the counts of this run; the scene's own "
        "skydist.inp gives them"
    )


def _refined(counts: np.ndarray, total: int, scale: float) -> np.ndarray | None:
    """Values of about `scale` times the counts as weights, or None where these counts cannot be had so."""
    radiance = _nearest(scale * counts)
    for step in range(_STEPS):
        weight = aomc_weight(radiance)
        launched = allocate(weight, total, method=AllocationMethod.AOMC)
        wrong = launched != counts
        if not wrong.any():
            return radiance
        if step < _STEPS // 2:
            radiance = np.where(wrong, _nearest(_share(weight, counts, wrong) * counts), radiance)
            continue
        towards = np.where(launched < counts, np.float32(np.inf), np.float32(0))
        radiance = np.where(wrong, np.nextafter(radiance, towards), radiance)
    return None


def _share(weight: np.ndarray, counts: np.ndarray, wrong: np.ndarray) -> float:
    """Weight of a photon that fits the program's sum once the wrong patches have it too."""
    summed = float(np.cumsum(weight.ravel("F"))[-1])  # one after the other, as the program adds
    right_photons = float(counts[~wrong].sum())
    if right_photons == 0:
        return summed / float(counts.sum())
    return (summed - float(weight[wrong].sum(dtype=np.float64))) / right_photons


def _nearest(weight: np.ndarray) -> np.ndarray:
    """Radiances, float32, whose weights under the program's rule are nearest to the given ones."""
    unit = aomc_weight(np.ones(weight.shape)).astype(np.float64)
    guess = (weight / unit).astype(np.float32)
    best, distance = guess, np.abs(aomc_weight(guess) - weight)
    for direction in (np.float32(0), np.float32(np.inf)):
        candidate = guess
        for _ in range(_NEIGHBOURS):
            candidate = np.where(weight > 0, np.nextafter(candidate, direction), candidate)
            error = np.abs(aomc_weight(candidate) - weight)
            best, distance = np.where(error < distance, candidate, best), np.minimum(error, distance)
    return best
