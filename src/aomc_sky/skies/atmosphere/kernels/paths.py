"""Paths of light followed backwards from the ground through spherical shells.

A path starts at the eye, and its first collision is forced. Every vertex in the air or on the ground adds the sun's
light that is turned into the path, weakened by its way (the local estimate). The vertical v of the place, the direction
u and the altitude are its state. The numbers of a step are one block of Philox, addressed by path, step, direction and
wavelength: a path does not depend on other paths.

Some hundred paths go abreast, one kind of work at a time. The numbers can then be made in vectors. While a processor
waits for a root or a table's entry of one path, it works on the next.
"""

from __future__ import annotations

import math

import numpy as np

from aomc_sky.kernels.arithmetic.constants import LOW32, S32, U64
from aomc_sky.kernels.arithmetic.elementary import exp_level, log_level, sin_cos
from aomc_sky.kernels.arithmetic.rng import philox4x32
from aomc_sky.kernels.jit import inlined_no_refcount, no_refcount
from aomc_sky.kernels.phase.scatter import turned
from aomc_sky.skies.atmosphere.kernels.shells import (
    ALBEDO,
    EXTINCTION,
    FIRST_SHARE,
    HIGH,
    LOW,
    RISE,
    depth_to_end,
    draw_angle,
    find_cell,
    index,
    is_hidden,
    march,
    phase_at,
    sun_share,
)

ALTITUDE, VX, VY, VZ, UX, UY, UZ, MU, TO_END, WEIGHT, LEAST, LIGHT, TOTAL = range(13)
N_STATE = 13
"""Rows of the paths' state."""

PATH, LIVE, KIND, CELL, SHELL, END = range(6)
N_MARK = 6
"""Rows of whole numbers: numbers of the paths under way, where their state stands, what scatters them, and the step of
its table; of each state its shell, and 1 where it is on the ground or looks at it."""


@inlined_no_refcount
def settle(state, k, sums, row):
    """Add a path's light of an order, and its square, to the sums."""
    light = state[LIGHT, k]
    if light > 0.0:
        sums[row, 0] += light
        sums[row, 1] += light * light
        state[TOTAL, k] += light
        state[LIGHT, k] = 0.0


_INV32 = 2.0**-32

FLIGHT, TURN, COSINE, SINE, SPARE = range(5)
N_NUMBER = 5
"""Rows of a step's numbers: how far, by what angle, cosine and sine of the azimuth, one more."""


@inlined_no_refcount
def uniform(word):
    """Middle of one of 2^32 parts of (0, 1)."""
    return (np.float64(word) + 0.5) * _INV32


@inlined_no_refcount
def fill_numbers(address, step, path, n, flight, turn, cosine, sine, spare):
    """Numbers of a step of n paths; `flight` is an optical depth, of step 0 the uniform number that it comes from."""
    low, high = address[2] & LOW32, address[2] >> S32
    for i in range(n):
        w0, w1, w2, w3 = philox4x32(U64(path[i]), U64(step), address[0], address[1], low, high)
        x = uniform(w0)
        flight[i] = x if step == 0 else -log_level(x)
        turn[i] = uniform(w1)
        sine[i], cosine[i] = sin_cos(4.0 * uniform(w2))
        spare[i] = uniform(w3)


_ROULETTE, _SHARE = 0.05, 0.5  # of a weight, and of the one that a path starts with: thin air starts all with little


@inlined_no_refcount
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


@inlined_no_refcount
def end_of_way(radius, low, high, altitude, vx, vy, vz, ux, uy, uz, mu, way):
    """Altitude, within two edges, and vertical at the end of a way."""
    r = radius + altitude
    rise = way * (way + 2.0 * r * mu)
    root = math.sqrt(max(r * r + rise, 0.0))
    height = min(max(altitude + rise / (root + r), low), high)
    one = 1.0 / root
    r *= one
    way *= one
    return height, r * vx + way * ux, r * vy + way * uy, r * vz + way * uz


@inlined_no_refcount
def open_path(radius, shells, flight, weight, view, i, numbers, state, marks):
    """Place path i of those abreast at its first collision, which is forced: its weight is the probability of it."""
    end = shells.shape[1]
    passed = -math.log(1.0 - numbers[FLIGHT, i] * weight)
    shell = int(flight[2, index(min(passed / flight[0, end], 1.0) * end)])
    while shell < end - 1 and flight[0, index(shell + 1)] <= passed:
        shell += 1
    extinction = shells[EXTINCTION, index(shell)]
    rest = (passed - flight[0, index(shell)]) / extinction if extinction > 0.0 else 0.0
    altitude, vx, vy, vz = end_of_way(
        radius, shells[LOW, index(shell)], shells[HIGH, index(shell)], 0.0, 0.0, 0.0, 1.0, view[0], view[1], view[2],
        view[2], flight[1, index(shell)] + rest,
    )  # fmt: skip
    marks[LIVE, i], marks[SHELL, i], marks[END, i] = i, shell, 0
    state[ALTITUDE, i], state[VX, i], state[VY, i], state[VZ, i] = altitude, vx, vy, vz
    state[UX, i], state[UY, i], state[UZ, i] = view[0], view[1], view[2]
    state[WEIGHT, i], state[LEAST, i] = weight, min(_ROULETTE, _SHARE * weight)
    state[LIGHT, i], state[TOTAL, i] = 0.0, 0.0


@inlined_no_refcount
def look(scales, shells, table, ground, n, state, marks):
    """Optical depths of the paths' new directions to their ends, and the ground's own light that comes from there."""
    for i in range(n):
        k = index(marks[LIVE, i])
        to_end, hits = depth_to_end(scales, shells, table, state[ALTITUDE, k], marks[SHELL, k], state[MU, k])
        state[TO_END, k], marks[END, k] = to_end, hits
        if hits and ground[1] > 0.0:
            state[LIGHT, k] += state[WEIGHT, k] * ground[1] * exp_level(-to_end)


@inlined_no_refcount
def fly(radius, shells, ground, n, roots, numbers, state, marks, sums, row):
    """Bring paths to their next vertex; those that get out end, the others close up. Return how many are left."""
    left = 0
    for i in range(n):
        k = index(marks[LIVE, i])
        altitude, mu, depth = state[ALTITUDE, k], state[MU, k], numbers[FLIGHT, i]
        hits = marks[END, k] == 1
        low, high = 0.0, 0.0
        if depth < state[TO_END, k]:
            hits = False
            shell, way = march(radius, shells, altitude, marks[SHELL, k], mu, depth, roots)
            if shell < 0:
                settle(state, k, sums, row)
                continue
            low, high = shells[LOW, index(shell)], shells[HIGH, index(shell)]
        elif hits and ground[0] > 0.0:
            q = (radius + altitude) * mu
            c = altitude * (altitude + 2.0 * radius)
            shell, way = 0, c / (math.sqrt(max(q * q - c, 0.0)) - q)
        else:
            settle(state, k, sums, row)
            continue
        state[ALTITUDE, k], state[VX, k], state[VY, k], state[VZ, k] = end_of_way(
            radius, low, high, altitude, state[VX, k], state[VY, k], state[VZ, k],
            state[UX, k], state[UY, k], state[UZ, k], mu, way,
        )  # fmt: skip
        marks[SHELL, k], marks[END, k] = shell, hits
        marks[LIVE, index(left)] = k
        for which in range(TURN, N_NUMBER):
            numbers[which, index(left)] = numbers[which, i]
        left += 1
    return left


_turned = inlined_no_refcount(turned)


@inlined_no_refcount
def light_of_air(shells, phases, shell, ux, uy, uz, sun):
    """Sum over the scatterers of share times phase function between a direction and the sun. [sr-1]"""
    x, y, z = ux - sun[0], uy - sun[1], uz - sun[2]
    t = math.sqrt(math.sqrt(min(0.25 * (x * x + y * y + z * z), 1.0)))
    n = phases.shape[0]
    total = 0.0
    for j in range(n):
        total += shells[FIRST_SHARE + n + j, index(shell)] * phase_at(phases, j, t)
    return total


@inlined_no_refcount
def light_here(scales, shells, table, phases, sun, moon, ground, altitude, shell, vx, vy, vz, ux, uy, uz, on_ground):
    """The sun's light that a vertex turns into the path, for a weight of 1; albedo and irradiance are in it."""
    mu = vx * sun[0] + vy * sun[1] + vz * sun[2]
    if is_hidden(scales[0], altitude, mu):
        return 0.0
    depth, _ = depth_to_end(scales, shells, table, altitude, shell, mu)
    light = ground[0] * max(mu, 0.0) / math.pi
    if not on_ground:
        light = light_of_air(shells, phases, shell, ux, uy, uz, sun)
    light *= exp_level(-depth) * ground[2]
    if moon[3] > 0.0:
        light *= sun_share(scales[0] + altitude, vx, vy, vz, sun, moon)
    return light


@inlined_no_refcount
def light_up(scales, shells, table, phases, sun, moon, ground, n, state, marks):
    """Add the sun's light of the vertices of the paths."""
    for i in range(n):
        k = index(marks[LIVE, i])
        state[LIGHT, k] += state[WEIGHT, k] * light_here(
            scales, shells, table, phases, sun, moon, ground, state[ALTITUDE, k], marks[SHELL, k],
            state[VX, k], state[VY, k], state[VZ, k], state[UX, k], state[UY, k], state[UZ, k], marks[END, k] == 1,
        )  # fmt: skip


@inlined_no_refcount
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


@inlined_no_refcount
def find_cells(shells, phases, guide, n, numbers, marks):
    """Choose what scatters each path, and where in its table: apart from `turn`, which has no search to wait for."""
    for i in range(n):
        k = index(marks[LIVE, i])
        which, cell = 0, 0
        if marks[END, k] == 0:
            which, numbers[SPARE, i] = pick(shells, marks[SHELL, k], phases.shape[0], numbers[SPARE, i])
            cell = find_cell(phases, guide, index(which), numbers[TURN, i])
        marks[KIND, i], marks[CELL, i] = which, cell


@inlined_no_refcount
def turn(shells, phases, ground, n, numbers, state, marks, sums, row):
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
                settle(state, k, sums, row)
                continue
            weight = least
        state[WEIGHT, k] = weight
        x, y, z = _turned(x, y, z, v, sine, c, s)
        state[UX, k], state[UY, k], state[UZ, k] = x, y, z
        state[MU, k] = x * state[VX, k] + y * state[VY, k] + z * state[VZ, k]
        marks[LIVE, index(left)] = k
        left += 1
    return left


ABREAST = 256
"""Most paths that are followed at a time."""


@inlined_no_refcount
def follow(
    scales, shells, table, phases, guide, sun, moon, ground, limits, address, first, n, roots, numbers, state, marks,
    sums,
):  # fmt: skip
    """Follow paths number `first` and on from their first collision to their ends: fills TOTAL.

    `ground`: albedo, own radiance, sun's irradiance; `limits`: most interactions, and rows of `sums`. Each vertex after
    the first fills one row; the first has none, since the sun's order 1 is known. The row also gets what the flight
    from there sees of the ground's own light. The last row has all later ones too.
    """
    step = 1
    while n > 0:
        row = min(step, limits[1]) - 1
        find_cells(shells, phases, guide, n, numbers, marks)
        n = turn(shells, phases, ground, n, numbers, state, marks, sums, row)
        look(scales, shells, table, ground, n, state, marks)
        if step < limits[1] or step >= limits[0]:
            for i in range(n):
                settle(state, index(marks[LIVE, i]), sums, row)
        if step >= limits[0]:
            break
        for i in range(n):
            marks[PATH, i] = first + marks[LIVE, i]
        fill_numbers(
            address, step, marks[PATH], n, numbers[FLIGHT], numbers[TURN], numbers[COSINE], numbers[SINE],
            numbers[SPARE],
        )  # fmt: skip
        n = fly(scales[0], shells, ground, n, roots, numbers, state, marks, sums, row)
        step += 1
        light_up(scales, shells, table, phases, sun, moon, ground, n, state, marks)


@no_refcount
def follow_paths(
    scales, shells, table, phases, guide, sun, moon, ground, limits, address, view, n_paths, flight,
    numbers, state, marks, sums, whole,
):  # fmt: skip
    """Add the light of paths in one direction at one wavelength to `sums` and `whole`.

    `scales`: radius of the ground, and c and s of `table` (n_shell + 1, n + 1), the optical depths. The rows of
    `shells` (FIRST_SHARE + 2 n_scatterer, n_shell) are named in `shells`. Phase functions: `phases` (n_scatterer, n +
    1, 2) has them over t, and their integrals up to there; `guide` int64 (n_scatterer, n) tells where a part of the
    integral lies. Directions: `sun` and `view`, z up at the eye. Philox gets `address` (uint64): direction, wavelength,
    key. The Moon, `moon`, is as for `shells.sun_share`; `ground` and `limits` are as for `follow`.

    `sums` (n_row, 2): light of each order, and its squares. `whole` (3,): light without the sun's order 1, its squares
    and fourth powers. Scratch: `flight` (4, n_shell + 1, at least ROOTS), `numbers` (N_NUMBER,
    ABREAST), `state` (N_STATE, ABREAST), `marks` int64 (N_MARK, ABREAST).
    """
    first_flight(scales[0], shells, view[2], flight)
    weight = -math.expm1(-flight[0, shells.shape[1]])
    for first in range(0, n_paths, ABREAST):
        n = min(ABREAST, n_paths - first)
        for i in range(n):
            marks[PATH, i] = first + i
        fill_numbers(
            address, 0, marks[PATH], n, numbers[FLIGHT], numbers[TURN], numbers[COSINE], numbers[SINE], numbers[SPARE]
        )
        for i in range(n):
            open_path(scales[0], shells, flight, weight, view, i, numbers, state, marks)
        follow(
            scales, shells, table, phases, guide, sun, moon, ground, limits, address, first, n, flight[3], numbers,
            state, marks, sums,
        )  # fmt: skip
        for i in range(n):
            light = state[TOTAL, i]
            whole[0] += light
            whole[1] += light * light
            whole[2] += light * light * (light * light)
