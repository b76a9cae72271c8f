"""How much memory a scene may take: one limit for files and plans, known before anything is allocated; cache lines."""

from __future__ import annotations

import numpy as np

DEFAULT_LIMIT_BYTES = 2**31
"""What a scene may take where nobody says so: it is a matter of its files, whatever the machine has."""

FREE_BYTES = 2**24
"""What no limit is about: Python itself takes more."""


def allowed(limit_bytes: int | None) -> int:
    """The limit that holds. [bytes]"""
    return DEFAULT_LIMIT_BYTES if limit_bytes is None else limit_bytes


def shown(n_bytes: int) -> str:
    """A size for a person: 345 MiB, 2.6 GiB."""
    return f"{n_bytes / 2**20:.0f} MiB" if n_bytes < 2**30 else f"{n_bytes / 2**30:.1f} GiB"


def advice(n_bytes: int) -> str:
    """An option that lets something so large pass."""
    return f"--max-memory {-(-n_bytes * 5 // 4 // 2**30)}G"


def on_cache_lines(values: np.ndarray) -> np.ndarray:
    """A copy that begins on a cache line, so that a row of 64 bytes lies on one."""
    memory = np.empty(values.nbytes + 64, np.uint8)
    begin = -memory.ctypes.data % 64
    copy = memory[begin : begin + values.nbytes].view(values.dtype)
    copy[:] = values
    return copy
