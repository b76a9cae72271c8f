"""Who makes the photons of a test: plain numpy, as in a process that has just begun, whatever tests ran before it.

Otherwise each test would compile variants of its own for a hundred photons, and which test compiles what would be a
matter of order. Plain and compiled photons are equal to the bit: `tests/emission/kernels` proves it, with kernels.
"""

import os
from contextlib import contextmanager

import pytest

from aomc_sky.kernels import backend

PLAIN_PHOTONS = 500_000
"""Photons that a test makes in plain numpy before it has kernels."""

_MANY = 10**18


def begin_process():
    """Forget what other tests made; without the JIT kernels make everything, for they are what is tested there."""
    backend.PLAIN_PHOTONS = PLAIN_PHOTONS
    backend._done = 0 if os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0") else _MANY


@contextmanager
def photons_by(*, kernels):
    """All photons, and what follows them, come from kernels, or all from plain numpy."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(backend, "_done", _MANY if kernels else -_MANY)
        yield
