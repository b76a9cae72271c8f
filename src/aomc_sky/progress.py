"""Progress on standard error by tqdm, on a terminal and in notebooks: a bar, or what is under way and for how long."""

from __future__ import annotations

import contextlib
import logging
import shutil
import sys
import threading
from collections.abc import Callable, Iterator
from typing import Any, TextIO

from aomc_sky.steps import STEPS

_PATIENCE_S = 1.0
"""What takes no longer shows nothing."""


class _Steps(logging.Handler):
    """Shows how far the loop is that was `counted` last, beside a text."""

    def __init__(self, bar: Any, text: str) -> None:
        super().__init__()
        self.bar, self.text = bar, text

    def emit(self, record: logging.LogRecord) -> None:
        """Show the text."""
        self.bar.set_description_str(f"{self.text}, {record.getMessage()}", refresh=False)


def _stream() -> TextIO | None:
    """Standard error, where somebody watches it."""
    stream: TextIO = getattr(sys.stderr, "stream", sys.stderr)  # the cursor is moved past a `VisibleStream`
    return stream if stream.isatty() or "ipykernel" in sys.modules else None


_under_way: list[str] = []


def is_free() -> bool:
    """Whether a function that Python calls may show its progress: no command is under way that does so, or is quiet."""
    return not _under_way


@contextlib.contextmanager
def _shown(text: str, *, enabled: bool, unit: str = "") -> Iterator[Any]:
    """Give a bar of tqdm that shows a text and its time, once it has taken a second; None where nobody would see it."""
    stream = _stream() if enabled else None
    _under_way.append(text)
    try:
        with contextlib.nullcontext() if stream is None else _bar(text, unit, stream) as bar:
            yield bar
    finally:
        _under_way.pop()


@contextlib.contextmanager
def _bar(text: str, unit: str, stream: TextIO) -> Iterator[Any]:
    from tqdm.auto import tqdm

    width = shutil.get_terminal_size().columns - len("^C") - 1  # what the terminal adds must not break the line
    how = {"unit": f" {unit}", "unit_scale": True, "bar_format": "{desc}: {elapsed}", "delay": _PATIENCE_S}
    with tqdm(desc=text, file=stream, leave=False, ncols=width, **how) as bar:
        ended, steps = threading.Event(), _Steps(bar, text)

        def tick() -> None:
            while not ended.wait(_PATIENCE_S):
                bar.update(0)

        clock = threading.Thread(target=tick, daemon=True)
        level = STEPS.level
        STEPS.addHandler(steps)
        STEPS.setLevel(logging.DEBUG)
        clock.start()
        try:
            yield bar
        finally:
            STEPS.removeHandler(steps)
            STEPS.setLevel(level)
            ended.set()
            clock.join()


@contextlib.contextmanager
def patience(text: str, *, enabled: bool) -> Iterator[None]:
    """Show what is under way and for how long, once it has taken a second."""
    with _shown(text, enabled=enabled):
        yield


@contextlib.contextmanager
def progress_bar(
    *, enabled: bool, unit: str = "photons", before: str = "preparing"
) -> Iterator[Callable[[int, int], None] | None]:
    """Give a function of (done, total) that draws a bar, or None where nobody would see it.

    Until it is called first, the text `before` is shown.
    """
    with _shown(before, enabled=enabled, unit=unit) as bar:

        def draw(done: int, total: int) -> None:
            if bar.total is None:
                bar.total, bar.bar_format = total, None
                bar.set_description_str("", refresh=False)
            bar.update(done - bar.n)

        yield None if bar is None else draw
