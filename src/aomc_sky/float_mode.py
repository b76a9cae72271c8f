"""The floating-point mode of the thread that calls us: a host may have changed it, and plans may not depend on it.

Round to nearest, and subnormal numbers kept, is what IEEE 754 starts with and what every result here is settled in. A
library for intervals rounds up or down, a host compiled with -ffast-math flushes subnormals to zero: such a mode is set
aside while our functions work, and the host finds it again afterwards.
"""

from __future__ import annotations

import contextlib
import functools
import struct
from collections.abc import Callable, Iterator
from typing import Any, ParamSpec, TypeVar

from aomc_sky.errors import HostError

_P = ParamSpec("_P")
_R = TypeVar("_R")

# names, for the compiler would compute with literals
_ONE, _HALF = 1.0, 0.5
_QUARTER_OF_ULP, _MOST_OF_ULP = 2.0**-54, 1.5 * 2.0**-53
_LEAST_NORMAL = 2.0**-1022
(_LEAST,) = struct.unpack("<d", bytes([1, 0, 0, 0, 0, 0, 0, 0]))  # a literal would be read in the mode of the host

_MXCSR = (0x1F80).to_bytes(4, "little")
"""Control word of SSE with which a process starts; the last of the eight words that Linux keeps of a state."""
_STATE_BYTES = 512
"""More than any system takes for the floating-point state of a thread."""


def is_default() -> bool:
    """Whether this thread rounds to nearest and keeps subnormal numbers."""
    return (
        _ONE + _QUARTER_OF_ULP == _ONE
        and _ONE + _MOST_OF_ULP > _ONE
        and _LEAST_NORMAL * _HALF > 0.0
        and _LEAST * _ONE > 0.0
    )


def require_default(what: str) -> None:
    """Raise HostError where numbers would be made in the mode of the host, inside its own loop."""
    if not is_default():
        raise HostError(
            f"{what} works in the floating-point mode of its host, and this thread does not round to nearest, or "
            "flushes small numbers to zero: call fesetenv(FE_DFL_ENV) first, and link without -ffast-math"
        )


def in_default_mode(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Decorate a function that works in the default mode whatever the host has set."""

    @functools.wraps(function)
    def wrapped(*args: _P.args, **named: _P.kwargs) -> _R:
        if is_default():
            return function(*args, **named)
        with default_mode():
            return function(*args, **named)

    return wrapped


@contextlib.contextmanager
def default_mode() -> Iterator[None]:
    """Work in the default mode while the block runs; the host finds its own one again.

    HostError where another mode is set, and this system does not let it be changed.
    """
    if is_default():
        yield
        return
    from aomc_sky.system import has_linux_sse_state

    library, default, room = _library()
    state = room()
    library.fegetenv(state)
    library.fesetenv(default)
    if not is_default() and has_linux_sse_state():
        library.fesetenv(
            state.raw[:28] + _MXCSR + state.raw[32:]
        )  # glibc leaves the flushing of small numbers as it is
    try:
        if not is_default():
            raise HostError("this thread does not round to nearest, or flushes small numbers to zero; see FE_DFL_ENV")
        yield
    finally:
        library.fesetenv(state)


@functools.cache
def _library() -> tuple[Any, Any, Callable[[], Any]]:
    """The C library, what stands for its default state, and what makes room for another one."""
    import ctypes

    from aomc_sky.system import C_LIBRARY

    try:
        library = ctypes.CDLL(C_LIBRARY)
        library.fegetenv.argtypes = library.fesetenv.argtypes = [ctypes.c_void_p]
    except (OSError, AttributeError) as error:
        raise HostError("this thread does not round to nearest, and this system has no fesetenv") from error
    room = functools.partial(ctypes.create_string_buffer, _STATE_BYTES)
    for name in ("_FE_DFL_ENV", "__fe_dfl_env", "_Fenv1"):
        with contextlib.suppress(ValueError):
            return library, ctypes.addressof(ctypes.c_char.in_dll(library, name)), room
    return library, ctypes.c_void_p(-1), room  # glibc and musl on most processors
