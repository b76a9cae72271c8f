"""Columns from nodes of a ray towards the sun, looked up in the tables of their altitudes."""

from __future__ import annotations

import math

import numpy as np

from aomc_sky.kernels.jit import inlined, inner

_ROOT_HALF = np.int64(0x3FE6A09E667F3BCD)  # bits of sqrt(1/2)
_S52 = np.int64(52)


@inlined
def log_level(x):
    """Logarithm of a positive normal number to 1e-9, without a branch: it only says where in a table to look."""
    bits = np.float64(x).view(np.int64)
    power = (bits - _ROOT_HALF) >> _S52
    m = np.int64(bits - (power << _S52)).view(np.float64)
    s = (m - 1.0) / (m + 1.0)
    z = s * s
    odd = (((2.0 / 9.0 * z + 2.0 / 7.0) * z + 2.0 / 5.0) * z + 2.0 / 3.0) * z + 2.0
    return np.float64(power) * 0.6931471805599453 + s * odd


@inner
def towards_sun(cosine_c, sine_c, sun_mu, across, scale, low, inverse_step, at_sun, entry):
    """Cosine of the sun's zenith angle at each node, and where in the node's row of the table it stands."""
    for j in range(at_sun.size):
        mu = cosine_c[j] * sun_mu + sine_c[j] * across
        size = abs(mu)
        at_sun[j] = mu
        y = log_level((size + math.sqrt(size * size + scale[j] * scale[j])) / scale[j])
        entry[j] = (y - low[j]) * inverse_step[j]


@inner
def clear(column):
    """Set to zero, in a loop: numba compiles an assignment to a slice for a second."""
    for part in range(column.size):
        column[part] = 0.0


@inner
def look_up(table, first_row, n_row, entry, share, column):
    """Add `share` times the columns (n_part,) of a rising ray: six points of a node's row of the table."""
    first = min(max(int(entry) - 2, 0), n_row - 6)
    a = entry - first
    b, c, d, e, f = a - 1.0, a - 2.0, a - 3.0, a - 4.0, a - 5.0
    ab, cd, ef = a * b, c * d, e * f
    w0 = -b * cd * ef / 120.0 * share
    w1 = a * cd * ef / 24.0 * share
    w2 = -ab * d * ef / 12.0 * share
    w3 = ab * c * ef / 12.0 * share
    w4 = -ab * cd * f / 24.0 * share
    w5 = ab * cd * e / 120.0 * share
    row = first_row + first
    for part in range(column.size):
        near = w0 * table[row, part] + w1 * table[row + 1, part] + w2 * table[row + 2, part]
        far = w3 * table[row + 3, part] + w4 * table[row + 4, part] + w5 * table[row + 5, part]
        column[part] += near + far


@inner
def panel_of(edge, x):
    """Index of the panel that has x, by halving: numba compiles numpy's search for a second."""
    low, high = 0, edge.size - 1
    while high - low > 1:
        middle = (low + high) // 2
        if edge[middle] <= x:
            low = middle
        else:
            high = middle
    return low


@inner
def add_level(level_edge, level, altitude, column):
    """Add twice the columns of a level ray from an altitude to the top, then change the sign of what was there."""
    panel = panel_of(level_edge, altitude)
    high = level_edge[panel + 1]
    share = max(high - altitude, 0.0) / (high - level_edge[panel])
    x = 2.0 * math.sqrt(share) - 1.0
    for part in range(column.size):
        value = level[panel, part, 0]
        for power in range(1, level.shape[2]):
            value = value * x + level[panel, part, power]
        column[part] = 2.0 * value - column[part]


@inner
def fold(radius, level_edge, level, altitude, sun_mu, column):
    """Turn the columns under abs(sun_mu) into those of a ray that sinks first."""
    sine = math.sqrt((1.0 - sun_mu) * (1.0 + sun_mu))
    lowest = altitude - (radius + altitude) * sun_mu * sun_mu / (1.0 + sine)
    add_level(level_edge, level, max(lowest, 0.0), column)


@inner
def columns_to_sun(
    first, altitude, at_sun, entry, radius, table, row_start, n_row, level_edge, level, column, columns
):  # fmt: skip
    """Fill the columns (n_part, n_node) of the nodes from `first` on; `at_sun` and `entry` are of `towards_sun`."""
    for j in range(first, at_sun.size):
        clear(column)
        look_up(table, row_start[j], n_row[j], entry[j], 1.0, column)
        if at_sun[j] < 0.0:
            fold(radius, level_edge, level, altitude[j], at_sun[j], column)
        for part in range(column.size):
            columns[part, j] = column[part]
