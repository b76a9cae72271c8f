"""The importance of patches as a caller gives it: a table or a function, one number for each patch of a component."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from aomc_sky.component import Component
from aomc_sky.errors import UsageError, floats


def importance_of(components: Sequence[Component], given: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Photons per light of the patches of each component that is named, float64 (n_cell,), in any scale."""
    by_name = {component.name: component for component in components}
    found: dict[str, np.ndarray] = {}
    for name, wanted in given.items():
        if name not in by_name:
            raise UsageError(f"importance: there is no component {name!r}", f"the components are {', '.join(by_name)}")
        grid = by_name[name].grid
        if grid is None:
            raise UsageError(f"importance: {name!r} has no patches", f"write bias={{{name!r}: share}}")
        values = floats("importance", _called(wanted, grid.zenith_bounds_deg, grid.azimuth_bounds_deg))
        if values.shape == (grid.n_patches,):
            values = values.reshape(grid.n_zenith, grid.n_azimuth)
        try:
            table = np.broadcast_to(values, (grid.n_zenith, grid.n_azimuth))
        except ValueError:
            shape = (grid.n_zenith, grid.n_azimuth)
            raise UsageError(f"importance of {name!r} has the shape {values.shape}", f"give {shape}") from None
        if not np.all((table > 0) & np.isfinite(table)):
            raise UsageError(f"importance of {name!r} has values that are not positive and finite")
        found[name] = np.array(table, np.float64).ravel()
    return found


def _called(wanted: Any, zenith_bounds_deg: np.ndarray, azimuth_bounds_deg: np.ndarray) -> Any:
    """The values of a function of zenith angle and azimuth in the middle of the patches. [rad]"""
    if not isinstance(wanted, Callable):  # type: ignore[arg-type]
        return wanted
    zenith, azimuth = (np.deg2rad(bounds.mean(axis=1)) for bounds in (zenith_bounds_deg, azimuth_bounds_deg))
    return wanted(zenith[:, None], azimuth[None, :])
