"""Positions of photons inside the patches that they come from: what is expected, counts, tests."""

from __future__ import annotations

from functools import cache

import numpy as np

from aomc_sky.component import Component
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.grid import PatchGrid
from aomc_sky.plan.laws import law_of
from aomc_sky.verify.report import Check, kolmogorov_p
from aomc_sky.verify.zone_tests import MIN_EVEN, chi_square_check, untested
from aomc_sky.verify.zones import at_centres, components_seen, fixed_directions

N_STEPS = 64
"""Steps across a patch of constant radiance: the Kolmogorov distance between them says nearly all."""

N_STEPS_UNEVEN = 8
"""Steps across a patch of uneven light: each needs the flux of its own part."""


class PatchInterior:
    """The patches of one component, and the positions in them.

    Patches that touch a fixed direction are left out.
    """

    def __init__(self, source: PhotonSource, component: Component, fixed: np.ndarray) -> None:
        assert component.grid is not None
        self._source, self._shares = source, cache(self._shares_of_band)
        self.grid: PatchGrid = component.grid
        self._component, self._law = component, law_of(component.law)
        self.n_steps = N_STEPS if self._law.flux is None else N_STEPS_UNEVEN
        self.is_usable = (self.grid.solid_angle_sr > 0) & ~_touched(self.grid, fixed)
        self._rings = self._law.coordinate(self.grid.zenith_bounds_deg)

    def count(self, zenith_deg: np.ndarray, azimuth_deg: np.ndarray) -> np.ndarray:
        """Photons of each patch, then of each step along and across all patches together."""
        patch = self.grid.patch_of(zenith_deg, azimuth_deg)
        chosen = (patch >= 0) & self.is_usable[patch]
        patch = patch[chosen]
        ring, column = np.divmod(patch, self.grid.n_azimuth)
        near, far = self._rings[ring].T
        start, end = self.grid.azimuth_bounds_deg[column].T
        along = (self._law.coordinate(zenith_deg[chosen]) - near) / (far - near)
        across = np.mod(azimuth_deg[chosen] - start, 360.0) / (end - start)
        patch_counts = np.bincount(patch, minlength=self.grid.n_patches)
        return np.concatenate([patch_counts, self._steps(along), self._steps(across)])

    def _steps(self, position: np.ndarray) -> np.ndarray:
        """Photons of each step; rounding may bring one over an end of its patch."""
        n = self.n_steps
        return np.bincount(np.clip((position * n).astype(np.int64), 0, n - 1), minlength=n)

    def _shares_of_band(self, band: int) -> tuple[np.ndarray, np.ndarray]:
        """Share of each step of each patch along and across, (n_patch, n_steps) each."""
        component = next(c for c in components_seen(self._source, band) if c.name == self._component.name)
        flux = self._law.flux
        assert flux is not None
        n, rings, columns = self.n_steps, self.grid.n_zenith, self.grid.n_azimuth
        zenith, azimuth = self.grid.zenith_bounds_deg, self.grid.azimuth_bounds_deg
        along = flux(component, _steps_of(zenith, n), azimuth)
        across = flux(component, zenith, _steps_of(azimuth, n)).reshape(-1, n)
        along = along.reshape(rings, n, columns).transpose(0, 2, 1).reshape(-1, n)
        totals = (mass.sum(axis=1, keepdims=True) for mass in (along, across))
        shares = [mass / np.where(total > 0, total, 1.0) for mass, total in zip((along, across), totals, strict=True)]
        return shares[0], shares[1]

    def checks(self, counts: np.ndarray, waveband: int, *, are_independent: bool) -> list[Check]:
        """Chi-square and Kolmogorov-Smirnov of both coordinates.

        The chi-square is two-sided if photons lie independently of each other inside patches. Otherwise only positions
        that are too uneven fail. The Kolmogorov distance is taken between steps, so it is at most the true one, and the
        p-value at most too large.
        """
        patch_counts, *steps = np.split(counts, self.grid.n_patches + np.array([0, self.n_steps]))
        n, checks = int(patch_counts.sum()), []
        kinds = "chi-square, two-sided" if are_independent else "chi-square", "Kolmogorov-Smirnov"
        even = np.full(self.n_steps, n / self.n_steps)
        expected_steps = even, even
        if self._law.flux is not None:
            along, across = self._shares(waveband - 1 if self._source.bands_differ_inside_cells else 0)
            expected_steps = patch_counts @ along, patch_counts @ across
        for axis, found, expected in zip(("mu^2", "azimuth"), steps, expected_steps, strict=True):
            chi_square, kolmogorov = (f"inside patches, {axis}: {kind}" for kind in kinds)
            if n < MIN_EVEN or expected.min() < MIN_EVEN / found.size:
                checks += [untested(chi_square, waveband), untested(kolmogorov, waveband)]
                continue
            statistic = float(np.sum((found - expected) ** 2 / expected))
            distance = float(np.abs(np.cumsum(found - expected)).max() / n)
            p_value, detail = kolmogorov_p(distance, n), f"{n} photons"
            checks += [
                chi_square_check(statistic, found.size - 1, chi_square, waveband, is_two_sided=are_independent),
                Check(name=kolmogorov, waveband=waveband, found=distance, p_value=p_value, detail=detail),
            ]
        return checks


def interior_of(source: PhotonSource) -> tuple[PatchInterior | None, str]:
    """The patches of a source whose inside can be tested, or None and why not."""
    components = source.components
    with_grid = [c for c in components if c.grid is not None]
    why = ""
    if at_centres(source):
        why = "photons lie in the centres of patches"
    elif any(law_of(component.law).covers_sky for component in components):
        why = "lobes add light inside the patches" if with_grid else "lobes have no patches"
    elif len(with_grid) != 1:
        why = "several components have patches" if with_grid else "no component has patches"
    elif not np.any(with_grid[0].grid.solid_angle_sr > 0):  # type: ignore[union-attr]
        why = "the patches are points"
    if why:
        return None, why
    fixed = fixed_directions([c for c in components if c.grid is None], is_centred=False)
    return PatchInterior(source, with_grid[0], fixed), ""


def _touched(grid: PatchGrid, fixed: np.ndarray) -> np.ndarray:
    """Whether a patch touches a fixed direction, (n_patch,)."""
    found = np.zeros((grid.n_zenith, grid.n_azimuth), dtype=bool)
    (near, far), (low, high) = grid.zenith_bounds_deg.T, grid.azimuth_bounds_deg.T
    for first, last, start, end in fixed:
        columns = (np.mod(start - low, 360.0) <= high - low) | (np.mod(low - start, 360.0) <= end - start)
        found |= ((near <= last) & (first <= far))[:, None] & columns
    return found.ravel()


def _steps_of(bounds: np.ndarray, n: int) -> np.ndarray:
    """Each interval cut into n equal ones."""
    edges = bounds[:, :1] + np.diff(bounds, axis=1) * np.arange(n + 1) / n
    edges[:, -1] = bounds[:, 1]
    return np.stack([edges[:, :-1], edges[:, 1:]], axis=-1).reshape(-1, 2)
