"""Plain numpy or compiled kernels: decided here alone. Both give the same bits."""

from __future__ import annotations

import threading

from aomc_sky.system import interrupts_held

PLAIN_PHOTONS = 6_000_000
"""Photons that a process makes in plain numpy before it loads the kernels: they take as long as loading does, so that
nobody waits more than twice as long as with the better choice, however many follow."""

_lock = threading.Lock()
_done = 0


def use_kernels(n_photons: int) -> bool:
    """Count the next photons, or as much other work; return whether compiled kernels do it, and what follows."""
    global _done  # noqa: PLW0603
    with _lock:
        _done += n_photons
        if _done > PLAIN_PHOTONS:
            with interrupts_held():  # and under the lock: two threads that import parts of it at once break each other
                import numba  # noqa: F401
        return _done > PLAIN_PHOTONS


def announce_photons(n_photons: int) -> None:
    """Take the kernels from the first of so many photons on, where they pay anyway."""
    use_kernels(n_photons if n_photons > PLAIN_PHOTONS else 0)
