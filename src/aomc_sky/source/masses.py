"""The masses of a scene's components as a plan has them, and what cannot be shared out."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from aomc_sky.component import Component
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.plan.allocation import AllocationMethod, allocate, normalise
from aomc_sky.plan.options import SamplingOptions


def joint_mass(components: tuple[Component, ...], row: int) -> np.ndarray:
    """Mass of every cell of all components for one row, shape (n_cell,), any scale; all 0 without light.

    A single component keeps its own masses, so that `allocate` gives the same counts.
    """
    strength = np.array([c.strength[row] for c in components])
    if not strength.max(initial=0.0) > 0:
        return np.zeros(sum(c.n_cells for c in components))
    if len(components) == 1:
        return components[0].mass_of(row)
    parts = []
    for component, part in zip(components, normalise(strength), strict=True):
        mass = component.mass_of(row)
        if part > 0 and not mass.max(initial=0.0) > 0:
            raise SceneError(f"component {component.name!r} has a strength but no mass")
        parts.append(part * normalise(mass) if part > 0 else np.zeros(mass.size))
    return np.concatenate(parts)


def plan_components(components: tuple[Component, ...], rows: np.ndarray, with_weights: bool) -> tuple[Component, ...]:
    """The components with a row for each distinct sky; their masses share the sum 1 of a row, or 0 without light."""
    is_plain = not with_weights or all(component.weight is None for component in components)
    ends = np.cumsum([component.n_cells for component in components])
    mass = np.zeros((rows.size, ends[-1]))
    for k, row in enumerate(rows):
        values = joint_mass(components, int(row))
        if values.max(initial=0.0) > 0:
            mass[k] = normalise(values)
    return tuple(
        dataclasses.replace(
            component,
            strength=part.sum(axis=1),
            mass=part,
            weight=None if is_plain else np.stack([_weight_of(component, int(row)) for row in rows]),
            slope=_rows_of(component.slope, rows),
            stokes=_rows_of(component.stokes, rows),
            irradiance_W_m2_nm=None,
            below_horizon=0.0,
        )
        for component, part in zip(components, np.split(mass, ends[:-1], axis=1), strict=True)
    )


def _rows_of(array: np.ndarray | None, rows: np.ndarray) -> np.ndarray | None:
    """The rows of these wavelengths; one row serves all, and None is none."""
    return array if array is None or len(array) == 1 else array[rows]


def _weight_of(component: Component, row: int) -> np.ndarray:
    """Weights (n_cell,), 1 where a component has none."""
    weight = component.weight_of(row)
    return np.ones(component.n_cells) if weight is None else weight


def refuse_bias(components: Sequence[Component], options: SamplingOptions) -> None:
    """Refuse what a bias makes wrong: allocations whose mean is not N q, and other weights."""
    if options.allocation not in (AllocationMethod.SYSTEMATIC, AllocationMethod.MULTINOMIAL):
        raise UsageError(
            f"a bias with allocation {options.allocation.value!r} makes the light wrong: its counts are not those of "
            "the shares on average",
            "take allocation systematic or multinomial",
        )
    if any(component.weight is not None for component in components):
        raise UsageError("a bias beside weights of photons that are launched by solid angle", "leave one of them out")


def aomc_cumulative(components: tuple[Component, ...], n_photons: np.ndarray, row_of_band: np.ndarray) -> np.ndarray:
    """Photons before each cell (n_band, n_cell + 1), by the AOMC program's rounding of the table of each band."""
    component = components[0]
    grid = component.grid
    if len(components) != 1 or grid is None:
        raise SceneError("allocation 'aomc' is the AOMC program's rule for a table; this scene is not a single table")
    cumulative = np.zeros((n_photons.size, component.n_cells + 1), dtype=np.int64)
    for band, (row, n) in enumerate(zip(row_of_band.tolist(), n_photons.tolist(), strict=True)):
        table = component.mass_of(row).reshape(grid.n_zenith, grid.n_azimuth)
        cumulative[band, 1:] = np.cumsum(allocate(table, n, method=AllocationMethod.AOMC))
    return cumulative
