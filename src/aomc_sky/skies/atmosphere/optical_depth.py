"""Optical depth along straight rays, by densities that are polynomials between edges.

A ray is an altitude and the zenith angle of its direction there. One that sinks is folded at its lowest point: to the
top it has twice the depth of the level ray from there, less that of its mirror image.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from aomc_sky.skies.atmosphere.kernels.rays import lowest_altitude
from aomc_sky.skies.atmosphere.medium import Medium

N_NODES = 10
"""Chebyshev nodes of a panel; the polynomials are of degree N_NODES - 1."""
_NODES = np.asarray(chebyshev.chebpts1(N_NODES))

_TOLERANCE = 1e-11
_MOST_PANELS = 1000
_NARROWEST = 2.0**-22  # of the top's altitude: narrower panels are not halved at an undeclared jump
_WIDEST_RATIO = 4.0  # of neighbouring panels, so that a kink is never near on the scale of a panel


@dataclass(frozen=True, kw_only=True, slots=True)
class Profile:
    """Densities between the ground and the top as polynomials on panels."""

    earth_radius_m: float
    edge_m: np.ndarray  #: (n_panel + 1,) rising altitudes from 0 to the top; every kink is among them. [m]
    #: (n_panel, n_constituent, N_NODES) of the densities over x in [-1, 1] of a panel, highest power first. [m-3]
    coefficient: np.ndarray
    #: (n_kink,) rising altitudes above the ground and below the top where a density jumps or bends. [m]
    kink_m: np.ndarray
    extinction_m2: np.ndarray  #: (n_wl, n_constituent) cross sections. [m2]

    @property
    def top_m(self) -> float:
        """Altitude of the last edge. [m]"""
        return float(self.edge_m[-1])

    def density(self, altitude_m: np.ndarray) -> np.ndarray:
        """Densities (n, n_constituent) at altitudes (n,); at an edge those above it. [m-3]"""
        panel = np.clip(np.searchsorted(self.edge_m, altitude_m, side="right") - 1, 0, self.edge_m.size - 2)
        low, high = self.edge_m[panel], self.edge_m[panel + 1]
        x = ((altitude_m - low) - (high - altitude_m)) / (high - low)
        value = np.zeros((x.size, self.coefficient.shape[1]))
        for power in range(self.coefficient.shape[2]):
            value = value * x[:, None] + self.coefficient[panel, :, power]
        return value


def density_profile(medium: Medium) -> Profile:
    """Represent the densities of a medium by polynomials, to 1e-11 of the extinction.

    Panels are halved until that is met. No density is evaluated at a kink; an undeclared jump is enclosed in panels of
    2e-7 of the top's altitude.
    """
    extinction = np.array([part.scattering_m2 + part.absorption_m2 for part in medium.constituents])
    extinction = extinction.reshape(len(medium.constituents), medium.wavelength_nm.size).T
    kinks = np.unique(np.concatenate([np.empty(0), *(part.kink_altitude_m for part in medium.constituents)]))
    kinks = kinks[(kinks > 0) & (kinks < medium.top_m)]
    first = [0.0]
    for end in [*kinks.tolist(), medium.top_m]:
        while end - first[-1] > 0.5 * (medium.earth_radius_m + first[-1]):  # a planet as small as its air
            first.append(first[-1] + 0.5 * (medium.earth_radius_m + first[-1]))
        first.append(end)
    narrowest = _NARROWEST * medium.top_m
    edges = halved(
        np.array(first),
        lambda edges: (_panel_errors(medium, extinction, edges) > _TOLERANCE) & (np.diff(edges) > narrowest),
        _MOST_PANELS,
    )
    edges = halved(edges, _is_wider_than_a_neighbour)
    return Profile(
        earth_radius_m=medium.earth_radius_m,
        edge_m=edges,
        coefficient=_powers(_densities(medium, edges, _NODES)),
        kink_m=kinks,
        extinction_m2=np.ascontiguousarray(extinction),
    )


def halved(edges: np.ndarray, are_bad: Callable[[np.ndarray], np.ndarray], most: float = np.inf) -> np.ndarray:
    """Halve panels between rising edges until none is bad, or there would be more than `most` edges."""
    while True:
        bad = are_bad(edges)
        if not bad.any() or edges.size + bad.sum() > most:
            return edges
        edges = np.sort(np.concatenate([edges, 0.5 * (edges[1:] + edges[:-1])[bad]]))


def _powers(values: np.ndarray) -> np.ndarray:
    """Coefficients (n_panel, n_constituent, N_NODES), highest power first, of values (n_panel, N_NODES, n_constituent).

    By way of the Chebyshev series: off by some 30 ulp of the largest value. The inverse of the nodes' powers (condition
    1e4) loses ten times as much, and gives other digits on other processors.
    """
    series = chebyshev.chebvander(_NODES, N_NODES - 1).T * (2.0 / N_NODES)
    series[0] *= 0.5
    powers = np.zeros((N_NODES, N_NODES))  # column k: the k-th Chebyshev polynomial, whole numbers up to 576
    for k in range(N_NODES):
        powers[N_NODES - 1 - k :, k] = chebyshev.cheb2poly(np.eye(N_NODES)[k, : k + 1])[::-1]
    in_series = np.einsum("cn,qni->qci", series, values)
    return np.ascontiguousarray(np.einsum("pc,qci->qip", powers, in_series))


def _densities(medium: Medium, edges: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Densities (n_panel, n_x, n_constituent) at x in (-1, 1) of each panel."""
    middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    altitude = (middle[:, None] + half[:, None] * x).ravel()
    values = np.empty((altitude.size, len(medium.constituents)))
    for k, part in enumerate(medium.constituents):
        values[:, k] = part.number_density(altitude)
    return values.reshape(middle.size, x.size, len(medium.constituents))


def _panel_errors(medium: Medium, extinction: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Largest error of the extinction in each panel, relative to the panel's largest, over the wavelengths."""
    between = np.asarray(chebyshev.chebpts1(2 * N_NODES + 1))
    interpolate = chebyshev.chebvander(between, N_NODES - 1) @ np.linalg.inv(chebyshev.chebvander(_NODES, N_NODES - 1))
    known = _densities(medium, edges, _NODES)
    truth = _densities(medium, edges, between)
    wrong = np.abs(np.einsum("bn,qni->qbi", interpolate, known) - truth) @ extinction.T
    size = (truth @ extinction.T).max(axis=1)
    floor = 1e-14 * size.max(axis=0, initial=0.0)
    excess = np.maximum(wrong.max(axis=1) - floor, 0.0)
    return np.divide(excess, size, out=np.zeros_like(size), where=size > 0).max(axis=1, initial=0.0)


def _is_wider_than_a_neighbour(edges: np.ndarray) -> np.ndarray:
    width = np.diff(edges)
    neighbour = np.minimum(np.append(width[1:], np.inf), np.insert(width[:-1], 0, np.inf))
    return np.asarray(width > _WIDEST_RATIO * neighbour)


N_GAUSS = 10
"""Gauss nodes of a panel of the profile: 1e-11 of its polynomials."""
_GAUSS = np.polynomial.legendre.leggauss(N_GAUSS)


def meets_ground(radius_m: float, altitude_m: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """Whether rays sink into the ground; one that only touches it does not."""
    return np.asarray((mu < 0.0) & (lowest_altitude(radius_m, altitude_m, mu) < 0.0))


def columns(profile: Profile, low_m: ArrayLike, mu: ArrayLike, high_m: ArrayLike) -> np.ndarray:
    """Particles per area (..., n_constituent) along rising rays between two altitudes; arguments broadcast. [m-2]

    mu is the cosine of the zenith angle at the start. [0 to 1] Good to 1e-13 of the profile's polynomials.
    """
    from aomc_sky.skies.atmosphere.kernels.ray_integrals import fill_columns

    low, cosine, high = np.broadcast_arrays(*(np.asarray(x, dtype=np.float64) for x in (low_m, mu, high_m)))
    out = np.empty((low.size, profile.coefficient.shape[1]))
    rays = [np.array(x).ravel() for x in (low, cosine, high)]  # copies: old numpy warns of broadcast arrays in kernels
    fill_columns(profile.earth_radius_m, profile.edge_m, profile.coefficient, *_GAUSS, *rays, out)
    return out.reshape(*low.shape, -1)


def columns_to_top(profile: Profile, altitude_m: ArrayLike, mu: ArrayLike) -> np.ndarray:
    """Particles per area (..., n_constituent) from a point to the top, along a ray of any zenith angle. [m-2]

    Without meaning where the ground is in the way: see `meets_ground`.
    """
    altitude, cosine = np.broadcast_arrays(np.asarray(altitude_m, dtype=np.float64), np.asarray(mu, dtype=np.float64))
    rising = columns(profile, altitude, np.abs(cosine), profile.top_m)
    sinks = cosine < 0.0
    if not sinks.any():
        return rising
    lowest = lowest_altitude(profile.earth_radius_m, altitude[sinks], cosine[sinks])
    level = columns(profile, np.maximum(lowest, 0.0), 0.0, profile.top_m)
    rising[sinks] = 2.0 * level - rising[sinks]
    return rising


def optical_depth_to_top(medium: Medium, altitude_m: ArrayLike, zenith_rad: ArrayLike) -> np.ndarray:
    """Optical depth (n_wl, ...) between a point and the top along a straight ray; infinite where the ray meets the
    ground.
    """
    altitude, cosine = np.broadcast_arrays(np.asarray(altitude_m, dtype=np.float64), np.cos(zenith_rad))
    profile = density_profile(medium)
    blocked = meets_ground(medium.earth_radius_m, altitude, cosine)
    column = columns_to_top(profile, altitude, cosine)
    return np.where(blocked, np.inf, np.moveaxis(column @ profile.extinction_m2.T, -1, 0))


def vertical_optical_depth(medium: Medium) -> np.ndarray:
    """Optical depth of the whole atmosphere along the vertical, by constituent: (n_wl, n_constituent)."""
    profile, power = density_profile(medium), np.arange(N_NODES)[::-1]
    panel_means = profile.coefficient @ np.where(power % 2 == 0, 1.0 / (power + 1.0), 0.0)
    return profile.extinction_m2 * (np.diff(profile.edge_m) @ panel_means)
