"""Settle a scene: joint masses, exact integer counts, keys."""

from __future__ import annotations

import dataclasses
from typing import NoReturn, Protocol

import numpy as np

from aomc_sky import memory
from aomc_sky.component import Component
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.footprint import Footprint
from aomc_sky.sampling import streams
from aomc_sky.sampling.allocation import AllocationMethod, allocate, allocate_bands
from aomc_sky.sampling.mass import normalise
from aomc_sky.source.irradiance import Irradiance
from aomc_sky.source.options import Placement, SamplingOptions
from aomc_sky.source.plan.plan import Plan
from aomc_sky.source.plan.schema import plan_keys
from aomc_sky.wavebands import Wavebands


class PlannedScene(Protocol):
    """What a plan is settled from: a `Scene`, which asks for its plan and so is not known here."""

    @property
    def wavebands(self) -> Wavebands:
        """The wavebands of the run."""

    @property
    def n_photons(self) -> np.ndarray:
        """Photons wanted in each band, int64."""

    @property
    def components(self) -> tuple[Component, ...]:
        """What shines."""

    @property
    def row_of_band(self) -> np.ndarray:
        """Row of the components that serves each band."""

    @property
    def sky_wavelength_nm(self) -> np.ndarray:
        """Wavelength of the sky that serves each band, or NaN."""

    @property
    def footprint(self) -> Footprint:
        """Where photons enter."""

    @property
    def irradiance(self) -> Irradiance | None:
        """Absolute units, where they are known."""

    def refuse_dark_band(self, band: int) -> NoReturn:
        """Raise the error for a band that wants photons and has no light."""


MAX_REPLICATES_BYTES = 2**32
"""Largest cumulative counts of a plan with replicates: what fits the machines that run it."""

ARRAYS_HELD = 3
"""How often the arrays of a plan stand in memory while a run writes it: measured, 3.06 times for 9e6 cells."""


def joint_mass(components: tuple[Component, ...], row: int) -> np.ndarray:
    """Mass of every cell of all components for one row, shape (n_cell,), any scale; all 0 without light.

    A single component keeps its own masses, so that its counts are those of `allocate`.
    """
    strength = np.array([c.strength[row] for c in components])
    if not strength.max(initial=0.0) > 0:
        return np.zeros(sum(c.n_cells for c in components))
    if len(components) == 1:
        return components[0].mass_of(row)
    parts = []
    for component, part in zip(components, normalise(strength), strict=True):
        if part > 0 and not component.mass_of(row).max(initial=0.0) > 0:
            raise SceneError(f"component {component.name!r} has a strength but no mass")
        parts.append(part * normalise(component.mass_of(row)) if part > 0 else np.zeros(component.n_cells))
    return np.concatenate(parts)


def build_plan(scene: PlannedScene, seed: int, options: SamplingOptions, max_memory_bytes: int | None = None) -> Plan:
    """Settle the photon counts of a scene and all that its photons depend on.

    Each row of counts sums exactly to the request, except under `aomc` allocation. `max_memory_bytes` refuses what
    takes more before it takes any; 2 GiB by default. SceneError: a waveband wants photons and has no light, or fewer
    photons than replicates.
    """
    components, chosen = scene.components, _plan_options(scene, seed, options)
    _refuse_centres(components, options)
    rows, row_of_band = np.unique(scene.row_of_band, return_inverse=True)
    _refuse_large_plan(scene, rows.size, options.replicates, max_memory_bytes)
    mass, cumulative = _masses_and_counts(scene, rows, row_of_band, seed, options)
    arrays = {
        "wavelength_nm": scene.wavebands.wavelength_nm,
        "sky_wavelength_nm": scene.sky_wavelength_nm,
        "requested": scene.n_photons,
        "cumulative": cumulative,
        "row_of_band": row_of_band.astype(np.int64),
        "mass": mass,
        "weight": _weights(components, rows) if options.weights else np.zeros((0, 0)),
        "keys": plan_keys(chosen),
        **_cell_arrays(components),
    }
    if scene.irradiance is not None:
        arrays |= scene.irradiance.as_arrays()
    arrays = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    for array in arrays.values():
        array.flags.writeable = False
    return Plan(arrays=arrays, options=chosen)


def _refuse_centres(components: tuple[Component, ...], options: SamplingOptions) -> None:
    lobes = [c.name for c in components if c.law.is_lobe]
    if lobes and options.placement is Placement.CENTRE:
        raise SceneError(
            f"placement 'centre' puts photons in the middle of patches, and the lobe {lobes[0]!r} has none; "
            "take placement r2 or philox"
        )


def _masses_and_counts(
    scene: PlannedScene, rows: np.ndarray, row_of_band: np.ndarray, seed: int, options: SamplingOptions
) -> tuple[np.ndarray, np.ndarray]:
    """Probabilities (n_row, n_cell), and the photons before each cell (n_replicate_band, n_cell + 1)."""
    n_cells = sum(c.n_cells for c in scene.components)
    requested = replicate_band_photons(scene, options.replicates)
    mass = np.zeros((rows.size, n_cells))
    cumulative = np.zeros((requested.size, n_cells + 1), dtype=np.int64)
    for k, row in enumerate(rows):
        values = joint_mass(scene.components, int(row))
        mass[k] = normalise(values) if values.max(initial=0.0) > 0 else 0.0
        replicate_bands = np.flatnonzero(np.tile(row_of_band == k, options.replicates))
        counts = _counts(scene, values, int(row), replicate_bands, requested[replicate_bands], seed, options)
        cumulative[replicate_bands, 1:] = np.cumsum(counts, axis=1)
    return mass, cumulative


def _refuse_large_plan(scene: PlannedScene, n_rows: int, replicates: int, limit: int | None) -> None:
    n_bands, n_cells = scene.wavebands.n_bands, sum(c.n_cells for c in scene.components)
    size = 8 * replicates * n_bands * (n_cells + 1)
    if replicates > 1 and size > MAX_REPLICATES_BYTES:
        raise SceneError(
            f"{replicates} replicates of {n_bands} wavebands of {n_cells} cells make a plan of {size / 2**30:.1f} GiB, "
            f"more than {MAX_REPLICATES_BYTES / 2**30:g} GiB; ask for fewer replicates or larger cells"
        )
    arrays = size + 8 * n_rows * n_cells + sum(c.cell.nbytes for c in scene.components)
    n_bytes = ARRAYS_HELD * arrays
    if n_bytes > max(memory.allowed(limit), memory.FREE_BYTES):
        raise UsageError(
            f"a plan of {n_bands} wavebands of {n_cells} cells takes about {memory.shown(n_bytes)} of memory, more "
            f"than the {memory.shown(memory.allowed(limit))} of --max-memory; take larger cells, or write "
            f"{memory.advice(n_bytes)}"
        )


def replicate_band_photons(scene: PlannedScene, replicates: int) -> np.ndarray:
    """Photons asked for in each replicate band, int64, shape (n_replicate x n_band,).

    The replicates of a band share its photons evenly; the first ones take one more where some are left.
    """
    photons = scene.n_photons
    few = np.flatnonzero((photons > 0) & (photons < replicates))
    if few.size:
        raise SceneError(
            f"waveband {few[0] + 1} has {photons[few[0]]} photons, too few for {replicates} replicates; "
            "ask for more photons or for fewer replicates"
        )
    each, left = np.divmod(photons, replicates)
    return np.concatenate([each + (left > r) for r in range(replicates)])


def _cell_arrays(components: tuple[Component, ...]) -> dict[str, np.ndarray]:
    """Laws, parameters and bounds of the cells of all components."""
    arrays = {
        "law": np.concatenate([np.full(c.n_cells, int(c.law), np.int8) for c in components]),
        "cell": np.concatenate([c.cell for c in components]),
        "component_start": np.concatenate([[0], np.cumsum([c.n_cells for c in components])]).astype(np.int64),
    }
    for k, component in enumerate(components):
        if component.grid is not None:
            arrays[f"zenith_bounds_deg_{k}"] = component.grid.zenith_bounds_deg
            arrays[f"azimuth_bounds_deg_{k}"] = component.grid.azimuth_bounds_deg
        if component.shared is not None and component.bounds is not None:
            arrays[f"shared_{k}"], arrays[f"bounds_{k}"] = component.shared, component.bounds
    return arrays


def _counts(
    scene: PlannedScene,
    mass: np.ndarray,
    row: int,
    replicate_bands: np.ndarray,
    requested: np.ndarray,
    seed: int,
    options: SamplingOptions,
) -> np.ndarray:
    """Counts (n_replicate_band, n_cell) of the replicate bands that share the masses of one row."""
    if options.allocation is AllocationMethod.AOMC:
        return _aomc_counts(scene, row, requested)
    if not mass.max(initial=0.0) > 0:
        wanting = replicate_bands[requested > 0]
        if wanting.size:
            scene.refuse_dark_band(int(wanting[0]))  # those of the first replicate are the bands
        return np.zeros((replicate_bands.size, mass.size), dtype=np.int64)
    return allocate_bands(
        mass, requested, replicate_bands, method=options.allocation, seed=seed, family=options.method.value
    )


def _aomc_counts(scene: PlannedScene, row: int, requested: np.ndarray) -> np.ndarray:
    if len(scene.components) != 1 or scene.components[0].grid is None:
        raise SceneError("allocation 'aomc' is the program's rule for a table; this scene is not one table")
    component = scene.components[0]
    grid = component.grid
    assert grid is not None
    table = component.mass_of(row).reshape(grid.n_zenith, grid.n_azimuth)
    return np.stack([allocate(table, int(n), method=AllocationMethod.AOMC).ravel() for n in requested])


def _weights(components: tuple[Component, ...], rows: np.ndarray) -> np.ndarray:
    if all(c.weight is None for c in components):
        return np.zeros((0, 0))
    weight = np.empty((rows.size, sum(c.n_cells for c in components)))
    for k, row in enumerate(rows):
        parts = [c.weight_of(int(row)) for c in components]
        weight[k] = np.concatenate(
            [np.ones(c.n_cells) if w is None else w for c, w in zip(components, parts, strict=True)]
        )
    return weight


def _plan_options(scene: PlannedScene, seed: int, options: SamplingOptions) -> dict[str, object]:
    chosen = dataclasses.asdict(options)
    return {
        "stream": streams.STREAM_VERSION,
        "seed": int(seed),
        **{name: getattr(value, "value", value) for name, value in chosen.items()},
        "footprint": [scene.footprint.shape.value, scene.footprint.size_x_m, scene.footprint.size_y_m],
        "components": [c.name for c in scene.components],
        "azimuth_first_index": [0 if c.grid is None else c.grid.azimuth_first_index for c in scene.components],
    }
