"""How the light of a lobe spreads over patches, from the component alone."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.lobes.patches import patch_mass
from aomc_sky.skies.lobes.quaternion import quaternion_of

_KINDS = {Law.HG: "hg", Law.GGX: "ggx", Law.BECKMANN: "beckmann"}
_KEPT = 64


def lobe_share(component: Component, grid: PatchGrid) -> np.ndarray:
    """Share of the flux of a lobe that comes through each patch.

    Parameters
    ----------
    component : Component
        One of law HG, GGX or BECKMANN.
    grid : PatchGrid
        Patches of the whole hemisphere.

    Returns
    -------
    ndarray, float64, shape (n_patch,)
        Sum 1; accurate as `aomc_sky.skies.lobes.patches.patch_mass`.
    """
    kind, first, second, rotation = lobe_of(component)
    numbers = (kind, first, second, rotation.tobytes(), grid.zenith_bounds_deg.tobytes())
    return _share(*numbers, grid.azimuth_bounds_deg.tobytes())


@lru_cache(maxsize=_KEPT)
def _share(kind: str, first: float, second: float, rotation: bytes, zenith: bytes, azimuth: bytes) -> np.ndarray:
    """The same for values that can be compared, so that bands and frames share the work."""
    grid = PatchGrid(
        zenith_bounds_deg=np.frombuffer(zenith).reshape(-1, 2), azimuth_bounds_deg=np.frombuffer(azimuth).reshape(-1, 2)
    )
    quaternion = quaternion_of(np.frombuffer(rotation).reshape(3, 3))
    mass = patch_mass(kind, first, second, quaternion, grid, weighting="projected")
    share: np.ndarray = mass / mass.sum()
    share.flags.writeable = False
    return share


def lobe_of(component: Component) -> tuple[str, float, float, np.ndarray]:
    """Kind, parameters and rotation of the lobe that a component holds.

    Its matrix is R diag(stretch, 1) times a turn about the axis (`aomc_sky.skies.lobes.frame`), so the stretches are
    the singular values of its first two columns.

    Returns
    -------
    kind, param0, param1 : str, float, float
        As `aomc_sky.skies.lobes.laws.pdf` has them.
    rotation : ndarray, float64, shape (3, 3)
        From local to world.
    """
    assert component.shared is not None  # a lobe always has them
    matrix, asymmetry = component.shared[:9].reshape(3, 3), float(component.shared[9])
    kind = _KINDS[component.law]
    left, stretch, _ = np.linalg.svd(matrix[:, :2], full_matrices=False)
    axis = matrix[:, 2]
    rotation = np.stack([left[:, 0], np.cross(axis, left[:, 0]), axis], axis=1)
    if kind == "hg":
        return kind, asymmetry, 0.0, rotation
    return kind, float(stretch[0]), float(stretch[1]), rotation
