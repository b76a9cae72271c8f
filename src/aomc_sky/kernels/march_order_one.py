"""Light scattered once on its way to the ground, by quadrature along straight rays.

All rays have their nodes at the same altitudes, so densities and the table of the sun's columns are read, not
searched for. In a panel between two altitudes the variable is u = sqrt(altitude): along a level ray the way is
smooth in it. What the light of a node passes on its way down is the integral of the interpolating polynomial of the
extinction, panel by panel. With the sun below the horizon a ray leaves the earth's shadow at one point; from there to
the end of its panel it has nodes of its own, to which the panel's are interpolated.
"""

from __future__ import annotations

import math

import numpy as np

from aomc_sky.kernels.jit import inner, kernel
from aomc_sky.kernels.perez_law import exp_level


@inner
def shadow_altitude(radius, mu, sun_mu, scattering_mu):
    """Altitude at which a ray from the ground leaves the shadow of the earth, for a sun below the horizon.

    The shadow is a half cylinder; its edge is the root of s^2 sin^2(angle to the sun) + 2 s R (mu - sun_mu
    scattering_mu) = (R sun_mu)^2. Infinite where the ray runs along the cylinder.
    """
    across = (1.0 - scattering_mu) * (1.0 + scattering_mu)
    slope = radius * (mu - sun_mu * scattering_mu)
    c = radius * radius * sun_mu * sun_mu
    root = math.sqrt(slope * slope + across * c)
    if slope >= 0.0:
        way = c / (slope + root) if slope + root > 0.0 else math.inf
    else:
        way = (root - slope) / across if across > 0.0 else math.inf
    if way == math.inf:
        return way
    q = way * (way + 2.0 * radius * mu)
    return q / (math.sqrt(radius * radius + q) + radius)


@inner
def place_node(radius, u, mu, sine):
    """Altitude of a node of a ray from the ground, cosine and sine of its angle at the earth's centre, ds/du."""
    altitude = u * u
    c = altitude * (altitude + 2.0 * radius)
    start = radius * mu
    root = math.sqrt(start * start + c)
    way = c / (start + root)
    r = radius + altitude
    return altitude, (radius + way * mu) / r, way * sine / r, 2.0 * u * r / root


@inner
def walk(radius, u_edge, node, weight, cumulative, mu, sine, extinction, altitude, cosine_c, sine_c, path, depth):
    """Nodes of one ray: altitudes, angles at the earth's centre, quadrature weights of the way, optical depth to the eye.

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
def look_up(table, at, scale, low, step, mu, share, column):
    """Add `share` times the columns (n_part,) of a rising ray under mu from node `at`: four points of its row."""
    t = (math.asinh(mu / scale) - low) / step
    n = table.shape[1]
    first = min(max(int(t) - 1, 0), n - 4)
    x = t - first
    a, b, c = x - 1.0, x - 2.0, x - 3.0
    w0 = -a * b * c / 6.0 * share
    w1 = x * b * c / 2.0 * share
    w2 = -x * a * c / 2.0 * share
    w3 = x * a * b / 6.0 * share
    for part in range(column.size):
        column[part] += (
            w0 * table[at, first, part]
            + w1 * table[at, first + 1, part]
            + w2 * table[at, first + 2, part]
            + w3 * table[at, first + 3, part]
        )


@inner
def add_level(level_edge, level, altitude, column):
    """Add twice the columns of a level ray from an altitude to the top, then change the sign of what was there."""
    panel = min(max(np.searchsorted(level_edge, altitude, side="right") - 1, 0), level_edge.size - 2)
    high = level_edge[panel + 1]
    share = max(high - altitude, 0.0) / (high - level_edge[panel])
    x = 2.0 * math.sqrt(share) - 1.0
    for part in range(column.size):
        value = level[panel, 0, part]
        for power in range(1, level.shape[1]):
            value = value * x + level[panel, power, part]
        column[part] = 2.0 * value - column[part]


@inner
def fold(radius, level_edge, level, altitude, sun_mu, column):
    """Turn the columns under abs(sun_mu) into those of a ray that sinks first."""
    sine = math.sqrt((1.0 - sun_mu) * (1.0 + sun_mu))
    lowest = altitude - (radius + altitude) * sun_mu * sun_mu / (1.0 + sine)
    add_level(level_edge, level, max(lowest, 0.0), column)


@inner
def basis(node, x, share):
    """Lagrange's polynomials of the nodes at x."""
    for j in range(node.size):
        product = 1.0
        for other in range(node.size):
            if other != j:
                product *= (x - node[other]) / (node[j] - node[other])
        share[j] = product


@inner
def add_lit_part(
    radius, u_edge, node, weight, panel, u_lit, mu, sine, sun_mu, sun_across, density, depth, extinction,
    table, scale, low, step, level_edge, level, scatterer, share, column, out,
):  # fmt: skip
    """Add the part of a panel above the edge of the earth's shadow to out (n_wl, n_scatterer)."""
    k = node.size
    first = panel * k
    half = 0.5 * (u_edge[panel + 1] - u_lit)
    middle = 0.5 * (u_edge[panel + 1] + u_edge[panel])
    for q in range(k):
        u = u_lit + half * (1.0 + node[q])
        basis(node, 2.0 * (u - middle) / (u_edge[panel + 1] - u_edge[panel]), share)
        altitude, cosine_c, sine_c, way = place_node(radius, u, mu, sine)
        at_sun = cosine_c * sun_mu + sine_c * sun_across
        column[:] = 0.0
        for j in range(k):
            look_up(table, first + j, scale[panel], low[panel], step[panel], abs(at_sun), share[j], column)
        if at_sun < 0.0:
            fold(radius, level_edge, level, altitude, at_sun, column)
        for row in range(depth.shape[0]):
            passed = 0.0
            for j in range(k):
                passed += share[j] * depth[row, first + j]
            for part in range(column.size):
                passed += extinction[row, part] * column[part]
            light = half * weight[q] * way * math.exp(-passed)
            for part in range(scatterer.size):
                here = 0.0
                for j in range(k):
                    here += share[j] * density[scatterer[part], first + j]
                out[row, part] += here * light


@kernel
def fill_order_one(
    radius, u_edge, node, weight, cumulative, density, extinction, scatterer, sun_mu, sun_sine,
    table, scale, low, step, level_edge, level, ray_mu, ray_sine, ray_start, cos_azimuth, out,
):  # fmt: skip
    """Integrals of density times transmission from the sun over node to the eye: out (n, n_wl, n_scatterer). [m-2]

    Parameters
    ----------
    radius
        Of the ground. [m]
    u_edge : (n_panel + 1,)
        Roots of the altitudes between panels. [m^0.5]
    node, weight : (k,); cumulative : (k, k)
        Gauss rule on [-1, 1], and the integrals from -1 to each node of the polynomials that are 1 at one node.
    density : (n_part, n_panel k); extinction : (n_wl, n_part); scatterer : (n_scatterer,), int
        Densities at the nodes, cross sections, and which parts scatter.
    sun_mu, sun_sine
        Of the sun's zenith angle at the observer.
    table : (n_panel k, n_mu, n_part); scale, low, step : (n_panel,)
        Columns from each node to the top under mu = scale sinh(low + i step).
    level_edge : (n_level + 1,); level : (n_level, n_coefficient, n_part)
        Columns of level rays as polynomials of 2 sqrt((high - altitude)/(high - low)) - 1.
    ray_mu, ray_sine : (n_ray,); ray_start : (n_ray + 1,), int; cos_azimuth : (n,)
        Zenith angles, and the range of directions of each; azimuths from the sun.
    """
    k = node.size
    n_node = density.shape[1]
    n_part = density.shape[0]
    n_wl = extinction.shape[0]
    altitude = np.empty(n_node)
    cosine_c = np.empty(n_node)
    sine_c = np.empty(n_node)
    path = np.empty(n_node)
    light = np.empty(n_node)
    depth = np.empty((n_wl, n_node))
    mixed = np.zeros((n_wl, n_node))
    columns = np.zeros((n_part, n_node))
    column = np.empty(n_part)
    share = np.empty(k)
    for row in range(n_wl):
        for part in range(n_part):
            for j in range(n_node):
                mixed[row, j] += extinction[row, part] * density[part, j]
    for ray in range(ray_mu.size):
        mu = ray_mu[ray]
        sine = ray_sine[ray]
        walk(radius, u_edge, node, weight, cumulative, mu, sine, mixed, altitude, cosine_c, sine_c, path, depth)
        for d in range(ray_start[ray], ray_start[ray + 1]):
            out[d] = 0.0
            across = sun_sine * cos_azimuth[d]
            first_lit = 0
            if sun_mu < 0.0:
                edge = shadow_altitude(radius, mu, sun_mu, mu * sun_mu + sine * across)
                u_lit = math.sqrt(edge)
                if not u_lit < u_edge[-1]:
                    continue
                panel = min(max(np.searchsorted(u_edge, u_lit, side="right") - 1, 0), u_edge.size - 2)
                first_lit = (panel + 1) * k
                add_lit_part(
                    radius, u_edge, node, weight, panel, u_lit, mu, sine, sun_mu, across, density, depth, extinction,
                    table, scale, low, step, level_edge, level, scatterer, share, column, out[d],
                )  # fmt: skip
            for j in range(first_lit, n_node):
                panel = j // k
                at_sun = cosine_c[j] * sun_mu + sine_c[j] * across
                column[:] = 0.0
                look_up(table, j, scale[panel], low[panel], step[panel], abs(at_sun), 1.0, column)
                if at_sun < 0.0:
                    fold(radius, level_edge, level, altitude[j], at_sun, column)
                for part in range(n_part):
                    columns[part, j] = column[part]
            for row in range(n_wl):
                for j in range(first_lit, n_node):
                    light[j] = depth[row, j]
                for part in range(n_part):
                    size = extinction[row, part]
                    for j in range(first_lit, n_node):
                        light[j] += size * columns[part, j]
                for j in range(first_lit, n_node):
                    light[j] = path[j] * exp_level(-light[j])
                for part in range(scatterer.size):
                    total = 0.0
                    for j in range(first_lit, n_node):
                        total += light[j] * density[scatterer[part], j]
                    out[d, row, part] += total
