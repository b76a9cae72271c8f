"""Zones of the sky in which photons are counted: up to 16 in mu^2 and 16 in azimuth, on edges of patches."""

from __future__ import annotations

import numpy as np

from aomc_sky.grid import PatchGrid
from aomc_sky.source.options import Placement
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.verify.sky.fixed_directions import WHOLE_TURN, FixedDirections, fixed_directions

N_ZONES = 16
"""Zones in each coordinate: few cells have more power against a defect that reaches far than many have."""

_LEAST_EDGES = 7
"""So many edges of patches, or more, are good enough for zones."""


def choose_zones(source: PhotonSource) -> PatchGrid:
    """Up to 16 x 16 zones for the photons of a source, about equal in mu^2 and in azimuth.

    Edges are those of the first component with patches where it has at least 7 of them: the photons of a zone are then
    those of whole patches. No edge runs through a beam, a disc or another place where photons have one direction, and
    none within 1e-4 degrees of it.
    """
    at_centres = source.plan.options["placement"] == Placement.CENTRE.value
    fixed = fixed_directions(source.components, at_centres=at_centres).with_margins()
    grid = source.grid
    zenith = _edges(_zenith_targets(), _between(grid, "zenith"), fixed.zenith_deg)
    zenith = np.concatenate([[0.0], zenith[(zenith > 0) & (zenith < 90)], [90.0]])
    azimuth = _azimuth_edges(_between(grid, "azimuth"), fixed)
    return PatchGrid(
        zenith_bounds_deg=np.column_stack([zenith[:-1], zenith[1:]]),
        azimuth_bounds_deg=np.column_stack([azimuth[:-1], azimuth[1:]]),
    )


def _zenith_targets() -> np.ndarray:
    return np.rad2deg(np.arcsin(np.sqrt(np.arange(1.0, N_ZONES) / N_ZONES)))


def _between(grid: PatchGrid | None, name: str) -> np.ndarray:
    """Where two rings, or two columns, meet; halfway between them where they are points."""
    if grid is None:
        return np.zeros(0)
    bounds = grid.zenith_bounds_deg if name == "zenith" else grid.azimuth_bounds_deg
    inner = (bounds[:-1, 1] + bounds[1:, 0]) / 2
    if name == "zenith":
        return inner[(inner > 0) & (inner < 90)]
    wrap = (bounds[-1, 1] + bounds[0, 0] + WHOLE_TURN) / 2
    return np.sort(np.mod(np.append(inner, wrap), WHOLE_TURN))


def _azimuth_edges(candidates: np.ndarray, fixed: FixedDirections) -> np.ndarray:
    """Edges once around, the last one a turn after the first."""
    bounded = fixed.azimuth_deg[np.diff(fixed.azimuth_deg, axis=1)[:, 0] < WHOLE_TURN]
    turns = np.concatenate([bounded + turn for turn in (-WHOLE_TURN, 0.0, WHOLE_TURN)])
    targets = np.arange(N_ZONES) * WHOLE_TURN / N_ZONES
    edges = np.unique(np.mod(_edges(targets, candidates, turns), WHOLE_TURN))
    return np.append(edges, edges[0] + WHOLE_TURN) if edges.size else np.array([0.0, WHOLE_TURN])


def _edges(targets: np.ndarray, candidates: np.ndarray, taken: np.ndarray) -> np.ndarray:
    """For each target the nearest candidate that is not taken; with few candidates the targets, moved where taken."""
    low, high = _merged(taken)
    free = candidates[~_is_inside(candidates, low, high)]
    if free.size >= _LEAST_EDGES:
        nearest = free[np.abs(free[:, None] - targets).argmin(axis=0)]
        return np.unique(nearest)
    inside = _is_inside(targets, low, high)
    if low.size:
        place = np.maximum(np.searchsorted(low, targets, side="right") - 1, 0)
        nearer = np.where(targets - low[place] < high[place] - targets, low[place], high[place])
        targets = np.where(inside, nearer, targets)
    return np.unique(targets)


def _merged(intervals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Intervals put together where they meet, in rising order."""
    if len(intervals) == 0:
        return np.zeros(0), np.zeros(0)
    intervals = intervals[np.argsort(intervals[:, 0])]
    reach = np.maximum.accumulate(intervals[:, 1])
    starts = np.flatnonzero(np.append(True, intervals[1:, 0] > reach[:-1]))
    return intervals[starts, 0], reach[np.append(starts[1:] - 1, len(intervals) - 1)]


def _is_inside(values: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    if low.size == 0:
        return np.zeros(values.shape, dtype=bool)
    place = np.searchsorted(low, values, side="right") - 1
    return (place >= 0) & (values < high[np.maximum(place, 0)])
