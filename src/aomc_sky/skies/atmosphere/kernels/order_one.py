"""Light scattered once on its way to the ground, by quadrature along straight rays.

All rays have their nodes at the same altitudes, so densities and the table of the sun's columns are read, not searched
for. In a panel between two altitudes the variable is u = sqrt(altitude): along a level ray the way is smooth in it. The
depth from a node to the eye is the integral of the polynomial through the extinction, panel by panel. A panel is cut
where the ray leaves the earth's shadow, and where the sun's ray ceases to touch a kink of the densities. The pieces
have nodes of their own, to which those of the panel are interpolated.
"""

from __future__ import annotations

import math

import numpy as np

from aomc_sky.kernels.arithmetic.elementary import exp_level
from aomc_sky.kernels.jit import inlined, inner, kernel
from aomc_sky.skies.atmosphere.kernels.rays import lowest_altitude, way_from_ground

_lowest_altitude = inlined(lowest_altitude)
_way_from_ground = inlined(way_from_ground)

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
def fold(radius, level_edge, level, altitude, sun_mu, column):
    """Turn the columns under abs(sun_mu) into those of a ray that sinks first: twice level ones, less these."""
    lowest = max(_lowest_altitude(radius, altitude, sun_mu), 0.0)
    panel = panel_of(level_edge, lowest)
    high = level_edge[panel + 1]
    share = max(high - lowest, 0.0) / (high - level_edge[panel])
    x = 2.0 * math.sqrt(share) - 1.0
    for part in range(column.size):
        value = level[panel, part, 0]
        for power in range(1, level.shape[2]):
            value = value * x + level[panel, part, power]
        column[part] = 2.0 * value - column[part]


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


@inner
def root_above(radius, mu, sun_mu, scattering_mu, touched):
    """Root of the altitude beyond which the sun's ray to a point of a ray from the ground stays above `touched`.

    The points whose ray to a sinking sun touches one altitude form a half cylinder round the earth's shadow. The way to
    it is the root of s^2 sin^2(angle to the sun) + 2 s R (mu - sun_mu scattering_mu) = (R sun_mu)^2 + h (h + 2 R).
    Infinite if the ray does not meet it, or only where the sun does not sink any more.
    """
    across = (1.0 - scattering_mu) * (1.0 + scattering_mu)
    slope = radius * (mu - sun_mu * scattering_mu)
    c = radius * radius * sun_mu * sun_mu + touched * (touched + 2.0 * radius)
    root = math.sqrt(slope * slope + across * c)
    if slope >= 0.0:
        way = c / (slope + root) if slope + root > 0.0 else math.inf
    else:
        way = (root - slope) / across if across > 0.0 else math.inf
    if way == math.inf or radius * sun_mu + way * scattering_mu >= 0.0:
        return math.inf
    q = way * (way + 2.0 * radius * mu)
    return math.sqrt(q / (math.sqrt(radius * radius + q) + radius))


@inner
def place_node(radius, u, mu, sine):
    """Altitude of a node of a ray from the ground, cosine and sine of its angle at the earth's centre, ds/du."""
    altitude = u * u
    way, root = _way_from_ground(radius, mu, altitude)
    r = radius + altitude
    return altitude, (radius + way * mu) / r, way * sine / r, 2.0 * u * r / root


@inner
def walk(radius, u_edge, node, weight, cumulative, mu, sine, extinction, altitude, cosine_c, sine_c, path, depth):
    """Nodes of one ray: altitudes, angles at the earth's centre, quadrature weights, optical depth to the eye.

    `extinction` is (n_wl, n_node) at the nodes, `depth` of the same shape is filled.
    """
    k = node.size
    for panel in range(u_edge.size - 1):
        half = 0.5 * (u_edge[panel + 1] - u_edge[panel])
        centre = 0.5 * (u_edge[panel + 1] + u_edge[panel])
        for j in range(k):
            at = panel * k + j
            found = place_node(radius, centre + half * node[j], mu, sine)
            altitude[at] = found[0]
            cosine_c[at] = found[1]
            sine_c[at] = found[2]
            path[at] = half * found[3]
    for row in range(depth.shape[0]):
        passed = 0.0
        for panel in range(u_edge.size - 1):
            first = panel * k
            whole = 0.0
            for j in range(k):
                part = 0.0
                for other in range(k):
                    part += cumulative[j, other] * extinction[row, first + other] * path[first + other]
                depth[row, first + j] = passed + part
                whole += weight[j] * extinction[row, first + j] * path[first + j]
            passed += whole
    for panel in range(u_edge.size - 1):
        for j in range(k):
            path[panel * k + j] *= weight[j]


@inner
def basis(node, inverse_gap, x, share):
    """Lagrange's polynomials of the nodes at x; `inverse_gap` are one over the products of a node's distances."""
    below = 1.0
    for j in range(node.size):
        share[j] = below * inverse_gap[j]
        below *= x - node[j]
    above = 1.0
    for j in range(node.size - 1, -1, -1):
        share[j] *= above
        above *= x - node[j]


@inner
def add_light(first, depth, columns, size, path, density, scatterer, light, out):
    """Add the integrals (n_scatterer,) over nodes from `first` on at one wavelength; `size` are its cross sections."""
    for j in range(first, light.size):
        light[j] = depth[j]
    for part in range(size.size):
        here = size[part]
        for j in range(first, light.size):
            light[j] += here * columns[part, j]
    for j in range(first, light.size):
        light[j] = path[j] * exp_level(-light[j])
    for k in range(scatterer.size):
        which = scatterer[k]
        even = 0.0
        odd = 0.0
        last = light.size - (light.size - first) % 2
        for j in range(first, last, 2):
            even += light[j] * density[which, j]
            odd += light[j + 1] * density[which, j + 1]
        for j in range(last, light.size):
            even += light[j] * density[which, j]
        out[k] += even + odd


@inner
def add_stretch(
    radius, u_edge, node, weight, inverse_gap, panel, u_low, u_high, is_bent, mu, sine, sun_mu, sun_across,
    density, depth, extinction, table, row_start, n_row, scale, low, inverse_step, level_edge, level, scatterer,
    share, column, out,
):  # fmt: skip
    """Add part of a panel, with nodes of its own, to out (n_wl, n_scatterer).

    A stretch may end where the sun's ray touches a kink. There the light bends like a root, or a power of one. With
    `is_bent` the variable is the root of the distance to the end.
    """
    k = node.size
    first = panel * k
    middle = 0.5 * (u_edge[panel + 1] + u_edge[panel])
    for q in range(k):
        t = 0.5 * (1.0 - node[q])
        turn = 0.5 * weight[q] * (u_high - u_low)
        if is_bent:
            turn *= 2.0 * t
            t *= t
        u = u_high - (u_high - u_low) * t
        basis(node, inverse_gap, 2.0 * (u - middle) / (u_edge[panel + 1] - u_edge[panel]), share)
        altitude, cosine_c, sine_c, way = place_node(radius, u, mu, sine)
        at_sun = cosine_c * sun_mu + sine_c * sun_across
        entry = (math.asinh(abs(at_sun) / scale[first]) - low[first]) * inverse_step[first]
        clear(column)
        for j in range(first, first + k):
            look_up(table, row_start[j], n_row[j], entry, share[j - first], column)
        if at_sun < 0.0:
            fold(radius, level_edge, level, altitude, at_sun, column)
        for row in range(depth.shape[0]):
            passed = 0.0
            for j in range(k):
                passed += share[j] * depth[row, first + j]
            for part in range(column.size):
                passed += extinction[row, part] * column[part]
            light = turn * way * math.exp(-passed)
            for part in range(scatterer.size):
                here = 0.0
                for j in range(k):
                    here += share[j] * density[scatterer[part], first + j]
                out[row, part] += here * light


@inner
def find_breaks(radius, u_end, mu, sun_mu, scattering_mu, kink, breaks):
    """Fill `breaks` with where the sun's ray begins to clear the ground and each kink; return how many there are.

    Infinite for the ground is the night, minus 1 a sun that nowhere is behind it.
    """
    breaks[0] = -1.0
    if sun_mu < 0.0:
        breaks[0] = root_above(radius, mu, sun_mu, scattering_mu, 0.0)
    n = 1
    for k in range(kink.size):
        u = root_above(radius, mu, sun_mu, scattering_mu, kink[k])
        if u < u_end and u > breaks[0]:
            breaks[n] = u
            n += 1
    return n


@inner
def add_broken_panels(
    radius, u_edge, node, weight, inverse_gap, breaks, n_breaks, live, mu, sine, sun_mu, sun_across,
    density, depth, extinction, table, row_start, n_row, scale, low, inverse_step, level_edge, level, scatterer,
    share, column, out,
):  # fmt: skip
    """Add the stretches of the panels that have breaks of `find_breaks`, whose nodes count no more in `live`.

    Returns the first node that may be in the sun.
    """
    k = node.size
    lit = 0
    if breaks[0] >= 0.0:
        lit = panel_of(u_edge, breaks[0]) * k
    for at in range(n_breaks):
        panel = panel_of(u_edge, breaks[at])
        if breaks[at] < 0.0:
            continue
        if at == 0:
            start = math.inf
        elif breaks[at - 1] > u_edge[panel]:
            start = breaks[at - 1]
        else:
            start = u_edge[panel]
        end = u_edge[panel + 1]
        for j in range(panel * k, panel * k + k):
            live[j] = 0.0
        for step in range(2):
            is_last = step == 1
            if is_last and at + 1 < n_breaks and breaks[at + 1] < end:
                continue
            u_low = breaks[at] if is_last else start
            u_high = end if is_last else breaks[at]
            if u_low < u_high:
                add_stretch(
                    radius, u_edge, node, weight, inverse_gap, panel, u_low, u_high, not is_last,
                    mu, sine, sun_mu, sun_across,
                    density, depth, extinction, table, row_start, n_row, scale, low, inverse_step,
                    level_edge, level, scatterer, share, column, out,
                )  # fmt: skip
    return lit


@kernel
def fill_order_one(
    radius, u_edge, kink, node, weight, cumulative, inverse_gap, density, extinction, mixed, scatterer,
    sun_mu, sun_sine,
    table, row_start, n_row, scale, low, inverse_step, level_edge, level,
    ray_mu, ray_sine, ray_start, cos_azimuth, out,
):  # fmt: skip
    """Add to out (n, n_wl, n_scatterer) the integrals of density times transmission from sun to eye. [m-2]

    radius of the ground [m]; u_edge (n_panel + 1,): roots of the altitudes between panels [m^0.5]; kink (n_kink,):
    altitudes where densities jump or bend, rising [m]. node, weight (k,): Gauss rule on [-1, 1]; cumulative (k, k):
    integrals from -1 to each node of the polynomials that are 1 at one node; inverse_gap (k,): one over the product of
    each node's distances to the others. density (n_part, n_panel k) at the nodes; extinction (n_wl, n_part): cross
    sections; mixed (n_wl, n_panel k): extinction of all parts together at the nodes; scatterer (n_scatterer,): which
    parts scatter. sun_mu, sun_sine: of the sun's zenith angle at the observer.

    table (n_entry, n_part), with row_start, n_row, scale, low, inverse_step (n_node,): columns from each node to the
    top under mu = scale sinh(low + i / inverse_step), i from 0 to n_row - 1. level_edge (n_level + 1,), level (n_level,
    n_part, n_coefficient): columns of level rays as polynomials of 2 sqrt((high - altitude)/(high - low)) - 1. ray_mu,
    ray_sine (n_ray,): zenith angles; ray_start (n_ray + 1,): the range of directions of each; cos_azimuth (n,): from
    the sun.
    """
    k = node.size
    n_part, n_node = density.shape
    n_wl = extinction.shape[0]
    altitude, cosine_c, sine_c, path = np.empty(n_node), np.empty(n_node), np.empty(n_node), np.empty(n_node)
    at_sun, entry, light = np.empty(n_node), np.empty(n_node), np.empty(n_node)
    depth = np.empty((n_wl, n_node))
    columns = np.zeros((n_part, n_node))
    column = np.empty(n_part)
    live = np.empty(n_node)
    breaks = np.empty(kink.size + 1)
    share = np.empty(k)
    for ray in range(ray_mu.size):
        mu = ray_mu[ray]
        sine = ray_sine[ray]
        walk(radius, u_edge, node, weight, cumulative, mu, sine, mixed, altitude, cosine_c, sine_c, path, depth)
        for d in range(ray_start[ray], ray_start[ray + 1]):
            across = sun_sine * cos_azimuth[d]
            n_breaks = find_breaks(radius, u_edge[-1], mu, sun_mu, mu * sun_mu + sine * across, kink, breaks)
            if not breaks[0] < u_edge[-1]:
                continue
            for j in range(n_node):
                live[j] = path[j]
            lit = add_broken_panels(
                radius, u_edge, node, weight, inverse_gap, breaks, n_breaks, live, mu, sine, sun_mu, across,
                density, depth, extinction, table, row_start, n_row, scale, low, inverse_step, level_edge, level,
                scatterer, share, column, out[d],
            )  # fmt: skip
            towards_sun(cosine_c, sine_c, sun_mu, across, scale, low, inverse_step, at_sun, entry)
            columns_to_sun(
                lit, altitude, at_sun, entry, radius, table, row_start, n_row, level_edge, level, column, columns
            )
            for row in range(n_wl):
                add_light(lit, depth[row], columns, extinction[row], live, density, scatterer, light, out[d, row])
