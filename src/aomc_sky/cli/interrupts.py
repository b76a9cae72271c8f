"""Ctrl-C in a command: remembered where a library turns it into another error, heard where one does not come back."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import threading
from collections.abc import Callable, Iterator
from types import FrameType

from aomc_sky.system import deafness_told, is_tidying, signal_pipe

GRACE_S = 1.5
"""Time for a command to end by itself after Ctrl-C. numba's compiler hears none, and takes up to half a minute."""


@contextlib.contextmanager
def interrupts_remembered() -> Iterator[None]:
    """After Ctrl-C, raise KeyboardInterrupt in place of any exception that ends the block.

    The import of numpy, for example, turns an interrupt into an ImportError. It changes nothing in other threads than
    the main one, or if something else handles or ignores SIGINT.
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


@contextlib.contextmanager
def interrupts_heard(end: Callable[[], None]) -> Iterator[None]:
    """After Ctrl-C, call `end` from another thread if the block goes on for `GRACE_S`, or at a second Ctrl-C.

    `end` ends the process: whatever a run has written by then is of use to the next one, as after a kill. A block that
    is tidying up for other processes is left in peace.
    """
    pipe = signal_pipe() if threading.current_thread() is threading.main_thread() else None
    if pipe is None:
        yield
        return
    heard, told = pipe
    before = signal.set_wakeup_fd(told, warn_on_full_buffer=False)

    def is_pressed(timeout: float | None) -> bool:
        """Whether Ctrl-C comes, or the time has gone, before the block ends."""
        while select.select([heard], [], [], timeout)[0]:
            byte = os.read(heard, 1)
            if byte != bytes([signal.SIGINT]):
                if not byte:
                    return False
                continue
            return True
        return True

    def watch() -> None:
        if is_pressed(None) and is_pressed(GRACE_S) and not is_tidying():
            end()

    watchers: list[threading.Thread] = []

    def listen() -> None:
        """Start the thread where the main one stops hearing: it takes 64 MB of the address space (`ulimit -v`)."""
        if not watchers:
            watchers.append(threading.Thread(target=watch, name="aomc-sky-interrupts", daemon=True))
            watchers[0].start()

    try:
        with deafness_told(listen):
            yield
    finally:
        signal.set_wakeup_fd(before)
        os.close(told)
        for watcher in watchers:
            watcher.join()
        os.close(heard)
