"""Ctrl-C: remembered, for C code that it interrupts may answer with an error of its own."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator
from types import FrameType


@contextlib.contextmanager
def interrupts_told() -> Iterator[None]:
    """Raise KeyboardInterrupt for whatever exception ends the block after Ctrl-C.

    The import of numpy, for one, turns an interrupt into an ImportError. Where SIGINT is handled or ignored already, or
    outside the main thread, nothing is changed.
    """
    was_pressed = False

    def remember(number: int, frame: FrameType | None) -> None:
        nonlocal was_pressed
        was_pressed = True
        raise KeyboardInterrupt

    try:
        is_ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler
        if is_ours:
            signal.signal(signal.SIGINT, remember)
    except ValueError:  # another thread than the main one
        is_ours = False
    try:
        yield
    except Exception as error:
        if was_pressed:
            raise KeyboardInterrupt from error
        raise
    finally:
        if is_ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)
