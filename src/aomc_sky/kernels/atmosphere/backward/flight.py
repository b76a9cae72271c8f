"""Flights of paths that are followed backwards: to the first collision, which is forced, and to the next vertex."""

from __future__ import annotations

import math

from aomc_sky.kernels.arithmetic.elementary import exp_level
from aomc_sky.kernels.atmosphere.backward.light import EXTINCTION, HIGH, LOW, RISE, depth_to_end, index
from aomc_sky.kernels.atmosphere.backward.march import march
from aomc_sky.kernels.atmosphere.backward.numbers import FLIGHT, N_NUMBER, TURN
from aomc_sky.kernels.atmosphere.backward.state import (
    ALTITUDE,
    END,
    LEAST,
    LIGHT,
    LIVE,
    MU,
    ONCE,
    SHELL,
    TO_END,
    TOTAL,
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

_ROULETTE, _SHARE = 0.05, 0.5  # of a weight, and of the one that a path starts with: thin air starts all with little


@inlined_reader
def first_flight(radius, shells, mu, flight):
    """Optical depth and way of a ray from the ground to the lower edge of each shell; where a share of all is reached.

    The last of the rows (3, n_shell + 1) has the shell where j of n_shell equal parts of the depth are passed.
    """
    start = radius * mu
    q = start
    flight[0, 0] = 0.0
    flight[1, 0] = 0.0
    for k in range(shells.shape[1]):
        onward = math.sqrt(start * start + shells[RISE, k])
        flight[0, k + 1] = flight[0, k] + (onward - q) * shells[EXTINCTION, k]
        flight[1, k + 1] = onward - start
        q = onward
    step, marked = flight[0, shells.shape[1]] / shells.shape[1], 0
    for k in range(shells.shape[1]):
        while marked < shells.shape[1] and marked * step < flight[0, k + 1]:
            flight[2, marked] = k
            marked += 1
    for j in range(marked, shells.shape[1] + 1):
        flight[2, j] = shells.shape[1] - 1


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
def open_path(radius, shells, flight, weight, view, i, numbers, state, marks):
    """Place path i of those abreast at its first collision, which is forced: its weight is the probability of it."""
    end = shells.shape[1]
    passed = -math.log(1.0 - numbers[FLIGHT, i] * weight)
    shell = int(flight[2, index(min(passed / flight[0, end], 1.0) * end)])
    while shell < end - 1 and flight[0, index(shell + 1)] <= passed:
        shell += 1
    extinction = shells[EXTINCTION, index(shell)]
    rest = (passed - flight[0, index(shell)]) / extinction if extinction > 0.0 else 0.0
    altitude, vx, vy, vz = place(
        radius, shells[LOW, index(shell)], shells[HIGH, index(shell)], 0.0, 0.0, 0.0, 1.0, view[0], view[1], view[2],
        view[2], flight[1, index(shell)] + rest,
    )  # fmt: skip
    marks[LIVE, i], marks[SHELL, i], marks[END, i] = i, shell, 0
    state[ALTITUDE, i], state[VX, i], state[VY, i], state[VZ, i] = altitude, vx, vy, vz
    state[UX, i], state[UY, i], state[UZ, i] = view[0], view[1], view[2]
    state[WEIGHT, i], state[LEAST, i] = weight, min(_ROULETTE, _SHARE * weight)
    state[LIGHT, i], state[TOTAL, i], state[ONCE, i] = 0.0, 0.0, 0.0


@inlined_reader
def look(scales, shells, table, ground, n, state, marks):
    """Optical depths of the paths' new directions to their ends, and the ground's own light that comes from there."""
    for i in range(n):
        k = index(marks[LIVE, i])
        to_end, hits = depth_to_end(scales, shells, table, state[ALTITUDE, k], marks[SHELL, k], state[MU, k])
        state[TO_END, k], marks[END, k] = to_end, hits
        if hits and ground[1] > 0.0:
            state[LIGHT, k] += state[WEIGHT, k] * ground[1] * exp_level(-to_end)


@inlined_reader
def fly(radius, shells, ground, n, numbers, state, marks, sums, block, row):
    """Bring paths to their next vertex; those that get out end, the others close up. Return how many are left."""
    left = 0
    for i in range(n):
        k = index(marks[LIVE, i])
        altitude, mu, depth = state[ALTITUDE, k], state[MU, k], numbers[FLIGHT, i]
        hits = marks[END, k] == 1
        low, high = 0.0, 0.0
        if depth < state[TO_END, k]:
            hits = False
            shell, way = march(radius, shells, altitude, marks[SHELL, k], mu, depth)
            if shell < 0:
                settle(state, k, sums, block, row)
                continue
            low, high = shells[LOW, index(shell)], shells[HIGH, index(shell)]
        elif hits and ground[0] > 0.0:
            q = (radius + altitude) * mu
            c = altitude * (altitude + 2.0 * radius)
            shell, way = 0, c / (math.sqrt(max(q * q - c, 0.0)) - q)
        else:
            settle(state, k, sums, block, row)
            continue
        state[ALTITUDE, k], state[VX, k], state[VY, k], state[VZ, k] = place(
            radius, low, high, altitude, state[VX, k], state[VY, k], state[VZ, k],
            state[UX, k], state[UY, k], state[UZ, k], mu, way,
        )  # fmt: skip
        marks[SHELL, k], marks[END, k] = shell, hits
        marks[LIVE, index(left)] = k
        for which in range(TURN, N_NUMBER):
            numbers[which, index(left)] = numbers[which, i]
        left += 1
    return left
