"""Spherical shells, thin enough that the air inside each may be taken as uniform."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from aomc_sky.atmosphere.medium.constituents import Medium
from aomc_sky.atmosphere.medium.optical_depth import columns
from aomc_sky.atmosphere.medium.profile import Profile, density_profile

TOLERANCE = 2e-4
"""Most relative error of a shell taken as uniform, (thickness / scale height)^2 / 24."""

_REFERENCE_TOP_M = 120e3
_STEPS_M = ((0.0, 50.0), (4e3, 100.0), (10e3, 250.0), (30e3, 500.0), (60e3, 1000.0), (_REFERENCE_TOP_M, 0.0))
_FLOOR = 1e-6  # of the largest extinction: below, shells are not halved further
_MOST_SHELLS = 20000


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
    `TOLERANCE` of what the shell adds, wherever the extinction is above 1e-6 of its largest. Cost: 10 ms.
    """
    profile = density_profile(medium)
    edges = np.union1d(_regular_edges(medium.top_m), profile.edge_m)
    edges = edges[np.concatenate([[True], np.diff(edges) > 1e-9 * medium.top_m])]
    while True:
        bent = _bend(profile, edges) > TOLERANCE
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
