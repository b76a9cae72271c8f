"""Radiance of the sky by paths of light followed backwards through spherical shells, for any sun.

Paths read tables of a medium: uniform shells, optical depths to the top, phase functions over t.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import UsageError
from aomc_sky.progress import counted
from aomc_sky.skies.atmosphere.eclipse import solve_order_one
from aomc_sky.skies.atmosphere.lights import Moon, sun_and_moon
from aomc_sky.skies.atmosphere.medium import Medium, phase_laws, scatterers
from aomc_sky.skies.atmosphere.optical_depth import Profile, columns, density_profile, halved
from aomc_sky.skies.atmosphere.order_one import checked_directions
from aomc_sky.whole_number import as_number_of

MOST_LISTED = 24
"""Orders that are listed one by one; where more count, the last row holds all the later ones together."""

_LEAST_PATHS = 8

TRUSTED = 0.2
"""Relative error of a variance up to which the standard error from it is trusted."""

_SPREAD = 0x9E3779B97F4A7C15  # odd, so that no two seeds give one stream


@dataclass(frozen=True, kw_only=True, slots=True)
class PathsResult:
    """Radiance of directions by backward paths."""

    #: (n_wl, n_order, n) by number of interactions, 1 first: order 1 of the sun by quadrature, all else by paths. Row
    #: 24 holds the later ones too. [W m-2 sr-1 nm-1]
    radiance_by_order: np.ndarray
    standard_error_by_order: np.ndarray  #: (n_wl, n_order, n), 0 without paths
    #: (n_wl, n) of the sum of all orders, whose errors are correlated
    standard_error: np.ndarray
    under_sampled: np.ndarray  #: (n_wl, n) where the errors are not to be trusted: see `solve_paths`
    n_paths: int  #: Paths of each direction and wavelength

    @property
    def radiance(self) -> np.ndarray:
        """All orders together, shape (n_wl, n). [W m-2 sr-1 nm-1]"""
        return self.radiance_by_order.sum(axis=1)


def paths_result(order_one: np.ndarray, rows: np.ndarray, totals: np.ndarray, n_paths: int) -> PathsResult:
    """Means and errors of sums: `order_one` (n_wl, n) is the sun's.

    `rows` (n_wl, n, n_row, 2) are sums of light and of its squares by order. `totals` (n_wl, n, 3) are the sums that
    `kernels.paths` fills for each direction.
    """
    mean = rows[..., 0] / n_paths
    radiance = np.ascontiguousarray(mean.swapaxes(1, 2))
    radiance[:, 0] += order_one
    squares = np.where(totals[..., 1] > 0, totals[..., 1], 1.0)
    # the relative error of the variance is sqrt(sum x^4 / (sum x^2)^2 - 1 / n)
    is_doubtful = totals[..., 2] / squares**2 > TRUSTED**2 + 1.0 / n_paths
    return PathsResult(
        radiance_by_order=radiance,
        standard_error_by_order=_standard_error(rows[..., 0], rows[..., 1], n_paths).swapaxes(1, 2),
        standard_error=_standard_error(totals[..., 0], totals[..., 1], n_paths),
        under_sampled=is_doubtful | ((totals[..., 1] == 0) & (order_one > 0) & (rows.shape[2] > 1)),
        n_paths=n_paths,
    )


def _standard_error(total: np.ndarray, squares: np.ndarray, n: int) -> np.ndarray:
    mean = total / n
    return np.sqrt(np.maximum(squares / n - mean * mean, 0.0) / (n - 1))


MOST_PATHS = 2**32 - 1


def solve_paths(
    medium: Medium,
    *,
    sun_zenith_rad: float,
    sky_zenith_rad: ArrayLike,
    azimuth_from_sun_rad: ArrayLike,
    n_paths: int,
    n_orders: int,
    seed: int = 0,
    visible: Moon | None = None,
    ground_radiance: ArrayLike | None = None,
    threads: int = 1,
    tables: PathTables | None = None,
    order_one: np.ndarray | None = None,
) -> PathsResult:
    """Follow light backwards from the ground: `n_paths` in each direction and wavelength.

    The medium's own number of orders does not count. `visible` hides part of the sun; `ground_radiance` (n_wl,) is
    light that the ground gives off by itself [W m-2 sr-1 nm-1]. Earlier results save work: `tables` of this medium
    serve all suns, and `order_one` (n_wl, n) is the sun's in these directions.

    Random numbers are addressed by direction, wavelength, path and step. The light of a direction depends neither on
    the number of threads nor on other directions. The same direction under two suns has the same numbers: give each sun
    a seed for independent errors.

    Accuracy: the standard error, and 1e-4 of tables and shells. `under_sampled` marks directions whose paths know their
    own variance to less than 20 %. Cost: 1 us a path.
    """
    from aomc_sky.skies.atmosphere.kernels.paths import ABREAST, N_MARK, N_NUMBER, N_STATE, follow_paths
    from aomc_sky.skies.atmosphere.kernels.shells import ROOTS

    zenith, azimuth = checked_directions(sun_zenith_rad, sky_zenith_rad, azimuth_from_sun_rad)
    glow = _checked_glow(medium, ground_radiance)
    n_row = min(n_orders, MOST_LISTED)
    rows = np.zeros((medium.wavelength_nm.size, zenith.size, n_row, 2))
    totals = np.zeros((medium.wavelength_nm.size, zenith.size, 3))
    if scatterers(medium) and zenith.size:
        sun, moon = sun_and_moon(medium, sun_zenith_rad, visible)
        read = tables or path_tables(medium)
        places = [(row, k) for row in range(rows.shape[0]) for k in range(zenith.size)]

        def follow(place: tuple[int, int]) -> None:
            row, k = place
            across = float(np.sin(zenith[k]))
            view = (across * float(np.cos(azimuth[k])), across * float(np.sin(azimuth[k])), float(np.cos(zenith[k])))
            ground = (float(medium.ground_albedo[row]), float(glow[row]), float(medium.toa_irradiance[row]))
            address = (_word(zenith[k], azimuth[k]), _word(medium.wavelength_nm[row]), np.uint64(seed))
            flight = np.empty((4, max(read.shells[row].shape[1] + 1, ROOTS)))
            follow_paths(
                read.scales, read.shells[row], read.depths[row], read.phases[row], read.guides[row], sun, moon, ground,
                (min(n_orders, 2**31), n_row), address, view, n_paths, flight, np.empty((N_NUMBER, ABREAST)),
                np.empty((N_STATE, ABREAST)), np.empty((N_MARK, ABREAST), np.int64), rows[place], totals[place],
            )  # fmt: skip

        with ThreadPoolExecutor(max_workers=threads) as pool:
            for _ in counted(pool.map(follow, places), "direction", len(places)):
                pass
    if order_one is None:
        order_one = solve_order_one(medium, sun_zenith_rad, zenith, azimuth, visible)
    return paths_result(order_one, rows, totals, n_paths)


def seed_of(stream: int, seed: int) -> int:
    """The seed of `solve_paths` for a stream of its own, which seed 0 of the caller leaves as it is. [0 to 2^64 - 1]"""
    return (stream ^ (seed * _SPREAD)) % 2**64


def _word(*numbers: float) -> np.uint64:
    """32 bits out of the bits of some numbers (the mixer of splitmix64)."""
    word = 0
    for number in numbers:
        word ^= int(np.float64(number + 0.0).view(np.uint64))
        word = ((word ^ (word >> 30)) * 0xBF58476D1CE4E5B9) & (2**64 - 1)
        word = ((word ^ (word >> 27)) * 0x94D049BB133111EB) & (2**64 - 1)
        word ^= word >> 31
    return np.uint64(word >> 32)


def _checked_glow(medium: Medium, ground_radiance: ArrayLike | None) -> np.ndarray:
    if ground_radiance is None:
        return np.zeros_like(medium.wavelength_nm)
    glow = np.atleast_1d(np.asarray(ground_radiance, dtype=np.float64))
    if glow.shape != medium.wavelength_nm.shape or not np.all((glow >= 0.0) & np.isfinite(glow)):
        raise UsageError("the ground's own radiance is one number for each wavelength, 0 or more")
    return glow


def checked_paths(given: Any) -> int:
    """A number of paths of each direction and wavelength; a UsageError for what is none."""
    return as_number_of(given, "the number of paths", _LEAST_PATHS, MOST_PATHS)


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
    #: shells, depths, phases, guides: for each wavelength what `skies.atmosphere.kernels.paths.follow_paths` reads
    shells: tuple[np.ndarray, ...]
    depths: tuple[np.ndarray, ...]
    phases: tuple[np.ndarray, ...]
    guides: tuple[np.ndarray, ...]


def path_tables(medium: Medium) -> PathTables:
    """Tabulate a medium: transmissions to 2e-4 and phase functions to 1e-5, both measured.

    Steps are halved until that is met, at most twice and four times.
    """
    profile, (edge, density) = density_profile(medium), uniform_shells(medium)
    depth, bend, floor = _depth_tables(medium, profile, edge)
    phase = _phase_tables(medium)
    rows = range(medium.wavelength_nm.size)
    laws = [_cumulated(phase[row]) for row in rows]
    return PathTables(
        scales=(float(medium.earth_radius_m), bend, floor),
        shells=tuple(_shell_rows(medium, edge, density, row) for row in rows),
        depths=tuple(depth),
        phases=tuple(law for law, _ in laws),
        guides=tuple(guide for _, guide in laws),
    )


def _shell_rows(medium: Medium, edge: np.ndarray, density: np.ndarray, row: int) -> np.ndarray:
    """Edges, rise of the squared radii, extinction, albedo, and the scatterers' shares of each shell."""
    which = scatterers(medium)
    low, high = edge[:-1], edge[1:]
    extinction = density @ np.array([part.scattering_m2[row] + part.absorption_m2[row] for part in medium.constituents])
    scattering = density[:, which] * np.array([medium.constituents[k].scattering_m2[row] for k in which])
    share = np.divide(scattering, extinction[:, None], out=np.zeros_like(scattering), where=extinction[:, None] > 0)
    albedo = share.sum(axis=1)
    upto = np.cumsum(share, axis=1)
    upto = np.divide(upto, albedo[:, None], out=np.ones_like(upto), where=albedo[:, None] > 0)
    upto[:, -1] = 1.0
    fall, rise = (each * (each + 2.0 * medium.earth_radius_m) for each in (low, high))
    return np.vstack([low, high, fall, rise, extinction, albedo, 1.0 / (high - low), upto.T, share.T])


def _depth_tables(medium: Medium, profile: Profile, edge: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Tables (n_wl, n_edge, n + 1), and their c and s."""
    extinction = profile.extinction_m2
    weight = (columns(profile, edge[:-1], 1.0, edge[1:]) @ extinction.T).mean(axis=1)
    total = float(weight.sum())
    # mean altitude of the extinction of all wavelengths
    height = float(weight @ (0.5 * (edge[1:] + edge[:-1]))) / total if total > 0 else float(edge[-1])
    floor = min(np.sqrt(2.0 * height / medium.earth_radius_m), 1.0)
    bend = 0.6 * floor
    n = _DEPTH_STEPS
    while True:
        x = np.arange(n + 1) / n
        mu = np.minimum(bend * x / (1.0 + bend - x), 1.0)
        depth = columns(profile, edge[:, None], mu, profile.top_m) @ extinction.T
        table = np.ascontiguousarray(np.moveaxis(depth * np.hypot(mu, floor)[:, None], -1, 0))
        error = _depth_error(profile, edge, table, bend, floor)
        if error <= _DEPTH_ERROR or n >= _MOST_DEPTH_STEPS:
            return table, float(bend), float(floor)
        n *= 2


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
    depth = (0.25 * corners / np.hypot(mu, floor)).T
    return float(np.max(np.abs(np.exp(-depth) - np.exp(-exact)), initial=0.0))


def _phase_tables(medium: Medium) -> np.ndarray:
    """Phase functions (n_wl, n_scatterer, n + 1) over t."""
    n, laws = _PHASE_STEPS, phase_laws(medium)
    while True:
        t = np.arange(2 * n + 1) / (2 * n)
        values = np.zeros((medium.wavelength_nm.size, len(laws), t.size))
        for k, law in enumerate(laws):
            for row in range(values.shape[0]):
                values[row, k] = law(1.0 - 2.0 * t**4, row)
        between = 0.5 * (values[..., :-1:2] + values[..., 2::2]) - values[..., 1::2]
        error = float(np.max(np.abs(between) @ (16.0 * np.pi / n * t[1::2] ** 3), initial=0.0))
        if error <= _PHASE_ERROR or n >= _MOST_PHASE_STEPS:
            return np.ascontiguousarray(values[..., ::2])
        n *= 2


def _cumulated(phase: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Phase functions of one wavelength and their integrals up to each t (n_scatterer, n + 1, 2); where to look."""
    n = phase.shape[1] - 1
    density = phase * (np.arange(n + 1) / n) ** 3
    steps = 16.0 * np.pi / n * 0.5 * (density[:, 1:] + density[:, :-1])
    upto = np.concatenate([np.zeros((phase.shape[0], 1)), np.cumsum(steps, axis=1)], axis=1)
    marks = np.arange(_GUIDES) / _GUIDES
    guide = np.array([np.searchsorted(row, marks * row[-1], side="right") - 1 for row in upto])
    return np.ascontiguousarray(np.stack([phase, upto], axis=-1)), np.clip(guide, 0, n - 1).astype(np.int64)


def uniform_shells(medium: Medium) -> tuple[np.ndarray, np.ndarray]:
    """Cut an atmosphere into shells: `_STEPS_M` in proportion to its top, cut at the kinks, halved to
    `SHELL_TOLERANCE`.

    Rising altitudes (n_shell + 1,) [m], and means (n_shell, n_constituent) of the densities over the thickness, so that
    vertical columns are exact. [m-3]
    """
    profile = density_profile(medium)
    pieces = [np.arange(low, high, step) for (low, step), (high, _) in pairwise(_STEPS_M)]
    regular = np.append(np.concatenate(pieces) * (medium.top_m / _REFERENCE_TOP_M), medium.top_m)
    edges = np.union1d(regular, profile.edge_m)
    edges = edges[np.concatenate([[True], np.diff(edges) > 1e-9 * medium.top_m])]
    edges = halved(edges, lambda edges: _bend(profile, edges) > SHELL_TOLERANCE, _MOST_SHELLS)
    return edges, columns(profile, edges[:-1], 1.0, edges[1:]) / np.diff(edges)[:, None]


def _bend(profile: Profile, edges: np.ndarray) -> np.ndarray:
    """(thickness / scale height)^2 / 24 of each shell (n_shell,), from three points inside; 0 where there is little."""
    points = edges[:-1, None] + np.diff(edges)[:, None] * np.array([0.25, 0.5, 0.75])
    extinction = (profile.density(points.ravel()) @ profile.extinction_m2.T).reshape(*points.shape, -1)
    slope = 2.0 * (extinction[:, 2] - extinction[:, 0])
    level = np.abs(extinction[:, 1])
    matters = level > _FLOOR * level.max(axis=0, initial=0.0)
    relative = np.divide(slope, level, out=np.zeros_like(slope), where=matters)
    return (relative**2 / 24.0).max(axis=1, initial=0.0)
