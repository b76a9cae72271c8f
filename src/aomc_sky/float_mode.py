"""The floating-point mode of the thread that calls us: plans and photons may not depend on it.

IEEE 754 starts with rounding to nearest, and keeps subnormal numbers. A thread that rounds another way is refused. The
flushing of small numbers to zero, which any library linked with -ffast-math switches on, is set aside while our
functions work, and the host finds it again afterwards.
"""

from __future__ import annotations

import contextlib
import functools
import struct
from collections.abc import Callable, Iterator
from typing import ParamSpec, TypeVar

from aomc_sky.errors import HostError
from aomc_sky.system import has_linux_sse_state

_P = ParamSpec("_P")
_R = TypeVar("_R")

# names, for the compiler would compute with literals
_ONE, _HALF = 1.0, 0.5
_QUARTER_OF_ULP, _MOST_OF_ULP = 2.0**-54, 1.5 * 2.0**-53
_LEAST_NORMAL = 2.0**-1022
(_LEAST,) = struct.unpack("<d", bytes([1, 0, 0, 0, 0, 0, 0, 0]))  # a literal would be read in the mode of the host

_FLUSHES = 0x8040
"""Bits of the control word of SSE, which Linux keeps in the bytes 28 to 31 of a state."""
_STATE_BYTES = 512
"""More than any system takes for the floating-point state of a thread."""


def is_default() -> bool:
    """Whether this thread rounds to nearest and keeps subnormal numbers."""
    return _rounds_to_nearest() and _LEAST_NORMAL * _HALF > 0.0 and _LEAST * _ONE > 0.0


def _rounds_to_nearest() -> bool:
    return _ONE + _QUARTER_OF_ULP == _ONE and _ONE + _MOST_OF_ULP > _ONE


def require_default(what: str) -> None:
    """Raise HostError where numbers would be made in the mode of the host, inside its own loop."""
    if not is_default():
        raise HostError(
            f"{what} works in the floating-point mode of its host, and this thread does not round to nearest, or "
            "flushes small numbers to zero: call fesetenv(FE_DFL_ENV) first, and link without -ffast-math"
        )


def in_default_mode(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Decorate a function that works in the default mode alone."""

    @functools.wraps(function)
    def wrapped(*args: _P.args, **named: _P.kwargs) -> _R:
        if is_default():
            return function(*args, **named)
        with default_mode():
            return function(*args, **named)

    return wrapped


@contextlib.contextmanager
def default_mode() -> Iterator[None]:
    """Keep subnormal numbers while the block runs; HostError where another mode cannot be set aside."""
    if is_default():
        yield
        return
    if not _rounds_to_nearest():
        raise HostError("this thread does not round to nearest", "call fesetround(FE_TONEAREST) before aomc-sky")
    if not has_linux_sse_state():
        raise HostError("this thread flushes small numbers to zero", "call fesetenv(FE_DFL_ENV) before aomc-sky")
    import ctypes

    library, state = ctypes.CDLL(None), ctypes.create_string_buffer(_STATE_BYTES)
    library.fegetenv(state)
    word = int.from_bytes(state.raw[28:32], "little") & ~_FLUSHES
    library.fesetenv(state.raw[:28] + word.to_bytes(4, "little") + state.raw[32:])
    try:
        yield
    finally:
        library.fesetenv(state)
