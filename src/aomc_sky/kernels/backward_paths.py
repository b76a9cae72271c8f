"""Paths of light followed backwards from the ground through spherical shells.

A path starts at the eye, where its first collision is forced; at every vertex in the air or on the ground the sun's
light that would be turned into the path is added, weakened by its way (the local estimate). The vertical v of the
place, the direction u and the altitude are its state. The numbers of a step are one block of Philox, addressed by
path, step, direction and wavelength: no path knows which others are followed, or by whom.
"""

from __future__ import annotations

import math

import numpy as np

from aomc_sky.kernels.backward_light import (
    ALBEDO,
    EXTINCTION,
    FIRST_SHARE,
    GAP,
    HIGH,
    LOW,
    depth_to_end,
    draw_angle,
    phase_at,
    shell_of,
    sun_share,
)
from aomc_sky.kernels.backward_march import march
from aomc_sky.kernels.jit import inlined_reader, reader
from aomc_sky.kernels.perez_law import exp_level
from aomc_sky.kernels.plain_scatter import cos_sin, turned
from aomc_sky.kernels.rng import philox4x32

_U64 = np.uint64
_LOW = np.uint64(0xFFFFFFFF)
_S32 = np.uint64(32)
_INV32 = 2.0**-32
_ROULETTE = 0.05

_cos_sin = inlined_reader(cos_sin)
_turned = inlined_reader(turned)

N_WHOLE = 6
"""Sums of a block: light without the sun's order 1, its squares, greatest; of some paths the same of that order."""


@inlined_reader
def uniform(word):
    """Middle of one of 2^32 parts of (0, 1)."""
    return (np.float64(word) + 0.5) * _INV32


@inlined_reader
def first_flight(radius, shells, mu, flight):
    """Optical depth and way of a ray from the ground to the lower edge of each shell (n_shell + 1, 2)."""
    start = radius * mu
    q = start
    flight[0, 0] = 0.0
    flight[0, 1] = 0.0
    for k in range(shells.shape[0]):
        onward = math.sqrt(start * start + shells[k, HIGH] * (shells[k, HIGH] + 2.0 * radius))
        length = shells[k, GAP] / (q + onward)
        flight[k + 1, 0] = flight[k, 0] + length * shells[k, EXTINCTION]
        flight[k + 1, 1] = flight[k, 1] + length
        q = onward


@inlined_reader
def forced(shells, flight, weight, xi):
    """Shell and way of the first collision, which is forced: `weight` is its probability."""
    passed = -math.log(1.0 - xi * weight)
    shell = min(shell_of(flight, 0, passed), shells.shape[0] - 1)
    extinction = shells[shell, EXTINCTION]
    rest = (passed - flight[shell, 0]) / extinction if extinction > 0.0 else 0.0
    return shell, flight[shell, 1] + rest


@inlined_reader
def fly(radius, shells, altitude, shell, mu, to_end, hits, xi):
    """Shell and way of the next collision, and whether it is with the ground; shell -1 where light is gone."""
    if xi > exp_level(-to_end):
        depth = -math.log(xi)
        found, way = march(radius, shells, altitude, shell, mu, depth)
        return found, way, False
    if not hits:
        return -1, 0.0, False
    q = (radius + altitude) * mu
    c = altitude * (altitude + 2.0 * radius)
    return 0, c / (math.sqrt(max(q * q - c, 0.0)) - q), True


@inlined_reader
def place(radius, low, high, altitude, vx, vy, vz, ux, uy, uz, mu, way):
    """Altitude, within two edges, and vertical at the end of a way."""
    r = radius + altitude
    rise = way * (way + 2.0 * r * mu)
    root = math.sqrt(max(r * r + rise, 0.0))
    found = min(max(altitude + rise / (root + r), low), high)
    one = 1.0 / root
    r *= one
    way *= one
    return found, r * vx + way * ux, r * vy + way * uy, r * vz + way * uz


@inlined_reader
def light_of_air(shells, phases, shell, ux, uy, uz, sun):
    """Sum over the scatterers of share times phase function between a direction and the sun. [sr-1]"""
    x, y, z = ux - sun[0], uy - sun[1], uz - sun[2]
    t = math.sqrt(math.sqrt(min(0.25 * (x * x + y * y + z * z), 1.0)))
    n = phases.shape[0]
    total = 0.0
    for j in range(n):
        total += shells[shell, FIRST_SHARE + n + j] * phase_at(phases, j, t)
    return total


@inlined_reader
def light_here(scales, shells, table, phases, sun, moon, ground, altitude, shell, vx, vy, vz, ux, uy, uz, on_ground):
    """The sun's light that a vertex turns into the path, for a weight of 1; albedo and irradiance are in it."""
    mu = vx * sun[0] + vy * sun[1] + vz * sun[2]
    depth, hits = depth_to_end(scales, shells, table, altitude, shell, mu)
    light = ground[0] * max(mu, 0.0) / math.pi
    if not on_ground:
        light = light_of_air(shells, phases, shell, ux, uy, uz, sun)
    light *= 0.0 if hits else exp_level(-depth) * ground[2]
    if moon[3] > 0.0:
        light *= sun_share(scales[0] + altitude, vx, vy, vz, sun, moon)
    return light


@inlined_reader
def pick(shells, shell, n, xi):
    """Scatterer by its share, and what is left of the number as a new one."""
    if n == 1:
        return 0, xi
    low = 0.0
    which = 0
    high = shells[shell, FIRST_SHARE]
    while which < n - 1 and xi >= high:
        which += 1
        low, high = high, shells[shell, FIRST_SHARE + which]
    return which, (xi - low) / (high - low)


@inlined_reader
def commit(sums, block, row, value):
    """Add one path's light of an order, and its square, to the sums of its block."""
    sums[block, row, 0] += value
    sums[block, row, 1] += value * value


@inlined_reader
def turn(shells, phases, guide, shell, vx, vy, vz, ux, uy, uz, on_ground, words):
    """New direction after a vertex, its weight but for the ground's albedo, and a number that is left over."""
    xi = uniform(words[1])
    c, s = _cos_sin(uniform(words[2]))
    spare = uniform(words[3])
    if on_ground:
        x, y, z = _turned(vx, vy, vz, 1.0 - math.sqrt(xi), math.sqrt(1.0 - xi), c, s)
        return x, y, z, 1.0, spare
    which, spare = pick(shells, shell, phases.shape[0], spare)
    t, share = draw_angle(phases, guide, which, xi)
    v = 2.0 * t * t * t * t
    x, y, z = _turned(ux, uy, uz, v, math.sqrt(v * (2.0 - v)), c, s)
    return x, y, z, shells[shell, ALBEDO] * share, spare


@inlined_reader
def follow(
    scales, shells, table, phases, guide, sun, moon, ground, limits, address, view, flight, forcing, sums, block,
    is_checked,
):  # fmt: skip
    """One path: its light without the sun's order 1, and that.

    `ground`: albedo, own radiance, sun's irradiance; `limits`: most interactions, rows of `sums`, and which
    paths count for the sun's order 1: every so many. A row is filled by
    one vertex, and by what the flight from there sees of the ground's own light; the last row has all later ones too.
    """
    radius = scales[0]
    vx, vy, vz, ux, uy, uz = 0.0, 0.0, 1.0, view[0], view[1], view[2]
    altitude, weight, on_ground = 0.0, forcing, False
    total, once, light, step = 0.0, 0.0, 0.0, 0
    words = philox4x32(address[0], _U64(0), address[1], address[2], address[3] & _LOW, address[3] >> _S32)
    shell, way = forced(shells, flight, weight, uniform(words[0]))
    mu = uz
    while True:
        low, high = (0.0, 0.0) if on_ground else (shells[shell, LOW], shells[shell, HIGH])
        altitude, vx, vy, vz = place(radius, low, high, altitude, vx, vy, vz, ux, uy, uz, mu, way)
        step += 1
        if step > 1 or is_checked:
            light += weight * light_here(
                scales, shells, table, phases, sun, moon, ground, altitude, shell, vx, vy, vz, ux, uy, uz, on_ground
            )
        if step == 1:
            once, light = light, 0.0
        ux, uy, uz, share, spare = turn(shells, phases, guide, shell, vx, vy, vz, ux, uy, uz, on_ground, words)
        weight *= ground[0] if on_ground else share
        if weight < _ROULETTE:
            if spare * _ROULETTE >= weight:
                break
            weight = _ROULETTE
        mu = vx * ux + vy * uy + vz * uz
        to_end, hits = depth_to_end(scales, shells, table, altitude, shell, mu)
        if hits and ground[1] > 0.0:
            light += weight * ground[1] * exp_level(-to_end)
        if step < limits[1] and light > 0.0:
            commit(sums, block, step - 1, light)
            total += light
            light = 0.0
        if step >= limits[0]:
            break
        words = philox4x32(address[0], _U64(step), address[1], address[2], address[3] & _LOW, address[3] >> _S32)
        shell, way, on_ground = fly(radius, shells, altitude, shell, mu, to_end, hits, uniform(words[0]))
        if shell < 0 or (on_ground and ground[0] <= 0.0):
            break
    if light != 0.0:
        commit(sums, block, min(step, limits[1]) - 1, light)
    return total + light, once


@reader
def follow_paths(
    scales, shells, table, phases, guide, sun, moon, ground, limits, address, view, n_paths, block, flight, sums, whole
):  # fmt: skip
    """Sums over blocks of paths in one direction at one wavelength.

    Parameters
    ----------
    scales : tuple of 3 float
        Radius of the ground, and c and s of the table.
    shells : ndarray, float64, shape (n_shell, FIRST_SHARE + 2 n_scatterer)
        Their columns are named in `backward_light`.
    table : ndarray, float64, shape (n_shell + 1, n + 1)
        Of optical depths.
    phases : ndarray, float64, shape (n_scatterer, n + 1, 2)
        Phase functions over t and their integrals up to there.
    guide : ndarray, int64, shape (n_scatterer, n)
        Where a part of the integral is found.
    sun, view : tuple of 3 float
        Directions, z up at the eye.
    moon, ground, limits : tuple
        See `backward_light.sun_share` and `follow`.
    address : tuple of 3 uint64
        Direction, wavelength, key.
    n_paths, block : int
        Paths, and how many stand in one row of the sums.
    flight : ndarray, float64, shape (n_shell + 1, 2)
        Room to work in.
    sums : ndarray, float64, shape (n_block, n_row, 2)
        Light of each order and its squares; filled.
    whole : ndarray, float64, shape (n_block, N_WHOLE)
        Filled.
    """
    first_flight(scales[0], shells, view[2], flight)
    forcing = -math.expm1(-flight[shells.shape[0], 0])
    for row in range(whole.shape[0]):
        for k in range(row * block, min((row + 1) * block, n_paths)):
            place_of = (_U64(k), address[0], address[1], address[2])
            light, once = follow(
                scales, shells, table, phases, guide, sun, moon, ground, limits, place_of, view, flight, forcing,
                sums, row, k % limits[2] == 0,
            )  # fmt: skip
            whole[row, 0] += light
            whole[row, 1] += light * light
            whole[row, 2] = max(whole[row, 2], light)
            whole[row, 3] += once
            whole[row, 4] += once * once
            whole[row, 5] = max(whole[row, 5], once)
