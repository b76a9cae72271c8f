"""Paths of light followed backwards from the ground through spherical shells.

A path starts at the eye, where its first collision is forced; at every vertex in the air or on the ground the sun's
light that would be turned into the path is added, weakened by its way (the local estimate). The vertical v of the
place, the direction u and the altitude are its state. The numbers of a step are one block of Philox, addressed by
path, step, direction and wavelength: no path knows which others are followed, or by whom.
"""

from __future__ import annotations

import math

import numpy as np

from aomc_sky.kernels.backward_light import depth_to_end, draw_angle, phase_at, sun_share
from aomc_sky.kernels.backward_march import march
from aomc_sky.kernels.jit import inner, kernel
from aomc_sky.kernels.march_order_one import panel_of
from aomc_sky.kernels.rng import philox4x32
from aomc_sky.kernels.scatter import new_direction

_U64 = np.uint64
_LOW = np.uint64(0xFFFFFFFF)
_S32 = np.uint64(32)
_INV32 = 2.0**-32
_ROULETTE = 0.05

N_WHOLE = 6
"""Sums of a block: light without the sun's order 1, its squares, greatest; the same of the sun's order 1."""


@inner
def uniform(word):
    """Middle of one of 2^32 parts of (0, 1)."""
    return (np.float64(word) + 0.5) * _INV32


@inner
def first_flight(radius, edge, gap, extinction, mu, depth, way):
    """Optical depth and way of a ray from the ground to each edge."""
    start = radius * mu
    q = start
    depth[0] = 0.0
    way[0] = 0.0
    for k in range(extinction.size):
        onward = math.sqrt(start * start + edge[k + 1] * (edge[k + 1] + 2.0 * radius))
        length = gap[k] / (q + onward)
        way[k + 1] = way[k] + length
        depth[k + 1] = depth[k] + length * extinction[k]
        q = onward


@inner
def forced(sphere, column, depth, way, xi):
    """Shell, way and weight of the first collision, which is forced: `depth` and `way` are those of the eye's ray."""
    last = depth.size - 1
    weight = -math.expm1(-depth[last])
    passed = -math.log1p(-xi * weight)
    shell = min(panel_of(depth, passed), last - 1)
    if column[0][shell] <= 0.0:
        return shell, way[shell], weight
    return shell, way[shell] + (passed - depth[shell]) / column[0][shell], weight


@inner
def fly(sphere, column, altitude, shell, mu, to_end, hits, xi):
    """Shell and way of the next collision, and whether it is with the ground; shell -1 where light is gone."""
    depth = -math.log(xi)
    if depth < to_end:
        found, way = march(sphere[0], sphere[1], sphere[2], column[0], altitude, shell, mu, depth)
        return found, way, False
    if not hits:
        return -1, 0.0, False
    q = (sphere[0] + altitude) * mu
    c = altitude * (altitude + 2.0 * sphere[0])
    return 0, c / (math.sqrt(max(q * q - c, 0.0)) - q), True


@inner
def place(radius, edge, altitude, vx, vy, vz, ux, uy, uz, mu, way, shell, on_ground):
    """Altitude and vertical at the end of a way."""
    r = radius + altitude
    rise = way * (way + 2.0 * r * mu)
    root = math.sqrt(max(r * r + rise, 0.0))
    found = 0.0 if on_ground else min(max(altitude + rise / (root + r), edge[shell]), edge[shell + 1])
    return found, (r * vx + way * ux) / root, (r * vy + way * uy) / root, (r * vz + way * uz) / root


@inner
def light_of_air(column, scatterers, shell, ux, uy, uz, sun):
    """Sum over the scatterers of share times phase function between a direction and the sun. [sr-1]"""
    x, y, z = ux - sun[0], uy - sun[1], uz - sun[2]
    t = math.sqrt(math.sqrt(min(0.25 * (x * x + y * y + z * z), 1.0)))
    total = 0.0
    for j in range(scatterers[0].shape[0]):
        total += column[3][shell, j] * phase_at(scatterers[0], j, t)
    return total


@inner
def light_here(sphere, column, scatterers, sun, moon, ground, altitude, shell, vx, vy, vz, ux, uy, uz, on_ground):
    """The sun's light that a vertex turns into the path, for a weight of 1; albedo and irradiance are in it."""
    mu = vx * sun[0] + vy * sun[1] + vz * sun[2]
    depth, hits = depth_to_end(sphere[0], sphere[1], column[4], column[5][0], column[5][1], altitude, shell, mu)
    if hits or (on_ground and mu <= 0.0):
        return 0.0
    if on_ground:
        light = ground[0] * mu / math.pi
    else:
        light = light_of_air(column, scatterers, shell, ux, uy, uz, sun)
    return light * math.exp(-depth) * ground[2] * sun_share(sphere[0] + altitude, vx, vy, vz, sun, moon)


@inner
def pick(cumulated, shell, xi):
    """Scatterer by its share, and what is left of the number as a new one."""
    low = 0.0
    for j in range(cumulated.shape[1] - 1):
        if xi < cumulated[shell, j]:
            return j, (xi - low) / (cumulated[shell, j] - low)
        low = cumulated[shell, j]
    return cumulated.shape[1] - 1, (xi - low) / (1.0 - low)


@inner
def commit(sums, row, value):
    """Add one path's light of an order, and its square."""
    sums[row, 0] += value
    sums[row, 1] += value * value


@inner
def turn(column, scatterers, shell, vx, vy, vz, ux, uy, uz, on_ground, words):
    """New direction after a vertex, the weight it has there, and a number that is left over."""
    xi = uniform(words[1])
    if on_ground:
        x, y, z = new_direction(vx, vy, vz, 1.0 - math.sqrt(xi), math.sqrt(1.0 - xi), uniform(words[2]))
        return x, y, z, 1.0, uniform(words[3])
    which, spare = pick(column[2], shell, uniform(words[3]))
    t, share = draw_angle(scatterers[0], scatterers[1], scatterers[2], which, xi)
    v = 2.0 * t * t * t * t
    x, y, z = new_direction(ux, uy, uz, v, math.sqrt(v * (2.0 - v)), uniform(words[2]))
    return x, y, z, column[1][shell] * share, spare


@inner
def follow(sphere, column, scatterers, sun, moon, ground, limits, address, view, depth, way_to, sums):
    """One path: its light without the sun's order 1, and that.

    `ground`: albedo, own radiance, sun's irradiance; `limits`: most interactions, rows of `sums`. A row is filled by
    one vertex, and by what the flight from there sees of the ground's own light; the last row has all later ones too.
    """
    radius, edge = sphere[0], sphere[1]
    vx, vy, vz, ux, uy, uz = 0.0, 0.0, 1.0, view[0], view[1], view[2]
    altitude, shell, weight, way, on_ground = 0.0, 0, 1.0, 0.0, False
    total, once, light = 0.0, 0.0, 0.0
    step = 0
    while True:
        words = philox4x32(address[0], _U64(step), address[1], address[2], address[3] & _LOW, address[3] >> _S32)
        mu = vx * ux + vy * uy + vz * uz
        if step == 0:
            shell, way, weight = forced(sphere, column, depth, way_to, uniform(words[0]))
        else:
            to_end, hits = depth_to_end(radius, edge, column[4], column[5][0], column[5][1], altitude, shell, mu)
            if hits and ground[1] > 0.0:
                light += weight * ground[1] * math.exp(-to_end)
            if step < limits[1]:
                commit(sums, step - 1, light)
                total += light
                light = 0.0
            if step >= limits[0]:
                break
            shell, way, on_ground = fly(sphere, column, altitude, shell, mu, to_end, hits, uniform(words[0]))
            if shell < 0:
                break
        altitude, vx, vy, vz = place(radius, edge, altitude, vx, vy, vz, ux, uy, uz, mu, way, shell, on_ground)
        step += 1
        here = weight * light_here(
            sphere, column, scatterers, sun, moon, ground, altitude, shell, vx, vy, vz, ux, uy, uz, on_ground
        )
        if step == 1:
            once = here
        else:
            light += here
        ux, uy, uz, share, spare = turn(column, scatterers, shell, vx, vy, vz, ux, uy, uz, on_ground, words)
        weight *= ground[0] if on_ground else share
        if weight < _ROULETTE:
            if spare * _ROULETTE >= weight:
                break
            weight = _ROULETTE
    if light != 0.0:
        commit(sums, min(step, limits[1]) - 1, light)
    return total + light, once


@kernel
def follow_paths(
    sphere, column, scatterers, sun, moon, ground, limits, address, view, first_path, n_paths, block, sums, whole
):  # fmt: skip
    """Sums over blocks of paths in one direction at one wavelength.

    Parameters
    ----------
    sphere : tuple
        Radius of the ground, edges (n_shell + 1,), difference of the squared radii of each shell.
    column : tuple
        Of each shell: extinction, single scattering albedo, cumulated shares of the scatterers and their scattering
        over extinction (n_shell, n_scatterer); table of optical depths (n_shell + 1, n + 1), and its c and s.
    scatterers : tuple
        Phase functions over t (n_scatterer, n + 1), their cumulated integrals, and where to look in them.
    sun, view : tuple of 3 float
        Directions, z up at the eye.
    moon, ground, limits : tuple
        See `backward_light.sun_share` and `follow`.
    address : tuple of 3 uint64
        Direction, wavelength, key.
    first_path, n_paths, block : int
        Paths, and how many stand in one row of the sums.
    sums : ndarray, float64, shape (n_block, n_row, 2)
        Light of each order and its squares; filled.
    whole : ndarray, float64, shape (n_block, N_WHOLE)
        Filled.
    """
    depth, way = np.empty(sphere[1].size), np.empty(sphere[1].size)
    first_flight(sphere[0], sphere[1], sphere[2], column[0], view[2], depth, way)
    for k in range(n_paths):
        row = k // block
        path = _U64(first_path + k)
        place_of = (path, address[0], address[1], address[2])
        light, once = follow(
            sphere, column, scatterers, sun, moon, ground, limits, place_of, view, depth, way, sums[row]
        )
        into = whole[row]
        into[0] += light
        into[1] += light * light
        into[2] = max(into[2], light)
        into[3] += once
        into[4] += once * once
        into[5] = max(into[5], once)
