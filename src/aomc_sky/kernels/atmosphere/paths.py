"""Paths of light followed backwards from the ground through spherical shells.

A path starts at the eye, where its first collision is forced; at every vertex in the air or on the ground the sun's
light that would be turned into the path is added, weakened by its way (the local estimate). The vertical v of the
place, the direction u and the altitude are its state. The numbers of a step are one block of Philox, addressed by
path, step, direction and wavelength: no path knows which others are followed, or by whom.

Some hundred paths go abreast, one kind of work at a time: numbers are made in vectors, and a processor works on the
next path while a root or a table's entry of this one is under way.
"""

from __future__ import annotations

import math

from aomc_sky.kernels.atmosphere.path_steps import (
    COSINE,
    FLIGHT,
    LIGHT,
    LIVE,
    ONCE,
    PATH,
    SINE,
    SPARE,
    TOTAL,
    TURN,
    fill_numbers,
    find_cells,
    first_flight,
    fly,
    light_up,
    look,
    open_path,
    settle,
    turn,
)
from aomc_sky.kernels.atmosphere.shells import index
from aomc_sky.kernels.jit import inlined_reader, reader

ABREAST = 256
"""Most paths that are followed at a time."""


@inlined_reader
def follow(
    scales, shells, table, phases, guide, sun, moon, ground, limits, address, first, n, numbers, state, marks, sums,
    block,
):  # fmt: skip
    """Follow paths number `first` and on from their first collision to their ends: fills TOTAL and ONCE.

    `ground`: albedo, own radiance, sun's irradiance; `limits`: most interactions, rows of `sums`, and which
    paths count for the sun's order 1: every so many. A row is filled by one vertex, and by what the flight from there
    sees of the ground's own light; the last row has all later ones too.
    """
    step = 1
    light_up(
        scales, shells, table, phases, sun, moon, ground, -first % limits[2], limits[2], n, state, marks
    )  # fmt: skip
    for k in range(n):
        state[ONCE, k], state[LIGHT, k] = state[LIGHT, k], 0.0
    while n > 0:
        row = min(step, limits[1]) - 1
        find_cells(shells, phases, guide, n, numbers, marks)
        n = turn(shells, phases, ground, n, numbers, state, marks, sums, block, row)
        look(scales, shells, table, ground, n, state, marks)
        if step < limits[1] or step >= limits[0]:
            for i in range(n):
                settle(state, index(marks[LIVE, i]), sums, block, row)
        if step >= limits[0]:
            break
        for i in range(n):
            marks[PATH, i] = first + marks[LIVE, i]
        fill_numbers(
            address, step, marks[PATH], n, numbers[FLIGHT], numbers[TURN], numbers[COSINE], numbers[SINE],
            numbers[SPARE],
        )  # fmt: skip
        n = fly(scales[0], shells, ground, n, numbers, state, marks, sums, block, row)
        step += 1
        light_up(scales, shells, table, phases, sun, moon, ground, 0, 1, n, state, marks)


@reader
def follow_paths(
    scales, shells, table, phases, guide, sun, moon, ground, limits, address, view, n_paths, block, flight, numbers,
    state, marks, sums, whole,
):  # fmt: skip
    """Add the light of blocks of paths in one direction at one wavelength to `sums` and `whole`.

    `scales`: radius of the ground, and c and s of `table` (n_shell + 1, n + 1), the optical depths. The rows of
    `shells` (FIRST_SHARE + 2 n_scatterer, n_shell) are named in `shells`. `phases` (n_scatterer, n + 1, 2): phase
    functions over t, and their integrals up to there; `guide` int64 (n_scatterer, n): where a part of the integral
    lies. `sun`, `view`: directions, z up at the eye; `moon` as for `shells.sun_share`; `ground`, `limits` as for
    `follow`; `address` (uint64): direction, wavelength, key. A row of the sums has `block` paths, a multiple of
    `ABREAST`.

    `sums` (n_block, n_row, 2): light of each order, and its squares. `whole` (n_block, 6): light without the sun's
    order 1, its squares, greatest; the same of that order from the paths that count for it. Scratch: `flight` (3,
    n_shell + 1), `numbers` (N_NUMBER, ABREAST), `state` (N_STATE, ABREAST), `marks` int64 (N_MARK, ABREAST).
    """
    first_flight(scales[0], shells, view[2], flight)
    weight = -math.expm1(-flight[0, shells.shape[1]])
    for first in range(0, n_paths, ABREAST):
        row, n = first // block, min(ABREAST, n_paths - first)
        for i in range(n):
            marks[PATH, i] = first + i
        fill_numbers(
            address, 0, marks[PATH], n, numbers[FLIGHT], numbers[TURN], numbers[COSINE], numbers[SINE], numbers[SPARE]
        )
        for i in range(n):
            open_path(scales[0], shells, flight, weight, view, i, numbers, state, marks)
        follow(
            scales, shells, table, phases, guide, sun, moon, ground, limits, address, first, n, numbers, state, marks,
            sums, row,
        )  # fmt: skip
        for i in range(n):
            light, once = state[TOTAL, i], state[ONCE, i]
            whole[row, 0] += light
            whole[row, 1] += light * light
            whole[row, 2] = max(whole[row, 2], light)
            whole[row, 3] += once
            whole[row, 4] += once * once
            whole[row, 5] = max(whole[row, 5], once)


@reader
def follow_each(
    scales, shells, table, phases, guide, sun, moon, ground, limits, first, address, view, flight, numbers, state,
    marks, sums, light,
):  # fmt: skip
    """Fill `light` (n, 2) with that of one path in each direction of `view` (n, 3), z up at the eye.

    Its columns are the light without the sun's order 1, and that order where it counts, else 0. `limits`: most
    interactions, 1, and which directions count for the sun's order 1: every so many by their numbers, which begin with
    `first` [to 2^32 - 1]. `address` (uint64): stream, wavelength, key. `sums` (1, 1, 2) is scratch; the other
    parameters are those of `follow_paths`.
    """
    for start in range(0, view.shape[0], ABREAST):
        n = min(ABREAST, view.shape[0] - start)
        for i in range(n):
            marks[PATH, i] = first + start + i
        fill_numbers(
            address, 0, marks[PATH], n, numbers[FLIGHT], numbers[TURN], numbers[COSINE], numbers[SINE], numbers[SPARE]
        )
        for i in range(n):
            here = (view[start + i, 0], view[start + i, 1], view[start + i, 2])
            first_flight(scales[0], shells, here[2], flight)
            weight = -math.expm1(-flight[0, shells.shape[1]])
            open_path(scales[0], shells, flight, weight, here, i, numbers, state, marks)
        follow(
            scales, shells, table, phases, guide, sun, moon, ground, limits, address, first + start, n, numbers, state,
            marks, sums, 0,
        )  # fmt: skip
        for i in range(n):
            light[start + i, 0], light[start + i, 1] = state[TOTAL, i], state[ONCE, i]
