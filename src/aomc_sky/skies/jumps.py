"""Meridians and parallels along which a radiance jumps, found by bisection to the last digits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from aomc_sky.skies.quadrature import cut

_EDGE = 1e-9  #: Of a patch: the distance of the outermost points from its edges.
_FIRST, _LATER, CLOSE = (1, 2), (5, 8), (17, 8)
"""Lines through each patch, and intervals of each line: of all skies, of those that have shown a jump, of few patches.

Of the close ones, three lines and one interval lie in a sure spot.
"""
_LINES = 3  #: A curve crosses two lines of one symmetric to it at equal places, but no third one.
_SMOOTH = 1.2  #: Largest ratio of the changes in both halves of an interval without a jump.
_JUMP = 3.0  #: Least ratio in the last interval of one with a jump.
_LEAST = 1e-9  #: Of the largest radiance: smaller jumps are none.
_BISECTIONS = 48
_SAME = 1e-12  #: Farthest that two crossings of one jump are apart. [quarter turns]
_POINTS_AT_ONCE = 2**18
_ROUNDS = 8

#: Radiance at zenith angles and azimuths in quarter turns, which broadcast.
At = Callable[[np.ndarray, np.ndarray], np.ndarray]


def jumps(
    at: At, zenith: np.ndarray, azimuth: np.ndarray, most_parts: int, how: tuple[int, int] = _FIRST
) -> tuple[np.ndarray, np.ndarray]:
    """Zenith angles and azimuths of jumps inside rings and columns, edges (n, 2). [quarter turns]

    Three lines through patches, or through the parts that earlier rounds have cut them into, must cross a jump. None
    are found where there are more than `most_parts` parts.
    """
    found = [np.zeros(0)], [np.zeros(0)]
    for _ in range(_ROUNDS):
        if len(zenith) * len(azimuth) > most_parts:
            return np.zeros(0), np.zeros(0)
        places = _inside(at, zenith, azimuth, how), _inside(lambda y, x: at(x, y), azimuth, zenith, how)
        more = [_shared(some) for some in places]
        if not sum(one.size for one in (places if how == _FIRST else more)):
            break
        how = max(how, _LATER)
        (zenith, _), (azimuth, _) = (cut(edges, some) for edges, some in zip((zenith, azimuth), more, strict=True))
        for known, some in zip(found, more, strict=True):
            known.append(some)
    return np.concatenate(found[0]), np.concatenate(found[1])


def _inside(at: At, along: np.ndarray, across: np.ndarray, how: tuple[int, int]) -> np.ndarray:
    """Places of jumps inside parts, on all lines through them."""
    n_lines, n_intervals = how
    shares = np.linspace(_EDGE, 1.0 - _EDGE, n_intervals + 1), (np.arange(n_lines) + 0.5) / n_lines
    points, lines = (
        edges[:, :1] + (edges[:, 1:] - edges[:, :1]) * share
        for edges, share in zip((along, across), shares, strict=True)
    )
    step = max(1, _POINTS_AT_ONCE // points.size)
    return np.concatenate([_on_lines(at, points, lines.ravel()[k : k + step]) for k in range(0, lines.size, step)])


def _shared(places: np.ndarray) -> np.ndarray:
    """Places that `_LINES` lines or more have."""
    places = np.sort(places)
    groups = np.split(places, np.flatnonzero(np.diff(places) > _SAME) + 1)
    return np.array([group[len(group) // 2] for group in groups if len(group) >= _LINES])


def _on_lines(at: At, points: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """Places of jumps between points, a row for each part, along lines."""
    values = at(points[..., None], lines)
    least = _LEAST * np.abs(values).max(initial=0.0)
    part, k, line = np.nonzero(np.abs(np.diff(values, axis=1)) > least)
    low, high = points[part, k], points[part, k + 1]
    first, last = values[part, k, line], values[part, k + 1, line]
    line = lines[line]
    is_jump = np.ones(low.size, dtype=bool)
    for _ in range(_BISECTIONS):
        if not low.size:
            break
        middle = 0.5 * (low + high)
        value = at(middle, line)
        changes = np.stack([np.abs(value - first), np.abs(last - value)])
        is_first = changes[0] > changes[1]
        low, first = np.where(is_first, low, middle), np.where(is_first, first, value)
        high, last = np.where(is_first, middle, high), np.where(is_first, value, last)
        smaller, larger = np.sort(changes, axis=0)
        is_jump = larger > np.maximum(_JUMP * smaller, least)
        kept = larger > np.maximum(_SMOOTH * smaller, least)
        low, high, first, last, line, is_jump = (one[kept] for one in (low, high, first, last, line, is_jump))
    return np.asarray(0.5 * (low + high)[is_jump])
