"""Places where a function that is made of pieces goes over from one piece to the next."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from aomc_sky.errors import SceneError

MAX_KINKS = 1000
# of the range: what stops the halving beside zero, where floating-point numbers never end
_FINEST = 2.0**-60


def find_kinks(trace: Callable[[np.ndarray], np.ndarray], samples: np.ndarray) -> np.ndarray:
    """Find where the way through a function changes, by halving.

    Between neighbouring samples of different traces the interval is halved until its ends are neighbouring numbers; a
    third trace that turns up in between is followed to both of its ends. A piece that lies between two samples of equal
    trace is not seen unless a kink of another kind leads to it.

    `trace` takes places (n,) and gives numbers (n,) uint64 that are equal on one piece; `samples` rise. Returns the
    first place of each piece but the first one: a step at ``x < 8000`` gives 8000 itself. A SceneError for more than
    MAX_KINKS.
    """
    traces = trace(samples)
    change = np.flatnonzero(traces[:-1] != traces[1:])
    low, high, above = samples[change], samples[change + 1], traces[change + 1]
    below = traces[change]
    found: list[np.ndarray] = []
    finest = _FINEST * (samples[-1] - samples[0])
    while low.size:
        if low.size + sum(one.size for one in found) > MAX_KINKS:
            raise SceneError(f"there are more than {MAX_KINKS} jumps or bends, which no solver could resolve")
        middle = low + 0.5 * (high - low)
        ended = (middle <= low) | (middle >= high) | (high - low <= finest)
        found.append(high[ended])
        low, high, middle, below, above = (one[~ended] for one in (low, high, middle, below, above))
        between = trace(middle)
        left, right = between != below, between != above
        low, high = np.r_[low[left], middle[right]], np.r_[middle[left], high[right]]
        below, above = np.r_[below[left], between[right]], np.r_[between[left], above[right]]
    return np.unique(np.concatenate(found)) if found else np.empty(0)
