"""Projected mass of a lobe in cells of zenith angle and azimuth, from Gauss points inside the cells.

Each cell is integrated with 6 x 6 and with 4 x 4 points; where the two differ it is cut in four, all cells of a level
at once. GGX and Beckmann end at their own horizon: the zenith angles of each azimuth end there too, and cells are
first cut at the azimuths where that horizon crosses their upper or lower edge, so that all pieces are smooth.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.skies.lobes import laws as lobe_laws
from aomc_sky.skies.lobes.contour import TiltedLobe

_FINE, _COARSE = np.polynomial.legendre.leggauss(6), np.polynomial.legendre.leggauss(4)
_TOLERANCE = 1e-15
_LEAST_WIDTH = 1e-3
_MAX_PIECES = 100_000
_CHUNK = 4096


def projected_masses(
    lobe: TiltedLobe, zenith_rad: np.ndarray, azimuth_rad: np.ndarray, left_out: np.ndarray | None = None
) -> np.ndarray | None:
    """Integral of density times cosine of the zenith angle over each cell between edges.

    Parameters
    ----------
    lobe : TiltedLobe
        The lobe.
    zenith_rad, azimuth_rad : ndarray, float64, shapes (n + 1,) and (m + 1,)
        Edges, rising. [rad]
    left_out : ndarray, bool, shape (n, m), optional
        Cells that get 0: those around the axis of a lobe narrower than 1e-3, whose density has lost digits in a
        rounded direction there.

    Returns
    -------
    ndarray, float64, shape (n, m), or None
        Within 1e-14 each; None for a lobe narrower than 1e-3 without `left_out`, and for one that would need more
        than 100 000 pieces and those of the grid.
    """
    n, m = zenith_rad.size - 1, azimuth_rad.size - 1
    if lobe.width < _LEAST_WIDTH and left_out is None:
        return None
    pieces, owner = _first_pieces(lobe, zenith_rad, azimuth_rad)
    if left_out is not None:
        wanted = ~left_out.ravel()[owner]
        pieces, owner = pieces[:, wanted], owner[wanted]
    total, room = np.zeros(n * m), _MAX_PIECES + n * m
    while owner.size:
        room -= owner.size
        if room < 0:
            return None
        mass, doubt = _integrals(lobe, pieces)
        open_ = doubt > _TOLERANCE
        total += np.bincount(owner[~open_], mass[~open_], minlength=n * m)
        pieces, owner = _quarters(pieces[:, open_]), np.tile(owner[open_], 4)
    return total.reshape(n, m)


def _first_pieces(lobe: TiltedLobe, zenith: np.ndarray, azimuth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pieces, shape (6, n_piece), and the cell of each.

    Their rows are the zenith angles of the cell's edges; least and greatest share of the way between the edges, or
    between those of its lit part; least and greatest azimuth.
    """
    crossings = np.zeros((zenith.size - 1, 0))
    if lobe.kind != "hg":
        at_edges = _crossings(lobe, zenith, azimuth[0])
        crossings = np.concatenate([at_edges[:-1], at_edges[1:]], axis=1)
    parts, owner = [], []
    for ring, found in enumerate(crossings):
        inside = found[(found > azimuth[0]) & (found < azimuth[-1])]
        ends = np.unique(np.concatenate([azimuth, inside]))
        edge = np.ones(ends.size - 1)
        parts.append(np.stack([zenith[ring] * edge, zenith[ring + 1] * edge, 0 * edge, edge, ends[:-1], ends[1:]]))
        column = np.searchsorted(azimuth, ends[:-1], side="right") - 1
        owner.append(ring * (azimuth.size - 1) + column)
    return np.concatenate(parts, axis=1), np.concatenate(owner)


def _crossings(lobe: TiltedLobe, zenith: np.ndarray, first: float) -> np.ndarray:
    """Azimuths where the horizon of the lobe crosses each ring, shape (n, 2), within a turn of the first; or NaN."""
    x, y, z = lobe.rotation[:, 2]
    with np.errstate(invalid="ignore", divide="ignore"):
        half = np.arccos(-z * np.cos(zenith) / (np.hypot(x, y) * np.sin(zenith)))
    both = np.arctan2(y, x) + np.stack([-half, half], axis=1)
    return first + np.mod(both - first, 2 * np.pi)


def _integrals(lobe: TiltedLobe, pieces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mass of each piece, and how far the coarse rule is from it."""
    chunks = [pieces[:, i : i + _CHUNK] for i in range(0, pieces.shape[1], _CHUNK)]
    fine = np.concatenate([_gauss(lobe, chunk, *_FINE) for chunk in chunks])
    coarse = np.concatenate([_gauss(lobe, chunk, *_COARSE) for chunk in chunks])
    return fine, np.abs(fine - coarse)


def _gauss(lobe: TiltedLobe, pieces: np.ndarray, node: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Integrals over pieces by the product of one rule; axes are piece, azimuth, zenith angle."""
    low, high, start, stop, left, right = pieces
    half_turn = (right - left)[:, None] / 2
    azimuth = left[:, None] + half_turn * (1 + node)
    cos, sin = np.cos(azimuth), np.sin(azimuth)
    upper, lower = _lit(lobe, low[:, None], high[:, None], cos, sin)
    half = ((lower - upper) * (stop - start)[:, None] / 2)[..., None]
    zenith = (upper + (lower - upper) * start[:, None])[..., None] + half * (1 + node)
    sine, cosine = np.sin(zenith), np.cos(zenith)
    place = np.stack([sine * cos[..., None], sine * sin[..., None], cosine], axis=-1)
    density = lobe_laws.pdf(lobe.kind, lobe.param0, lobe.param1, place @ lobe.rotation)
    by_azimuth = np.sum(density * sine * cosine * half * weight, axis=-1)
    return np.sum(by_azimuth * half_turn * weight, axis=-1)


def _lit(
    lobe: TiltedLobe, low: np.ndarray, high: np.ndarray, cos: np.ndarray, sin: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The zenith angles between `low` and `high` above the lobe's own horizon, for each azimuth."""
    if lobe.kind == "hg":
        return np.broadcast_to(low, cos.shape), np.broadcast_to(high, cos.shape)
    x, y, z = lobe.rotation[:, 2]
    along = x * cos + y * sin
    if z >= 0.0:
        return np.broadcast_to(low, cos.shape), np.clip(np.arctan2(z, -along), low, high)
    return np.clip(np.arctan2(-z, along), low, high), np.broadcast_to(high, cos.shape)


def _quarters(pieces: np.ndarray) -> np.ndarray:
    low, high, start, stop, left, right = pieces
    middle, centre = (start + stop) / 2, (left + right) / 2
    shares, turns = [(start, middle), (middle, stop)], [(left, centre), (centre, right)]
    parts = [np.stack([low, high, *share, *turn]) for share in shares for turn in turns]
    return np.concatenate(parts, axis=1)
