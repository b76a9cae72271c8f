"""Lobes of a background sky at a fixed time as components of a scene, one each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component, Law
from aomc_sky.errors import SceneError
from aomc_sky.skies.lobes.envelope import envelope_of
from aomc_sky.skies.lobes.frame import LobeFrame
from aomc_sky.skies.lobes.horizon import mass_above_horizon, mean_cosine

LAWS = {"hg": Law.HG, "ggx": Law.GGX, "beckmann": Law.BECKMANN}

LEAST_MASS = 1e-200
"""A smaller projected share of a lobe counts as none."""


def lobe_components(
    *,
    names: Sequence[str],
    kinds: Sequence[str],
    param0: ArrayLike,
    param1: ArrayLike,
    quaternion: ArrayLike,
    irradiance: ArrayLike,
) -> tuple[Component, ...]:
    """Lower lobes to components whose photons have exactly the flux law: density of the lobe times cosine.

    Parameters
    ----------
    names : sequence of str, n_lobe of them
        Names of the components, all different.
    kinds : sequence of str, n_lobe of them
        "hg", "ggx" or "beckmann".
    param0, param1 : array_like, shape (n_lobe,)
        g and nothing [0 <= g < 1], or the roughness along local x and y [> 0].
    quaternion : array_like, shape (n_lobe, 4)
        Rotations (w, x, y, z) from local to world, of any length but 0.
    irradiance : array_like, shape (n_lobe, n_wl)
        Irradiance of each lobe integrated over the whole sphere: coefficient times curve. [W m-2 nm-1, >= 0]

    Returns
    -------
    tuple of Component
        One for each lobe with light above the horizon, in their order; `strength` is the irradiance of the horizontal
        plane, `below_horizon` the share of the lobe that hangs below. Lobes without light, and those
        whose projected share is below 1e-200, are left out.

    Raises
    ------
    UsageError, SceneError
        Unknown kind; parameter outside its range; quaternion zero; irradiance negative or not finite; shapes that do
        not fit; equal names.

    Notes
    -----
    Cost: about 10 ms for each lobe. Equal lobes share the work.
    """
    light = np.asarray(irradiance, dtype=np.float64)
    shapes = [np.asarray(x, dtype=np.float64) for x in (param0, param1, quaternion)]
    n = len(names)
    if light.ndim != 2 or {len(kinds), len(light), *(len(np.atleast_1d(x)) for x in shapes)} != {n}:
        raise SceneError("every lobe needs a name, a kind, two parameters, a quaternion and a row of irradiances")
    if len(set(names)) != n:
        raise SceneError(f"the names of lobes must differ, got {list(names)}")
    if not np.all((light >= 0.0) & (light < np.inf)):
        raise SceneError("the irradiance of a lobe must be finite and not negative")
    known: dict[bytes, Component | None] = {}
    parts = []
    for name, kind, first, second, turn, row in zip(names, kinds, *shapes, light, strict=True):
        if not row.max(initial=0.0) > 0.0:
            continue
        key = kind.encode() + np.concatenate([[first, second], turn]).tobytes()
        if key not in known:
            known[key] = _unit_lobe(kind, float(first), float(second), turn)
        unit = known[key]
        if unit is not None:
            parts.append(_named(unit, name, row))
    return tuple(parts)


def _named(unit: Component, name: str, irradiance: np.ndarray) -> Component:
    plane = irradiance * unit.strength[0]
    return Component(
        name=name,
        law=unit.law,
        strength=plane,
        mass=unit.mass,
        cell=unit.cell,
        shared=unit.shared,
        bounds=unit.bounds,
        irradiance_W_m2_nm=plane,
        below_horizon=unit.below_horizon,
    )


def _unit_lobe(kind: str, param0: float, param1: float, quaternion: np.ndarray) -> Component | None:
    """The component of a lobe with the irradiance 1 over the sphere; None where nothing of it is above the horizon."""
    projected, above = (
        float(mass_above_horizon(kind, param0, param1, quaternion, weighting=w)) for w in ("projected", "plain")
    )
    if not projected > LEAST_MASS:
        return None
    frame = LobeFrame.of(kind, param0, param1, quaternion)
    mean = mean_cosine(kind, param0, param1, quaternion, projected)
    cells, _ = envelope_of(frame)
    return Component(
        name=kind,
        law=LAWS[kind],
        strength=np.array([projected]),
        mass=np.ones((1, 1)),
        cell=np.array([[mean, 0.0, above / projected, 0.0, 0.0, 1.0]]),
        shared=np.array([*frame.matrix.ravel(), frame.asymmetry]),
        bounds=cells,
        below_horizon=max(1.0 - above, 0.0),
    )
