"""Progress on standard error, when that is a terminal: a bar with the share done, the rate and the time left; or a
line with what is under way, once it has taken a second.
"""

from __future__ import annotations

import contextlib
import logging
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator

from aomc_sky.cli.terminal import EXTRA, Terminal, terminal_of
from aomc_sky.extras import optional_module
from aomc_sky.steps import STEPS

_INTERVAL_S = 0.1
_PATIENCE_S = 1.0
_BAR_WIDTHS = (8, 40)
"""Narrower bars tell nothing, wider ones no more."""
_WINDOW_S = 20.0
"""The rate is that of so many last seconds: files of an earlier run leave it soon."""
_CLEAR = "\r\033[K"


class _LastStep(logging.Handler):
    """What a loop of the package said last of how far it is; `text` is empty where none did."""

    text = ""

    def emit(self, record: logging.LogRecord) -> None:
        """Keep the text."""
        self.text = record.getMessage()


_last_step = _LastStep()

_under_way: list[tuple[str, float]] = []
"""What `patience` shows and since when, the innermost last; no text where a bar has the line."""


@contextlib.contextmanager
def progress_bar(
    *, enabled: bool, unit: str = "million photons", per_unit: float = 1e6, before: str = "preparing"
) -> Iterator[Callable[[int, int], None] | None]:
    """Give a function of (done, total) that draws the bar, or None where nobody would see it.

    Until it begins, `patience` has the line, with the text `before`. The bar is one line that is drawn over and cleared
    at the end. The cursor is never hidden, so that a command killed at any moment leaves a sane terminal. The rate is
    shown in `unit` per second, each of `per_unit` things.
    """
    terminal = terminal_of(sys.stderr) if enabled else None
    if terminal is None:
        yield None
        return
    known: deque[tuple[float, int]] = deque()  # the first one is there when compilation is over

    def draw(done: int, total: int) -> None:
        now = time.monotonic()
        if total == 0 or (known and now - known[-1][0] < _INTERVAL_S and done < total):
            return
        if not known:
            _under_way.append(("", now))
        known.append((now, done))
        while len(known) > 2 and known[1][0] < now - _WINDOW_S:
            known.popleft()
        rate = (done - known[0][1]) / max(now - known[0][0], 1e-9)
        facts = _facts(done, total, rate, f"{rate / per_unit:.1f} {unit}/s")
        resized = terminal_of(terminal.stream) or terminal
        terminal.stream.write(_CLEAR + _line(resized, done / total, facts))
        terminal.stream.flush()

    with patience(before, enabled=True):
        try:
            yield draw
        finally:
            if known:
                _under_way.pop()
            terminal.stream.write(_CLEAR)
            terminal.stream.flush()


@contextlib.contextmanager
def patience(text: str, *, enabled: bool) -> Iterator[None]:
    """Show how long the block takes once it has taken a second, on a terminal; a line that is cleared in the end.

    Inside another one its text takes the place of the other's while it lasts, and a bar takes the line. Beside it
    stands how far the loop is that was `counted` last.
    """
    terminal = terminal_of(sys.stderr) if enabled else None
    if terminal is None:
        yield
        return
    is_outermost, ended, began = not _under_way, threading.Event(), time.monotonic()
    _under_way.append((text, began))
    _last_step.text = ""
    thread = threading.Thread(target=_show, args=(terminal, ended), daemon=True)
    try:
        if is_outermost:
            STEPS.addHandler(_last_step)
            STEPS.setLevel(logging.DEBUG)
            thread.start()
        yield
    finally:
        _under_way.pop()
        _last_step.text = ""
        if is_outermost:
            STEPS.removeHandler(_last_step)
            STEPS.setLevel(logging.NOTSET)
            ended.set()
            thread.join()
            if time.monotonic() - began >= _PATIENCE_S:
                terminal.stream.write(_CLEAR)
                terminal.stream.flush()


def _show(terminal: Terminal, ended: threading.Event) -> None:
    """Write what is under way every second."""
    while not ended.wait(_PATIENCE_S):
        text, since = ([("", 0.0), *_under_way])[-1]  # the last one may just have ended
        if text:
            step = _last_step.text
            line = f"{_CLEAR}{text}{', ' * bool(step)}{step}: {_clock(time.monotonic() - since)}"
            terminal.stream.write(line[: terminal.width + len(_CLEAR) - 1])
            terminal.stream.flush()


def _facts(done: int, total: int, rate: float, shown_rate: str) -> list[str]:
    """Share done, time left and rate, the most wanted first; before a rate is known, the share alone."""
    share = f"{100 * done // total:3d} %"
    return [share, f"{_clock((total - done) / rate)} left", shown_rate] if rate else [share]


def _clock(seconds: float) -> str:
    """A time as 7 s, 3:07 min, 5:03 h or 12 d."""
    total_s = round(seconds)
    if total_s < 60:
        return f"{total_s} s"
    if total_s < 3600:
        return f"{total_s // 60}:{total_s % 60:02d} min"
    return f"{total_s // 3600}:{total_s % 3600 // 60:02d} h" if total_s < 48 * 3600 else f"{total_s / 86400:.0f} d"


def _line(terminal: Terminal, share: float, facts: list[str]) -> str:
    """The bar and as many of the facts as fit; a ^C that the terminal adds must not break the line."""
    free_width = terminal.width - len("^C") - 1
    while len(facts) > 1 and len("  ".join(facts)) > free_width:
        facts = facts[:-1]
    text = "  ".join(facts)
    width = min(free_width - len(text) - 1, _BAR_WIDTHS[1])
    return text if width < _BAR_WIDTHS[0] else f"{_bar(terminal, share, width)} {text}"


def _bar(terminal: Terminal, share: float, width: int) -> str:
    console = terminal.console()
    if console is None:
        filled = int((width - 2) * share)
        return f"[{'#' * filled}{'-' * (width - 2 - filled)}]"
    bar = optional_module("rich.progress_bar", extra=EXTRA).ProgressBar(
        total=1.0, completed=share, width=width, style="bright_black", complete_style="cyan", finished_style="green"
    )
    with console.capture() as capture:
        console.print(bar, end="")
    drawn: str = capture.get()
    return drawn.ljust(width)  # without colours, what is not done yet is left out
