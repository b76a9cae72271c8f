"""Uniform spherical shells as backward paths meet them: optical depths, phase functions, ways, the sun beside the Moon.

A table has the optical depths to the top along rising rays, over the shells' edges and x = n mu (1 + c) / (mu + c).
They have a factor sqrt(mu^2 + s^2), which leaves little of 1/mu. A ray that sinks is folded at its lowest point. Phase
functions are tabulated over t, 1 - mu = 2 t^4, which gives a forward peak most of the nodes.

A line with impact parameter p has the way q = sqrt(a^2 - p^2) from its lowest point to radius a. Its way in a shell is
the difference of two q: one root a shell. For a ray of cosine mu at radius r, a^2 - p^2 is (r mu)^2 + c_a - c, with c =
h (h + 2 R) of an altitude h.
"""

from __future__ import annotations

import math

import numpy as np

from aomc_sky.kernels.jit import inlined_no_refcount, no_refcount
from aomc_sky.skies.atmosphere.kernels.rays import lowest_altitude

_lowest_altitude = inlined_no_refcount(lowest_altitude)

LOW, HIGH, FALL, RISE, EXTINCTION, ALBEDO, INVERSE, FIRST_SHARE = range(8)
"""Rows of the shells: edges, by how much their squared radii are above that of the ground, extinction, single
scattering albedo, one over the thickness; then the cumulated shares of the scatterers, and the part of the extinction
that each scatters."""


@inlined_no_refcount
def index(k):
    """A position in an array, 0 or more, for which no code is made that counts from the end."""
    return np.uintp(np.int64(k))


@inlined_no_refcount
def shell_of(shells, altitude):
    """Index of the shell that has an altitude."""
    low, high = 0, shells.shape[1]
    while high - low > 1:
        middle = (low + high) // 2
        if shells[LOW, index(middle)] <= altitude:
            low = middle
        else:
            high = middle
    return low


@inlined_no_refcount
def rising_depth(shells, table, bend, floor, altitude, shell, mu):
    """Optical depth from a point to the top along a rising ray, bilinear. [mu 0 to 1]"""
    n = table.shape[1] - 1
    x = n * mu * (1.0 + bend) / (mu + bend)
    at = min(int(x), n - 1)
    across = x - at
    i, up, j, on = index(shell), index(shell + 1), index(at), index(at + 1)
    upward = (altitude - shells[LOW, i]) * shells[INVERSE, i]
    below = table[i, j] + across * (table[i, on] - table[i, j])
    above = table[up, j] + across * (table[up, on] - table[up, j])
    return (below + upward * (above - below)) / math.sqrt(mu * mu + floor * floor)


@inlined_no_refcount
def is_hidden(radius, altitude, mu):
    """Whether the ground is in the way of a direction."""
    return mu < 0.0 and _lowest_altitude(radius, altitude, mu) < 0.0


@inlined_no_refcount
def depth_to_end(scales, shells, table, altitude, shell, mu):
    """Optical depth along a ray to where it ends, and whether that is the ground. Scales: radius, and c and s."""
    radius, bend, floor = scales
    rising = rising_depth(shells, table, bend, floor, altitude, shell, abs(mu))
    hits = False
    if mu < 0.0:
        lowest = _lowest_altitude(radius, altitude, mu)
        hits = lowest < 0.0
        turning = 0.0 if hits else lowest
        at = 0 if hits else shell_of(shells, lowest)
        at_ground = math.sqrt(max(-lowest * (lowest + 2.0 * radius), 0.0)) / radius
        whole = rising_depth(shells, table, bend, floor, turning, at, min(at_ground, 1.0) if hits else 0.0)
        rising = max((whole if hits else 2.0 * whole) - rising, 0.0)
    return rising, hits


@inlined_no_refcount
def phase_at(phases, which, t):
    """Phase function of a scatterer at t, linear between the nodes of its table."""
    n = phases.shape[1] - 1
    x = t * n
    at = min(int(x), n - 1)
    j, on = index(at), index(at + 1)
    return phases[which, j, 0] + (x - at) * (phases[which, on, 0] - phases[which, j, 0])


@inlined_no_refcount
def find_cell(phases, guide, which, xi):
    """Step of a phase function's table that has a share of its integral."""
    last = phases.shape[1] - 2
    target = xi * phases[which, index(last + 1), 1]
    at = guide[which, index(xi * guide.shape[1])]
    while at < last and phases[which, index(at + 1), 1] <= target:
        at += 1
    return at


@inlined_no_refcount
def draw_angle(phases, which, at, xi):
    """Place t of a scattering angle in a cell, and the weight that makes it the phase function's own law.

    Drawn from a density linear in t between the nodes' 16 pi t^3 p; the weight is the interpolated phase function
    over it, 1 but for some parts in 1e5.
    """
    n = phases.shape[1] - 1
    whole = phases[which, index(n), 1]
    j, on = index(at), index(at + 1)
    step = 1.0 / n
    low, high = at * step, (at + 1) * step
    p, q = phases[which, j, 0], phases[which, on, 0]
    f = p * low * low * low
    g = q * high * high * high
    rest = (xi * whole - phases[which, j, 1]) * (n / (16.0 * math.pi))  # f x + (g - f) x^2 / 2
    root = math.sqrt(max(f * f + 2.0 * (g - f) * rest, 0.0))
    x = min(2.0 * rest / (f + root), 1.0) if f + root > 0.0 else 0.0
    t = low + x * step
    law = f + x * (g - f)
    share = whole * (p + x * (q - p)) * t * t * t / law
    return t, share if law > 0.0 else 0.0


@inlined_no_refcount
def visible_share(sun_radius, moon_radius, apart):
    """Share of a uniform disc that another leaves free; angular radii and distance of centres. [rad]"""
    if apart >= sun_radius + moon_radius:
        return 1.0
    if apart <= abs(sun_radius - moon_radius):
        return 0.0 if moon_radius >= sun_radius else 1.0 - (moon_radius / sun_radius) ** 2
    a = (apart * apart + sun_radius * sun_radius - moon_radius * moon_radius) / (2.0 * apart)
    b = apart - a
    height = math.sqrt(max(sun_radius * sun_radius - a * a, 0.0))
    lens = sun_radius * sun_radius * math.atan2(height, a) + moon_radius * moon_radius * math.atan2(height, b)
    return min(max(1.0 - (lens - apart * height) / (math.pi * sun_radius * sun_radius), 0.0), 1.0)


@inlined_no_refcount
def sun_share(r, vx, vy, vz, sun, moon):
    """Visible share of the sun from the point r v; moon: x, y, z of its centre, its radius, the sun's angular one."""
    if moon[3] <= 0.0:
        return 1.0
    x, y, z = moon[0] - r * vx, moon[1] - r * vy, moon[2] - r * vz
    distance = math.sqrt(x * x + y * y + z * z)
    cx, cy, cz = y * sun[2] - z * sun[1], z * sun[0] - x * sun[2], x * sun[1] - y * sun[0]
    along = x * sun[0] + y * sun[1] + z * sun[2]
    apart = math.atan2(math.sqrt(cx * cx + cy * cy + cz * cz), along)
    return visible_share(moon[4], math.asin(min(moon[3] / distance, 1.0)), apart)


@no_refcount
def fill_sun_share(r, vertical, sun, moon, share):
    """`sun_share` of n points; vertical (3, n)."""
    for k in range(share.size):
        share[k] = sun_share(r[k], vertical[0, k], vertical[1, k], vertical[2, k], sun, moon)


ROOTS = 16
"""Shells whose roots are taken at a time."""


@inlined_no_refcount
def march(radius, shells, altitude, shell, mu, depth, roots):
    """Shell and way at which a ray from a point has passed `depth`; shell -1 where the top or the ground is first.

    `roots` (ROOTS or more,) is scratch. The depths of the shells are taken off one by one.
    """
    start = (radius + altitude) * mu
    base = start * start - altitude * (altitude + 2.0 * radius)
    q = start
    sinks = mu < 0.0
    while sinks:
        stop = max(shell - ROOTS, -1)
        for k in range(stop + 1, shell + 1):  # roots are what takes the time: in vectors
            roots[index(k - stop - 1)] = math.sqrt(max(base + shells[FALL, index(k)], 0.0))
        while shell > stop:
            onward = -roots[index(shell - stop - 1)]
            if onward == 0.0:  # the ray is lowest in this shell
                sinks = False
                break
            left = depth - (onward - q) * shells[EXTINCTION, index(shell)]
            if left <= 0.0:
                return shell, q - start + depth / shells[EXTINCTION, index(shell)]
            depth = left
            q = onward
            shell -= 1
        if shell < 0:
            return -1, q - start
    at, end = shell, shells.shape[1]
    while at < end:
        stop = min(at + ROOTS, end)
        for k in range(at, stop):
            roots[index(k - at)] = math.sqrt(max(base + shells[RISE, index(k)], 0.0))
        for k in range(at, stop):
            onward = roots[index(k - at)]
            left = depth - (onward - q) * shells[EXTINCTION, index(k)]
            if left <= 0.0:
                return k, q - start + depth / shells[EXTINCTION, index(k)]
            depth = left
            q = onward
        at = stop
    return -1, q - start
