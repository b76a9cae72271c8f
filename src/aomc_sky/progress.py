"""Progress on standard error by tqdm, on a terminal and in notebooks: a bar, or the current work and its time."""

from __future__ import annotations

import contextlib
import shutil
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TextIO, TypeVar

T = TypeVar("T")

_PATIENCE_S = 1.0
"""Shorter work shows nothing."""

_under_way: list[tuple[Any, str]] = []
"""Bar, or None, and text of what is under way; the innermost last."""


def is_free() -> bool:
    """Whether a function called from Python may show its progress: no command does so already."""
    return not _under_way


def counted(parts: Iterable[T], name: str, n: int) -> Iterator[T]:
    """Pass `n` parts on, and show the number of each beside the text of what is under way."""
    for k, part in enumerate(parts, start=1):
        bar, text = _under_way[-1] if _under_way else (None, "")
        if bar is not None:
            bar.set_description_str(f"{text}, {name} {k} of {n}", refresh=False)
        yield part


def _stream() -> TextIO | None:
    """Standard error, if it is a terminal or a notebook."""
    stream: TextIO = getattr(sys.stderr, "stream", sys.stderr)  # the cursor is moved past a `VisibleStream`
    return stream if stream.isatty() or "ipykernel" in sys.modules else None


@contextlib.contextmanager
def _shown(text: str, *, enabled: bool, unit: str = "") -> Iterator[Any]:
    """Yield a bar of tqdm that shows a text and its time after a second, or None without a terminal or notebook."""
    stream = _stream() if enabled else None
    with contextlib.nullcontext() if stream is None else _bar(text, unit, stream) as bar:
        _under_way.append((bar, text))
        try:
            yield bar
        finally:
            _under_way.pop()


@contextlib.contextmanager
def _bar(text: str, unit: str, stream: TextIO) -> Iterator[Any]:
    from tqdm.auto import tqdm

    width = shutil.get_terminal_size().columns - len("^C") - 1  # what the terminal adds must not break the line
    how = {"unit": f" {unit}", "unit_scale": True, "bar_format": "{desc}: {elapsed}", "delay": _PATIENCE_S}
    with tqdm(desc=text, file=stream, leave=False, ncols=width, **how) as bar:
        ended = threading.Event()

        def tick() -> None:
            while not ended.wait(_PATIENCE_S):
                bar.update(0)

        clock = threading.Thread(target=tick, daemon=True)
        clock.start()
        try:
            yield bar
        finally:
            ended.set()
            clock.join()


@contextlib.contextmanager
def status_line(text: str, *, enabled: bool) -> Iterator[None]:
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
