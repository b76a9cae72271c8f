"""Plain numpy or compiled kernels: decided here alone. Both give the same bits.

numba's start-up costs as much as a few million photons in plain numpy, compiling as many more. So a process works in
plain numpy until it has made so much that kernels pay, or knows that it will. Machine code that another process has
kept pays sooner.
"""

from __future__ import annotations

import threading
from collections.abc import Callable

PLAIN_PHOTONS = 6_000_000
"""Photons that a process makes in plain numpy before it loads numba: they take what loading takes, 0.35 s, so that
nobody waits more than twice as long as with the better choice, however many follow."""

KEPT_PHOTONS = 1_000_000
"""Photons before it loads machine code that is kept on the disk, which takes 0.05 s."""

PLAIN_NUMBERS = 65_536
"""Numbers of one call below which a phase function is sampled in plain numpy."""


class _Work:
    """How much of one kind of work a process has done."""

    def __init__(self) -> None:
        self._done, self._lock = 0, threading.Lock()

    def add(self, n: int) -> int:
        """Count the next n; return how many there are."""
        with self._lock:
            self._done += n
            return self._done

    def announce(self, n: int, *limits: int) -> None:
        """Begin at the highest limit that n more pass: the first of them are then made as the last."""
        with self._lock:
            self._done = max(self._done, *(limit for limit in limits if n > limit), 0)


_photons = _Work()


def use_kernels(n_photons: int, is_kept: Callable[[], bool]) -> bool:
    """Whether the next photons, or what follows them, come from compiled kernels; `is_kept` says if code is on disk."""
    n = _photons.add(n_photons)
    return n > PLAIN_PHOTONS or (n > KEPT_PHOTONS and is_kept())


def announce_photons(n_photons: int) -> None:
    """Take kernels from the first of so many photons on, where they pay anyway."""
    _photons.announce(n_photons, KEPT_PHOTONS, PLAIN_PHOTONS)


def fills_by_kernel(n_numbers: int) -> bool:
    """Whether a phase function samples so many numbers by its jitted loops."""
    return n_numbers >= PLAIN_NUMBERS
