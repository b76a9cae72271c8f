"""What the terminal behind a stream can show; a pipe, a file and a dumb terminal get plain text.

All that a command prints passes through a `VisibleStream`: texts of files cannot move the cursor, hide or turn letters.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import sys
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any, TextIO

from aomc_sky.errors import AomcSkyError, InputWarning, ModelLimitWarning, visible
from aomc_sky.extras import optional_module

EXTRA = "pretty"
_USUAL_WIDTH = 80
_LEAST_WIDTH = 20
_WITHOUT_CURSOR = ("", "dumb", "unknown")
_OURS = f"\x1b{secrets.token_hex(8)}"
"""Stands for the escape of a colour that we chose, until it is written; no file can know it."""


class VisibleStream:
    """A standard stream that escapes control characters, apart from line ends, tabs and colours of our own."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream

    def write(self, text: str) -> int:
        """Write a text, escaped."""
        self.stream.write("\x1b".join(visible(part, keep_lines=True) for part in text.split(_OURS)))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


@contextlib.contextmanager
def visible_streams() -> Iterator[None]:
    """Let standard output and standard error be `VisibleStream` while the block runs."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (VisibleStream(stream) for stream in before)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def coloured(text: str) -> str:
    """A text with colours of our own, whose other parts are `visible`, for a stream that escapes."""
    return text.replace("\x1b", _OURS) if isinstance(sys.stdout, VisibleStream) else text


@dataclass(frozen=True, kw_only=True, slots=True)
class Terminal:
    """A terminal on which lines can be drawn over."""

    stream: TextIO
    width: int  #: columns, 20 or more
    has_colour: bool  #: whether colours and weights of letters are wanted

    def console(self) -> Any:
        """Return the rich console that renders text for this terminal, None where the package is not installed."""
        if find_spec("rich") is None:
            return None
        return optional_module("rich.console", extra=EXTRA).Console(
            file=self.stream,
            width=self.width,
            force_terminal=True,
            color_system="standard" if self.has_colour else None,  # sixteen colours: those that the user has chosen
            highlight=False,
            markup=False,
            emoji=False,
            legacy_windows=False,
            _environ={},  # it has been read already, once for both forms
        )


def terminal_of(stream: TextIO, environment: Mapping[str, str] = os.environ) -> Terminal | None:
    """What stands behind a stream, None where nobody looks or nothing can be drawn over.

    In `environment` ``TERM`` of a terminal without a cursor and ``CI`` ask for plain text, ``NO_COLOR`` for no colours,
    ``COLUMNS`` wins over the width that the terminal says.
    """
    stream = getattr(stream, "stream", stream)  # the cursor is moved past a `VisibleStream`
    in_ci = environment.get("CI", "").lower() not in ("", "0", "false")
    if in_ci or environment.get("TERM", "") in _WITHOUT_CURSOR or not stream.isatty():
        return None
    return Terminal(stream=stream, width=_width(stream, environment), has_colour=not environment.get("NO_COLOR", ""))


def _width(stream: TextIO, environment: Mapping[str, str]) -> int:
    columns = environment.get("COLUMNS", "")
    width = int(columns) if columns.isdecimal() else 0
    if not width:
        try:
            width = os.get_terminal_size(stream.fileno()).columns
        except (OSError, ValueError):  # a stream without a descriptor
            width = 0
    return max(width or _USUAL_WIDTH, _LEAST_WIDTH)


_OF_THIS_PACKAGE = (InputWarning, ModelLimitWarning)


@contextlib.contextmanager
def warnings_at_end() -> Iterator[None]:
    """Keep our warnings while the block runs; print each text once after it, before an error that ends the command.

    Warnings of other packages go their usual way.
    """
    kept: dict[str, None] = {}
    with warnings.catch_warnings():
        for category in _OF_THIS_PACKAGE:
            warnings.simplefilter("always", category)
        previous = warnings.showwarning

        def keep(message: Any, category: Any, filename: str, lineno: int, file: Any = None, line: Any = None) -> None:
            if issubclass(category, _OF_THIS_PACKAGE):
                kept[str(message)] = None
            else:
                previous(message, category, filename, lineno, file, line)

        warnings.showwarning = keep
        try:
            yield
        finally:
            with contextlib.suppress(OSError, ValueError):  # tables stand before the warnings; main tells of this fault
                sys.stdout.flush()
            for text in kept:
                print_warning(text)


def print_warning(text: str) -> None:
    """Print one warning, a rendered problem or a sentence, on standard error; its kind in colour on a terminal."""
    shown = text if "warning[" in text else f"aomc-sky: warning: {text}"
    terminal = terminal_of(sys.stderr)
    console = None if terminal is None else terminal.console()
    if console is not None:
        styled = optional_module("rich.text", extra=EXTRA).Text(visible(shown, keep_lines=True))
        styled.highlight_regex(r"\A[^\n]*?\bwarning(\[\w+\])?:", "yellow")
        with console.capture() as capture:
            console.print(styled, soft_wrap=True)
        shown = coloured(capture.get().rstrip("\n"))
    print(shown, file=sys.stderr)


def error_text(error: AomcSkyError) -> str:
    """An error as every command prints it: problems with their place, or a sentence."""
    text = str(error)
    return text if "error[" in text else f"aomc-sky: error: {text}"
