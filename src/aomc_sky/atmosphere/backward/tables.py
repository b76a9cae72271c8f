"""What backward paths read of a medium: uniform shells, optical depths to the top, phase functions over t."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.atmosphere.medium.constituents import Medium
from aomc_sky.atmosphere.medium.optical_depth import columns
from aomc_sky.atmosphere.medium.profile import Profile, density_profile
from aomc_sky.atmosphere.medium.shells import Shells, uniform_shells
from aomc_sky.atmosphere.order_one.radiance import scatterers

_DEPTH_STEPS, _MOST_DEPTH_STEPS = 192, 768
_DEPTH_ERROR = 2e-4  # of a transmission
_PHASE_STEPS, _MOST_PHASE_STEPS = 1024, 16384
_PHASE_ERROR = 1e-5  # of the integral of abs(interpolated - given)
_GUIDES = 4096
_N_CHECK = 400


@dataclass(frozen=True, kw_only=True, slots=True)
class PathTables:
    """Tables of all wavelengths of a medium."""

    scales: tuple[float, float, float]  #: Radius of the ground, and c and s of the optical depths' table. [m, 1, 1]
    #: shells, depths, phases, guides: for each wavelength what `kernels.atmosphere.backward.paths.follow_paths` reads
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
    """Altitude by which half of the sizes of the atmosphere are told: mean over the extinction of all wavelengths."""
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
