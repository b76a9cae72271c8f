"""A column of a medium at one wavelength: elements in optical depth, nodes inside them.

All wavelengths share their altitudes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from aomc_sky.skies.atmosphere.medium import Medium, phase_laws, scatterers
from aomc_sky.skies.atmosphere.optical_depth import Profile, columns, density_profile, optical_depth_to_top

NODES_PER_ELEMENT = 4
UNIT_NODES = 0.5 * (1.0 + np.polynomial.legendre.leggauss(NODES_PER_ELEMENT)[0])
"""Gauss nodes of an element, as shares of its optical depth."""

_TALLEST_M = 6000.0  # an element below the stratopause; structure of the ozone layer needs no less
_STRATOPAUSE_M = 48000.0
_N_SEARCH = 4000


@dataclass(frozen=True, kw_only=True, slots=True)
class Slab:
    """Elements of a column from its top to the ground; what is scattered varies smoothly inside each.

    Nodes are inside the elements, never on an edge: jumps of the medium lie between elements.
    """

    edge_depth: np.ndarray  #: (n_element + 1,) optical depth of the edges, 0 at the top, strictly rising
    node_depth: np.ndarray  #: (n_element, n_node) optical depth of the nodes, strictly rising
    #: (n_kind, n_element, n_node) single-scattering albedo of each kind of particle: its share of the extinction. [0 to
    #: 1; sum <= 1]
    scattering: np.ndarray
    #: n_kind of them: cosines of scattering angles (n,) to the phase function (n,). [sr-1]
    phases: tuple[Callable[[np.ndarray], np.ndarray], ...]
    beam: np.ndarray  #: (n_element, n_node) what is left of the direct beam at the nodes. [0 to 1]
    beam_at_ground: float  #: The same at the ground. [0 to 1]

    @property
    def share(self) -> np.ndarray:
        """Share of the optical depth of its element above each node, (n_element, n_node). [0 to 1]"""
        return (self.node_depth - self.edge_depth[:-1, None]) / np.diff(self.edge_depth)[:, None]


@dataclass(frozen=True, kw_only=True, slots=True)
class AltitudeGrid:
    """Elements of a medium by altitude, from the top down, and what lies above their edges and nodes."""

    profile: Profile
    edge_m: np.ndarray  #: (n_element + 1,) altitudes of the edges, from the top to 0. [m]
    node_m: np.ndarray  #: (n_element, n_node) altitudes of the nodes, falling. [m]
    edge_column: np.ndarray  #: (n_element + 1, n_constituent) particles per area above the edges. [m-2]
    #: node_column, node_density: (n_element, n_node, n_constituent) particles per area above the nodes, and per volume
    #: at them. [m-2, m-3]
    node_column: np.ndarray
    node_density: np.ndarray


def altitude_grid(medium: Medium, n_element: int) -> AltitudeGrid:
    """Place elements: crowded in optical depth at top and ground, none across a kink, none too tall."""
    profile = density_profile(medium)
    whole = profile.extinction_m2 @ columns(profile, 0.0, 1.0, medium.top_m)
    lit = whole > 0.0
    weight = (profile.extinction_m2[lit] / whole[lit, None]).mean(axis=0)  # as shares of the whole optical depth
    search = np.unique(np.concatenate([profile.edge_m, np.linspace(0.0, medium.top_m, _N_SEARCH)]))
    above = columns(profile, search, 1.0, medium.top_m) @ weight

    def altitude(depth: np.ndarray) -> np.ndarray:
        return np.interp(-depth, -above, search)

    # crowded at both ends, where radiances along shallow paths change fastest
    clustered = 0.5 * above[0] * (1.0 - np.cos(np.pi * np.arange(n_element + 1) / n_element))
    edges = _edges(profile, altitude(clustered))[::-1]
    depth = np.interp(edges, search, above)
    thick = np.diff(depth) > 1e-9 * above[0]
    depth = np.concatenate([[0.0], depth[1:][thick]])
    depth[-1] = above[0]
    edges = np.concatenate([[medium.top_m], edges[1:][thick]])
    edges[-1] = 0.0
    nodes = altitude(depth[:-1, None] + np.diff(depth)[:, None] * UNIT_NODES)
    return AltitudeGrid(
        profile=profile,
        edge_m=edges,
        node_m=nodes,
        edge_column=columns(profile, edges, 1.0, medium.top_m),
        node_column=columns(profile, nodes, 1.0, medium.top_m),
        node_density=profile.density(nodes.ravel()).reshape(*nodes.shape, -1),
    )


def _edges(profile: Profile, wished: np.ndarray) -> np.ndarray:
    """Rising altitudes from 0 to the top: kinks that are apart, and wished ones that are not next to a kink."""
    kept = [0.0]
    for kink in [*profile.kink_m.tolist(), profile.top_m]:
        if kink - kept[-1] > 1e-6 * profile.top_m:
            kept.append(kink)
    kept[-1] = profile.top_m
    wished = np.sort(wished)[1:-1]
    spacing = np.gradient(wished) if wished.size > 1 else np.ones(1)
    gap = np.min(np.abs(wished[:, None] - kept), axis=1)
    edges = np.sort(np.concatenate([kept, wished[gap > 0.3 * spacing]]))
    pieces = [edges[:1]]
    for low, high in pairwise(edges.tolist()):
        n = int(np.ceil((min(high, _STRATOPAUSE_M) - low) / _TALLEST_M)) if low < _STRATOPAUSE_M else 1
        pieces.append(np.linspace(low, high, max(n, 1) + 1)[1:])
    return np.concatenate(pieces)


def _of_row(law: Callable[[np.ndarray, int], np.ndarray], row: int) -> Callable[[np.ndarray], np.ndarray]:
    return lambda cosine: law(cosine, row)


def slabs_of_medium(medium: Medium, grid: AltitudeGrid, sun_zenith_rad: float) -> tuple[Slab, ...]:
    """The column of every wavelength, lit by the pseudo-spherical beam."""
    points = np.append(grid.node_m.ravel(), 0.0)
    beam = np.exp(-optical_depth_to_top(medium, points, sun_zenith_rad))
    return tuple(_slab(medium, grid, row, beam[row]) for row in range(medium.wavelength_nm.size))


def _slab(medium: Medium, grid: AltitudeGrid, row: int, beam: np.ndarray) -> Slab:
    extinction = grid.profile.extinction_m2[row]
    edges, nodes = grid.edge_column @ extinction, grid.node_column @ extinction
    local = np.maximum(grid.node_density @ extinction, np.finfo(float).tiny)
    kinds = scatterers(medium)
    parts = [medium.constituents[k] for k in kinds]
    density = [grid.node_density[:, :, k] for k in kinds]
    thickness = np.diff(edges)
    least = max(1e-12 * edges[-1], 1e-15)
    empty = thickness < least  # nothing there at this wavelength: nodes at their usual places in next to nothing
    share = (nodes - edges[:-1, None]) / np.where(empty, 1.0, thickness)[:, None]
    share = np.where(empty[:, None], UNIT_NODES, share)
    thickness = np.maximum(thickness, least)
    edges = np.concatenate([[0.0], np.cumsum(thickness)])
    return Slab(
        edge_depth=edges,
        node_depth=edges[:-1, None] + thickness[:, None] * share,
        scattering=np.stack([n * part.scattering_m2[row] / local for n, part in zip(density, parts, strict=True)]),
        phases=tuple(_of_row(law, row) for law in phase_laws(medium)),
        beam=beam[:-1].reshape(nodes.shape),
        beam_at_ground=float(beam[-1]),
    )
