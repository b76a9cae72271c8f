"""A progress bar on standard error, when that is a terminal."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator

_WIDTH = 30
_INTERVAL_S = 0.1


@contextlib.contextmanager
def progress_bar(
    *, enabled: bool, unit: str = "million photons", per_unit: float = 1e6
) -> Iterator[Callable[[int, int], None] | None]:
    """Yield a function of (done, total) that draws the bar, or None where nobody would see it.

    The speed is shown in `unit` per second, of `per_unit` things each.
    """
    if not enabled or not sys.stderr.isatty():
        yield None
        return
    started = last = time.monotonic()

    def draw(done: int, total: int) -> None:
        nonlocal last
        now = time.monotonic()
        if total == 0 or (now - last < _INTERVAL_S and done < total):
            return
        last = now
        rate = done / max(now - started, 1e-9)
        filled = _WIDTH * done // total
        left = (total - done) / rate if rate else 0.0
        bar = "#" * filled + "-" * (_WIDTH - filled)
        print(
            f"\r[{bar}] {100 * done // total:3d} %  {rate / per_unit:6.1f} {unit}/s  {left:5.0f} s left",
            end="",
            file=sys.stderr,
            flush=True,
        )

    try:
        yield draw
    finally:
        print("\r\033[K", end="", file=sys.stderr, flush=True)
