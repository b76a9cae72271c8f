"""What backward paths read of a medium: uniform shells, optical depths to the top, phase functions over t."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from aomc_sky.atmosphere.medium import Medium, scatterers
from aomc_sky.atmosphere.optical_depth import Profile, columns, density_profile

_DEPTH_STEPS, _MOST_DEPTH_STEPS = 192, 768
_DEPTH_ERROR = 2e-4  # of a transmission
_PHASE_STEPS, _MOST_PHASE_STEPS = 1024, 16384
_PHASE_ERROR = 1e-5  # of the integral of abs(interpolated - given)
_GUIDES = 4096
_N_CHECK = 400

SHELL_TOLERANCE = 2e-4
"""Most relative error of a shell taken as uniform, (thickness / scale height)^2 / 24."""

_REFERENCE_TOP_M = 120e3
_STEPS_M = ((0.0, 50.0), (4e3, 100.0), (10e3, 250.0), (30e3, 500.0), (60e3, 1000.0), (_REFERENCE_TOP_M, 0.0))
_FLOOR = 1e-6  # of the largest extinction: below, shells are not halved further
_MOST_SHELLS = 20000


@dataclass(frozen=True, kw_only=True, slots=True)
class PathTables:
    """Tables of all wavelengths of a medium."""

    scales: tuple[float, float, float]  #: Radius of the ground, and c and s of the optical depths' table. [m, 1, 1]
    #: shells, depths, phases, guides: for each wavelength what `kernels.atmosphere.paths.follow_paths` reads
    shells: tuple[np.ndarray, ...]
    depths: tuple[np.ndarray, ...]
    phases: tuple[np.ndarray, ...]
    guides: tuple[np.ndarray, ...]
    depth_error: float  #: Largest error of a transmission to the top that was found in 400 places
    phase_error: float  #: Largest integral of abs(interpolated - given phase function) over the sphere


def path_tables(medium: Medium, shells: Shells | None = None) -> PathTables:
    """Tabulate a medium.

    One constituent scatters at least; `shells` None takes `uniform_shells`.

    Accuracy: transmissions to 2e-4 and phase functions to 1e-5, both measured; steps are halved until they are met, at
    most twice and four times. Cost: 0.2 s.
    """
    profile, shells = density_profile(medium), shells or uniform_shells(medium)
    depth, bend, floor, depth_error = _depth_tables(medium, profile, shells.edge_m)
    phase, phase_error = _phase_tables(medium)
    rows = range(medium.wavelength_nm.size)
    laws = [_cumulated(phase[row]) for row in rows]
    return PathTables(
        scales=(float(medium.earth_radius_m), bend, floor),
        shells=tuple(_shell_rows(medium, shells, row) for row in rows),
        depths=tuple(depth),
        phases=tuple(law for law, _ in laws),
        guides=tuple(guide for _, guide in laws),
        depth_error=depth_error,
        phase_error=phase_error,
    )


def _shell_rows(medium: Medium, shells: Shells, row: int) -> np.ndarray:
    """Edges, rise of the squared radii, extinction, albedo, and the scatterers' shares of each shell."""
    which = scatterers(medium)
    low, high = shells.edge_m[:-1], shells.edge_m[1:]
    cross = np.array([part.scattering_m2[row] + part.absorption_m2[row] for part in medium.constituents])
    extinction = shells.density @ cross
    scattering = shells.density[:, which] * np.array([medium.constituents[k].scattering_m2[row] for k in which])
    share = np.divide(scattering, extinction[:, None], out=np.zeros_like(scattering), where=extinction[:, None] > 0)
    albedo = share.sum(axis=1)
    upto = np.cumsum(share, axis=1)
    upto = np.divide(upto, albedo[:, None], out=np.ones_like(upto), where=albedo[:, None] > 0)
    upto[:, -1] = 1.0
    fall, rise = (edge * (edge + 2.0 * medium.earth_radius_m) for edge in (low, high))
    return np.vstack([low, high, fall, rise, extinction, albedo, 1.0 / (high - low), upto.T, share.T])


def _depth_tables(medium: Medium, profile: Profile, edge: np.ndarray) -> tuple[np.ndarray, float, float, float]:
    """Tables (n_wl, n_edge, n + 1), their c and s, and the error."""
    extinction = profile.extinction_m2
    height = _mean_altitude(profile, edge)
    floor = min(np.sqrt(2.0 * height / medium.earth_radius_m), 1.0)
    bend = 0.6 * floor
    n = _DEPTH_STEPS
    while True:
        x = np.arange(n + 1) / n
        mu = np.minimum(bend * x / (1.0 + bend - x), 1.0)
        found = columns(profile, edge[:, None], mu, profile.top_m) @ extinction.T
        table = np.ascontiguousarray(np.moveaxis(found * np.hypot(mu, floor)[:, None], -1, 0))
        error = _depth_error(profile, edge, table, bend, floor)
        if error <= _DEPTH_ERROR or n >= _MOST_DEPTH_STEPS:
            return table, float(bend), float(floor), error
        n *= 2


def _mean_altitude(profile: Profile, edge: np.ndarray) -> float:
    """Altitude that stands for the height of the atmosphere: mean over the extinction of all wavelengths."""
    weight = (columns(profile, edge[:-1], 1.0, edge[1:]) @ profile.extinction_m2.T).mean(axis=1)
    total = float(weight.sum())
    return float(weight @ (0.5 * (edge[1:] + edge[:-1]))) / total if total > 0 else float(edge[-1])


def _depth_error(profile: Profile, edge: np.ndarray, table: np.ndarray, bend: float, floor: float) -> float:
    """Largest error of a transmission in the middle of cells, spread over shells and directions."""
    n = table.shape[2] - 1
    spread = np.modf(np.outer(np.arange(1, _N_CHECK + 1), [0.6180339887498949, 0.7548776662466927]))[0]
    shell = (spread[:, 0] * (edge.size - 1)).astype(np.int64)
    j = (spread[:, 1] * n).astype(np.int64)
    x = (j + 0.5) / n
    mu = bend * x / (1.0 + bend - x)
    exact = columns(profile, 0.5 * (edge[shell] + edge[shell + 1]), mu, profile.top_m) @ profile.extinction_m2.T
    corners = table[:, shell, j] + table[:, shell, j + 1] + table[:, shell + 1, j] + table[:, shell + 1, j + 1]
    found = (0.25 * corners / np.hypot(mu, floor)).T
    return float(np.max(np.abs(np.exp(-found) - np.exp(-exact)), initial=0.0))


def _phase_tables(medium: Medium) -> tuple[np.ndarray, float]:
    """Phase functions (n_wl, n_scatterer, n + 1) over t, and the largest integral of the interpolation's error."""
    n = _PHASE_STEPS
    while True:
        t = np.arange(2 * n + 1) / (2 * n)
        values = _phases_at(medium, t)
        between = 0.5 * (values[..., :-1:2] + values[..., 2::2]) - values[..., 1::2]
        error = float(np.max(np.abs(between) @ (16.0 * np.pi / n * t[1::2] ** 3), initial=0.0))
        if error <= _PHASE_ERROR or n >= _MOST_PHASE_STEPS:
            return np.ascontiguousarray(values[..., ::2]), error
        n *= 2


def _phases_at(medium: Medium, t: np.ndarray) -> np.ndarray:
    which = scatterers(medium)
    mu = 1.0 - 2.0 * t**4
    values = np.zeros((medium.wavelength_nm.size, len(which), t.size))
    for k, index in enumerate(which):
        law = medium.constituents[index].phase_function
        assert law is not None  # it scatters
        for row in range(values.shape[0]):
            values[row, k] = law(mu, row)
    return values


def _cumulated(phase: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Phase functions of one wavelength and their integrals up to each t (n_scatterer, n + 1, 2); where to look."""
    n = phase.shape[1] - 1
    density = phase * (np.arange(n + 1) / n) ** 3
    steps = 16.0 * np.pi / n * 0.5 * (density[:, 1:] + density[:, :-1])
    upto = np.concatenate([np.zeros((phase.shape[0], 1)), np.cumsum(steps, axis=1)], axis=1)
    marks = np.arange(_GUIDES) / _GUIDES
    guide = np.array([np.searchsorted(row, marks * row[-1], side="right") - 1 for row in upto])
    return np.ascontiguousarray(np.stack([phase, upto], axis=-1)), np.clip(guide, 0, n - 1).astype(np.int64)


@dataclass(frozen=True, kw_only=True, slots=True)
class Shells:
    """An atmosphere cut into uniform shells."""

    edge_m: np.ndarray  #: (n_shell + 1,) rising altitudes from the ground to the top; every kink is among them. [m]
    #: (n_shell, n_constituent) mean of each constituent over the thickness, so that vertical columns are exact. [m-3]
    density: np.ndarray


def uniform_shells(medium: Medium) -> Shells:
    """Cut an atmosphere into shells.

    50 m thick up to 4 km, then 100 m to 10 km, 250 m to 30 km, 500 m to 60 km and 1 km above, for a top at 120 km and
    in proportion for others; cut at the kinks; halved where the extinction asks for it.

    Accuracy: vertical columns are those of the profile; slant ones and transmissions inside a shell are off by
    `SHELL_TOLERANCE` of what the shell adds, wherever the extinction is above 1e-6 of its largest. Cost: 10 ms.
    """
    profile = density_profile(medium)
    edges = np.union1d(_regular_edges(medium.top_m), profile.edge_m)
    edges = edges[np.concatenate([[True], np.diff(edges) > 1e-9 * medium.top_m])]
    while True:
        bent = _bend(profile, edges) > SHELL_TOLERANCE
        if not bent.any() or edges.size + bent.sum() > _MOST_SHELLS:
            break
        edges = np.sort(np.concatenate([edges, 0.5 * (edges[1:] + edges[:-1])[bent]]))
    thickness = np.diff(edges)
    return Shells(edge_m=edges, density=columns(profile, edges[:-1], 1.0, edges[1:]) / thickness[:, None])


def _regular_edges(top_m: float) -> np.ndarray:
    """The thicknesses of `_STEPS_M`, in proportion to the top."""
    pieces = [np.arange(low, high, step) for (low, step), (high, _) in pairwise(_STEPS_M)]
    return np.append(np.concatenate(pieces) * (top_m / _REFERENCE_TOP_M), top_m)


def _bend(profile: Profile, edges: np.ndarray) -> np.ndarray:
    """(thickness / scale height)^2 / 24 of each shell (n_shell,), from three points inside; 0 where there is little."""
    points = edges[:-1, None] + np.diff(edges)[:, None] * np.array([0.25, 0.5, 0.75])
    extinction = (profile.density(points.ravel()) @ profile.extinction_m2.T).reshape(*points.shape, -1)
    slope = 2.0 * (extinction[:, 2] - extinction[:, 0])
    level = np.abs(extinction[:, 1])
    matters = level > _FLOOR * level.max(axis=0, initial=0.0)
    relative = np.divide(slope, level, out=np.zeros_like(slope), where=matters)
    return (relative**2 / 24.0).max(axis=1, initial=0.0)
