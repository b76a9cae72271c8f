"""Plain numpy or compiled kernels: decided here alone. Both give the same bits.

numba's start-up costs as much as a few million photons in plain numpy, compiling as many more. So a process works in
plain numpy until it has made so much that kernels pay, or knows that it will; what it has loaded it uses.
"""

from __future__ import annotations

import sys
import threading
from importlib import import_module
from typing import Any

PLAIN_PHOTONS = 6_000_000
"""Photons that a process makes in plain numpy before it loads numba: they take what loading takes, 0.35 s, so that
nobody waits more than twice as long as with the better choice, however many follow."""

PLAIN_PATCHES = 100_000
"""Patches of Perez skies that a process integrates in plain numpy before it compiles the kernels (half a second)."""

PLAIN_NUMBERS = 65_536
"""Numbers of one call below which a phase function is sampled in plain numpy."""


class _Work:
    """One kind of work: the module of its kernels, and how much of it a process does without them."""

    def __init__(self, kernels: str, plain: int) -> None:
        self.kernels, self.plain = f"aomc_sky.kernels.{kernels}", plain
        self._done, self._lock = 0, threading.Lock()

    @property
    def is_loaded(self) -> bool:
        return self.kernels in sys.modules

    def pays(self, n: int) -> bool:
        """Whether the kernels shall do the next n; they count."""
        with self._lock:
            self._done += n
            return self._done > self.plain or self.is_loaded

    def announce(self, n: int) -> None:
        """Load the kernels at once where n pay."""
        if n > self.plain:
            import_module(self.kernels)


_photons = _Work("emission.emit", PLAIN_PHOTONS)
_patches = _Work("perez.sums", PLAIN_PATCHES)


def use_kernels(n_photons: int) -> bool:
    """Whether the next `n_photons` photons come from the compiled kernels."""
    return _photons.pays(n_photons)


def kernels_are_loaded() -> bool:
    """Whether this process has the kernels of the emission: then what follows a photon takes them, too."""
    return _photons.is_loaded


def announce_photons(n_photons: int) -> None:
    """Load the kernels at once for a job of so many photons that they pay anyway."""
    _photons.announce(n_photons)


def perez_sums(n_patches: int) -> Any:
    """The module whose sums integrate the next patches: `kernels.perez.mass`, or the compiled `sums` once that pays."""
    return import_module(_patches.kernels if _patches.pays(n_patches) else "aomc_sky.kernels.perez.mass")


def announce_patches(n_patches: int) -> None:
    """Load the kernels at once for a job of so many patches that they pay anyway."""
    _patches.announce(n_patches)


def fills_by_kernel(n_numbers: int) -> bool:
    """Whether a phase function samples so many numbers by its jitted loops."""
    return n_numbers >= PLAIN_NUMBERS
