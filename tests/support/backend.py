"""Who makes the photons of a test: plain numpy, as in a process that has just begun, whatever tests ran before it.

The package takes its kernels once they are loaded, and the process of a suite loads them before its first test. So
each test would compile variants of its own for a hundred photons, and which test compiles what would be a matter of
order. Plain and compiled photons are equal to the bit: `tests/unit/kernels` proves it, and these tests take kernels.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

PLAIN_PHOTONS = 500_000
"""Photons that a test makes in plain numpy before it has kernels."""

_USE_KERNELS = "aomc_sky.source.emitter.use_kernels"
_AFTER_PHOTONS = ("aomc_sky.outputs.statistics.use_kernels", "aomc_sky.outputs.photons.mcpl.use_kernels")


class FreshProcess:
    """`use_kernels` for a test: the photons it has made decide, not what is loaded."""

    def __init__(self) -> None:
        self._made = 0

    def begin(self) -> None:
        """Forget what other tests made."""
        self._made = 0

    def use_kernels(self, n_photons: int, is_kept: Callable[[], bool]) -> bool:
        """Whether the next photons come from kernels."""
        self._made += n_photons
        return self._made > PLAIN_PHOTONS


@contextmanager
def fresh_process() -> Iterator[FreshProcess]:
    """Decide by `FreshProcess`; without the JIT kernels make everything, for they are what is tested there."""
    process = FreshProcess()
    with pytest.MonkeyPatch.context() as patch:
        is_compiled = os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")
        patch.setattr(_USE_KERNELS, process.use_kernels if is_compiled else lambda n_photons, is_kept: True)
        yield process


@contextmanager
def photons_by(*, kernels: bool) -> Iterator[None]:
    """All photons, and what follows them, come from kernels, or all from plain numpy."""
    with pytest.MonkeyPatch.context() as patch:
        for name in (_USE_KERNELS, *_AFTER_PHOTONS):
            patch.setattr(name, lambda n_photons, is_kept: kernels)
        yield
