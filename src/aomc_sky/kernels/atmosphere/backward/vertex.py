"""Vertices of paths that are followed backwards: the sun's light that they turn into a path, its new direction."""

from __future__ import annotations

import math

from aomc_sky.kernels.arithmetic.elementary import exp_level
from aomc_sky.kernels.atmosphere.backward.light import (
    ALBEDO,
    FIRST_SHARE,
    depth_to_end,
    draw_angle,
    find_cell,
    index,
    phase_at,
    sun_share,
)
from aomc_sky.kernels.atmosphere.backward.numbers import COSINE, SINE, SPARE, TURN
from aomc_sky.kernels.atmosphere.backward.state import (
    ALTITUDE,
    CELL,
    END,
    KIND,
    LEAST,
    LIGHT,
    LIVE,
    MU,
    SHELL,
    UX,
    UY,
    UZ,
    VX,
    VY,
    VZ,
    WEIGHT,
    settle,
)
from aomc_sky.kernels.jit import inlined_reader
from aomc_sky.kernels.phase.scatter import turned

_turned = inlined_reader(turned)


@inlined_reader
def light_of_air(shells, phases, shell, ux, uy, uz, sun):
    """Sum over the scatterers of share times phase function between a direction and the sun. [sr-1]"""
    x, y, z = ux - sun[0], uy - sun[1], uz - sun[2]
    t = math.sqrt(math.sqrt(min(0.25 * (x * x + y * y + z * z), 1.0)))
    n = phases.shape[0]
    total = 0.0
    for j in range(n):
        total += shells[FIRST_SHARE + n + j, index(shell)] * phase_at(phases, j, t)
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
def light_up(scales, shells, table, phases, sun, moon, ground, first, every, n, state, marks):
    """Add the sun's light of the vertex of every so many of the paths."""
    for i in range(first, n, every):
        k = index(marks[LIVE, i])
        state[LIGHT, k] += state[WEIGHT, k] * light_here(
            scales, shells, table, phases, sun, moon, ground, state[ALTITUDE, k], marks[SHELL, k],
            state[VX, k], state[VY, k], state[VZ, k], state[UX, k], state[UY, k], state[UZ, k], marks[END, k] == 1,
        )  # fmt: skip


@inlined_reader
def pick(shells, shell, n, xi):
    """Scatterer by its share, and what is left of the number as a new one."""
    if n == 1:
        return 0, xi
    low = 0.0
    which = 0
    high = shells[FIRST_SHARE, index(shell)]
    while which < n - 1 and xi >= high:
        which += 1
        low, high = high, shells[FIRST_SHARE + which, index(shell)]
    return which, (xi - low) / (high - low)


@inlined_reader
def find_cells(shells, phases, guide, n, numbers, marks):
    """Choose what scatters each path, and where in its table: apart from `turn`, which has no search to wait for."""
    for i in range(n):
        k = index(marks[LIVE, i])
        which, cell = 0, 0
        if marks[END, k] == 0:
            which, numbers[SPARE, i] = pick(shells, marks[SHELL, k], phases.shape[0], numbers[SPARE, i])
            cell = find_cell(phases, guide, index(which), numbers[TURN, i])
        marks[KIND, i], marks[CELL, i] = which, cell


@inlined_reader
def turn(shells, phases, ground, n, numbers, state, marks, sums, block, row):
    """New directions and weights after a vertex; the roulette ends paths, the others close up. Return how many."""
    left = 0
    for i in range(n):
        k = index(marks[LIVE, i])
        xi, c, s, spare = numbers[TURN, i], numbers[COSINE, i], numbers[SINE, i], numbers[SPARE, i]
        x, y, z = state[UX, k], state[UY, k], state[UZ, k]
        if marks[END, k] == 1:
            share, v, sine = ground[0], 1.0 - math.sqrt(xi), math.sqrt(1.0 - xi)
            x, y, z = state[VX, k], state[VY, k], state[VZ, k]
        else:
            t, share = draw_angle(phases, index(marks[KIND, i]), marks[CELL, i], xi)
            share *= shells[ALBEDO, index(marks[SHELL, k])]
            v = 2.0 * t * t * t * t
            sine = math.sqrt(v * (2.0 - v))
        weight = state[WEIGHT, k] * share
        least = state[LEAST, k]
        if weight < least:
            if spare * least >= weight:
                settle(state, k, sums, block, row)
                continue
            weight = least
        state[WEIGHT, k] = weight
        x, y, z = _turned(x, y, z, v, sine, c, s)
        state[UX, k], state[UY, k], state[UZ, k] = x, y, z
        state[MU, k] = x * state[VX, k] + y * state[VY, k] + z * state[VZ, k]
        marks[LIVE, index(left)] = k
        left += 1
    return left
