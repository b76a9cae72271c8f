"""When compiled kernels pay: numba's start-up costs as much as a few million photons in plain numpy."""

from __future__ import annotations

import sys
import threading
from importlib import import_module

PLAIN_PHOTONS = 10_000_000
"""Photons that a process makes in plain numpy before it loads numba (a second, half of one on two cores)."""

_KERNELS = "aomc_sky.kernels.emission.emit"
_lock = threading.Lock()
_made = 0


def use_kernels(n_photons: int) -> bool:
    """Whether the next `n_photons` photons come from the compiled kernels; both ways give the same bits.

    Parameters
    ----------
    n_photons : int
        Size of the batch that is about to be made.

    Returns
    -------
    bool
        True once a process has made many photons, or has loaded the kernels for another reason.
    """
    global _made  # noqa: PLW0603
    if _KERNELS in sys.modules:
        return True
    with _lock:
        _made += n_photons
        return _made > PLAIN_PHOTONS


def expect_photons(n_photons: int) -> None:
    """Load the kernels at once for a job of so many photons that they pay anyway.

    Parameters
    ----------
    n_photons : int
        Photons that the job will make in all.
    """
    if n_photons > PLAIN_PHOTONS:
        import_module(_KERNELS)
