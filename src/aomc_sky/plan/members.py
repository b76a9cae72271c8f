"""The members of plan.npz: a plan's records as arrays by name, and back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.grid import PatchGrid
from aomc_sky.plan.band import PlanBand
from aomc_sky.plan.check import check_members, plan_keys, refused


def as_members(
    bands: Sequence[PlanBand], components: Sequence[Component], cumulative: np.ndarray, options: Mapping[str, Any]
) -> dict[str, np.ndarray]:
    """The arrays that `from_members` reads."""
    n_cells = [component.n_cells for component in components]
    members = {
        "wavelength_nm": np.array([band.wavelength_nm for band in bands]),
        "sky_wavelength_nm": np.array([band.sky_wavelength_nm for band in bands]),
        "requested": np.array([band.requested for band in bands], np.int64),
        "row_of_band": np.array([band.row for band in bands], np.int64),
        "cumulative": cumulative,
        "mass": _joined([component.mass for component in components], axis=1),
        "weight": _weights(components),
        "law": np.repeat(np.array([component.law for component in components], np.int8), n_cells),
        "cell": _joined([component.cell for component in components], axis=0),
        "component_start": np.cumsum([0, *n_cells], dtype=np.int64),
        "keys": plan_keys(options),
    }
    for k, component in enumerate(components):
        if component.grid is not None:
            members[f"zenith_bounds_deg_{k}"] = component.grid.zenith_bounds_deg
            members[f"azimuth_bounds_deg_{k}"] = component.grid.azimuth_bounds_deg
        for name in ("shared", "bounds", "slope", "stokes"):
            if (array := getattr(component, name)) is not None:
                members[f"{name}_{k}"] = array
    if bands[0].irradiance_W_m2_nm is not None:
        members["irradiance_W_m2_nm"] = np.array([band.irradiance_W_m2_nm for band in bands])
        members["horizon_loss"] = np.array([band.horizon_loss for band in bands])
    return members


def from_members(
    members: Mapping[str, np.ndarray], options: Mapping[str, Any]
) -> tuple[tuple[PlanBand, ...], tuple[Component, ...], np.ndarray]:
    """Bands, components and cumulative counts; InputFileError (E952 to E955) names the first member that is wrong."""
    check_members(members, options)
    absolute, loss = members.get("irradiance_W_m2_nm"), members.get("horizon_loss")
    bands = tuple(
        PlanBand(
            wavelength_nm=float(members["wavelength_nm"][band]),
            sky_wavelength_nm=float(members["sky_wavelength_nm"][band]),
            requested=int(members["requested"][band]),
            row=int(members["row_of_band"][band]),
            irradiance_W_m2_nm=None if absolute is None else tuple(absolute[band].tolist()),
            horizon_loss=0.0 if loss is None else float(loss[band]),
        )
        for band in range(members["wavelength_nm"].size)
    )
    components = tuple(_component(members, options, k) for k in range(len(options["components"])))
    return bands, components, members["cumulative"]


def _component(members: Mapping[str, np.ndarray], options: Mapping[str, Any], k: int) -> Component:
    start, end = members["component_start"][k : k + 2].tolist()
    mass, weight = members["mass"][:, start:end], members["weight"]
    try:
        return Component(
            name=options["components"][k],
            law=Law(int(members["law"][start])),
            strength=mass.sum(axis=1),
            mass=mass,
            cell=members["cell"][start:end],
            grid=_grid(members, options, k),
            weight=weight[:, start:end] if weight.size else None,
            shared=members.get(f"shared_{k}"),
            bounds=members.get(f"bounds_{k}"),
            slope=members.get(f"slope_{k}"),
            stokes=members.get(f"stokes_{k}"),
        )
    except ValueError as error:  # types, lengths and masses were checked before: a slope is too steep
        raise refused("E954", f"slope_{k}", str(error)) from None


def _grid(members: Mapping[str, np.ndarray], options: Mapping[str, Any], k: int) -> PatchGrid | None:
    zenith, azimuth = members.get(f"zenith_bounds_deg_{k}"), members.get(f"azimuth_bounds_deg_{k}")
    if zenith is None or azimuth is None:
        return None
    first = options["azimuth_first_index"][k]
    try:
        return PatchGrid(zenith_bounds_deg=zenith, azimuth_bounds_deg=azimuth, azimuth_first_index=first)
    except ValueError as error:
        raise refused("E954", f"zenith_bounds_deg_{k}", str(error)) from None


def _weights(components: Sequence[Component]) -> np.ndarray:
    """Weights of all cells, (n_row, n_cell); (0, 0) where all are 1."""
    parts = [component.weight for component in components if component.weight is not None]
    return _joined(parts, axis=1) if parts else np.zeros((0, 0))


def _joined(parts: Sequence[np.ndarray], axis: int) -> np.ndarray:
    return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=axis)
