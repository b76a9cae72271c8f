"""Progress on standard error by tqdm, on a terminal and in notebooks: a bar, or the current work and its time."""

from __future__ import annotations

import contextlib
import logging
import shutil
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TextIO, TypeVar

T = TypeVar("T")

_PATIENCE_S = 1.0
"""Shorter work shows nothing."""

STEPS = logging.getLogger("aomc_sky.steps")
"""Gets a text for each part of a loop, at the level of debugging. It passes none on: there are thousands."""
STEPS.propagate = False


def counted(parts: Iterable[T], name: str, n: int) -> Iterator[T]:
    """Pass `n` parts on, and log the number of each before it."""
    for k, part in enumerate(parts, start=1):
        STEPS.debug("%s %d of %d", name, k, n)
        yield part


class _Steps(logging.Handler):
    """Shows the position of the last `counted` loop beside a text."""

    def __init__(self, bar: Any, text: str) -> None:
        super().__init__()
        self.bar, self.text = bar, text

    def emit(self, record: logging.LogRecord) -> None:
        """Show the text."""
        self.bar.set_description_str(f"{self.text}, {record.getMessage()}", refresh=False)


def _stream() -> TextIO | None:
    """Standard error, if it is a terminal or a notebook."""
    stream: TextIO = getattr(sys.stderr, "stream", sys.stderr)  # the cursor is moved past a `VisibleStream`
    return stream if stream.isatty() or "ipykernel" in sys.modules else None


_under_way: list[str] = []


def is_free() -> bool:
    """Whether a function called from Python may show its progress: no command does so already."""
    return not _under_way


@contextlib.contextmanager
def _shown(text: str, *, enabled: bool, unit: str = "") -> Iterator[Any]:
    """Yield a bar of tqdm that shows a text and its time after a second, or None without a terminal or notebook."""
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
    """Show the current work and its time after a second."""
    with _shown(text, enabled=enabled):
        yield


@contextlib.contextmanager
def progress_bar(
    *, enabled: bool, unit: str = "photons", before: str = "preparing"
) -> Iterator[Callable[[int, int], None] | None]:
    """Yield a function of (done, total) that draws a bar, or None without a terminal or notebook.

    The text `before` is shown until its first call.
    """
    with _shown(before, enabled=enabled, unit=unit) as bar:

        def draw(done: int, total: int) -> None:
            if bar.total is None:
                bar.total, bar.bar_format = total, None
                bar.set_description_str("", refresh=False)
            bar.update(done - bar.n)

        yield None if bar is None else draw
