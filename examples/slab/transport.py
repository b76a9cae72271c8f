"""A photon's life in the water, and the loop that launches photons from an aomc-sky sampler.

Directions are travel directions in the frame UP: z grows upward, a photon from the sky has uz < 0. Depth is
told as optical depth below the surface. The layer has no horizontal structure, so places across it are not
followed.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numba
import numpy as np
from fresnel import reflectance, refracted_mu
from philox import event_numbers
from scattering import sample_henyey_greenstein, sample_rayleigh, turned
from tally import (
    ABSORBED,
    BOTTOM,
    LEAVING,
    MAX_PHOTONS,
    ONE_PHOTON,
    REFLECTED,
    Tally,
    add_refracted,
    empty_tally,
    sum_of,
)
from water import Water

from aomc_sky import UsageError

Numbers = tuple[float, float, float, float]
"""Of an event: for the free path, the photon's fate, the angle and the azimuth of a scattering."""

CHUNK = 65_536
"""Photons that a thread takes at a time."""


@numba.njit(nogil=True)
def collide(
    ux: float, uy: float, uz: float, water: Water, fate: float, polar: float, plane: float
) -> tuple[bool, float, float, float]:
    """Absorb the photon, or scatter it; three uniform numbers decide. Returns whether it lives, and its direction."""
    if fate >= water.albedo:
        return False, ux, uy, uz
    if fate < water.albedo * water.rayleigh_share:
        mu = sample_rayleigh(polar)
    else:
        mu = sample_henyey_greenstein(water.asymmetry, polar)
    ux, uy, uz = turned(ux, uy, uz, mu, plane)
    return True, ux, uy, uz


@numba.njit(nogil=True)
def lambertian(polar: float, plane: float) -> tuple[float, float, float]:
    """Return a direction upwards, cosine-weighted."""
    sine, azimuth = math.sqrt(1.0 - polar), 2.0 * math.pi * plane
    return sine * math.cos(azimuth), sine * math.sin(azimuth), math.sqrt(polar)


@numba.njit(nogil=True)
def count_levels(z: float, level: int, depths: np.ndarray, weight: int, tally: Tally) -> int:
    """Count a step that ends at z on every depth it crosses; `level` is how many depths lie above the photon."""
    while level < depths.size and depths[level] <= z:
        tally.down[level] += weight
        level += 1
    while level > 0 and depths[level - 1] > z:
        level -= 1
        tally.up[level] += weight
    return level


@numba.njit(nogil=True)
def follow(
    photon: int,
    ux: float,
    uy: float,
    uz: float,
    weight: int,
    water: Water,
    key: np.uint64,
    depths: np.ndarray,
    tally: Tally,
    first: Numbers,
) -> None:
    """Follow a photon from just below the surface to its end; every choice is one random number, its weight stays.

    Parameters
    ----------
    photon : int
        Index; its random numbers are those of this index.
    ux, uy, uz : float
        Travel direction below the surface.
    weight : int
        In parts of `ONE_PHOTON`.
    water : Water
        The layer.
    key : numpy.uint64
        Of the transport's random numbers.
    depths : ndarray, float64, shape (n_depth,)
        Optical depths to count at, ascending. [0 to the layer's]
    tally : Tally
        Receives the weight.
    first : tuple of four float
        The numbers of its first event; see `FIRST_NUMBERS`.
    """
    z, level, event, end = 0.0, 0, 0, -1
    path, fate, polar, plane = first
    while end < 0:
        if event > 0:
            path, fate, polar, plane = event_numbers(key, photon, event)
        event += 1
        z += math.log(path) * uz  # log of a number below 1: minus the free path
        level = count_levels(z, level, depths, weight, tally)
        if z < 0.0:
            z = 0.0
            inner = 1.0 / water.refractive_index
            if fate >= reflectance(uz, refracted_mu(uz, inner), inner):
                end = LEAVING
            uz = -uz
        elif z >= water.optical_depth:
            z = water.optical_depth
            if fate >= water.bottom_reflectance:
                end = BOTTOM
            else:
                ux, uy, uz = lambertian(polar, plane)
        else:
            lives, ux, uy, uz = collide(ux, uy, uz, water, fate, polar, plane)
            if not lives:
                end = ABSORBED
    tally.fate[end] += weight


@numba.njit(nogil=True)
def enter(
    photon: int,
    ux: float,
    uy: float,
    uz: float,
    water: Water,
    key: np.uint64,
    depths: np.ndarray,
    tally: Tally,
    first: Numbers,
) -> None:
    """Split a photon from the sky at the surface, and follow the refracted part; parameters as in `follow`."""
    index = water.refractive_index
    mu = refracted_mu(-uz, index)
    turned_back = int(ONE_PHOTON * reflectance(-uz, mu, index) + 0.5)
    weight = ONE_PHOTON - turned_back
    tally.fate[REFLECTED] += turned_back
    if weight > 0:
        add_refracted(tally.refracted, ux, uy, mu, index, weight)
        follow(photon, ux / index, uy / index, -mu, weight, water, key, depths, tally, first)


@numba.njit(nogil=True)
def by_chance(light: tuple[float, ...], key: np.uint64, photon: int) -> Numbers:
    """Random numbers for the first event, too."""
    return event_numbers(key, photon, 0)


@numba.njit(nogil=True)
def with_path(light: tuple[float, ...], key: np.uint64, photon: int) -> Numbers:
    """The first free path goes with the photon; 1 - n lies in (0, 1], so that its logarithm is finite."""
    _, fate, polar, plane = event_numbers(key, photon, 0)
    return 1.0 - light[3], fate, polar, plane


@numba.njit(nogil=True)
def with_angle(light: tuple[float, ...], key: np.uint64, photon: int) -> Numbers:
    """The first scattering angle, too."""
    _, fate, _, plane = event_numbers(key, photon, 0)
    return 1.0 - light[3], fate, light[4], plane


@numba.njit(nogil=True)
def with_plane(light: tuple[float, ...], key: np.uint64, photon: int) -> Numbers:
    """And the azimuth of the first scattering."""
    _, fate, _, _ = event_numbers(key, photon, 0)
    return 1.0 - light[3], fate, light[4], light[5]


FIRST_NUMBERS = (by_chance, with_path, with_angle, with_plane)
"""The numbers of a photon's first event, of samplers with 0 to 3 numbers."""


@numba.njit(nogil=True)
def trace(
    sample: Callable[[int], tuple[float, ...]],
    first_numbers: Callable[[tuple[float, ...], np.uint64, int], Numbers],
    first: int,
    last: int,
    water: Water,
    key: np.uint64,
    depths: np.ndarray,
    tally: Tally,
) -> None:
    """Launch the photons [first, last) of a sampler. No Python runs in this loop; `sample` is compiled into it."""
    for photon in range(first, last):
        light = sample(photon)
        ux, uy, uz = np.float64(light[0]), np.float64(light[1]), np.float64(light[2])
        enter(photon, ux, uy, uz, water, key, depths, tally, first_numbers(light, key, photon))


def simulate(
    sample: Any,
    n_photons: int,
    water: Water,
    key: np.uint64,
    depths: Sequence[float],
    n_threads: int | None = None,
    *,
    numbers: int = 0,
) -> Tally:
    """Launch photons 0 to n_photons - 1 on several threads; the tally does not depend on how many.

    Parameters
    ----------
    sample : jitted function
        ``sample(i) -> (ux, uy, uz, ...)``, as ``source.numba_sampler(band, numbers=numbers).sample``.
    n_photons : int
        How many. [0 to 2^30]
    water : Water
        The layer.
    key : numpy.uint64
        From `transport_key`.
    depths : sequence of float
        Optical depths to count at, ascending. [0 to the layer's]
    n_threads : int, optional
        Default: all cores.
    numbers : int
        How many numbers of the photon its first event takes: free path, scattering angle, azimuth. [0 to 3]

    Raises
    ------
    UsageError
        Too many photons for exact sums, or depths that do not ascend within the layer.
    """
    levels = np.array(depths, dtype=np.float64)
    if levels.size and not (levels[0] >= 0 and levels[-1] <= water.optical_depth and np.all(np.diff(levels) >= 0)):
        raise UsageError("depths must ascend from the surface to the bottom")
    if not 0 <= n_photons <= MAX_PHOTONS:
        raise UsageError(f"one tally takes up to 2^30 = {MAX_PHOTONS} photons, got {n_photons}; use more replicates")

    def part(first: int) -> Tally:
        tally = empty_tally(levels.size)
        trace(sample, FIRST_NUMBERS[numbers], first, min(first + CHUNK, n_photons), water, key, levels, tally)
        return tally

    with ThreadPoolExecutor(n_threads or os.cpu_count()) as pool:
        return sum_of([empty_tally(levels.size), *pool.map(part, range(0, n_photons, CHUNK))])
