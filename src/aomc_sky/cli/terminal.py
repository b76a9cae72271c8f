"""What a command prints: streams that escape control characters, tables, warnings and errors.

All that a command prints passes through a `VisibleStream`: texts of files cannot move the cursor, hide or turn letters.
"""

from __future__ import annotations

import contextlib
import sys
import warnings
from collections.abc import Iterator, Sequence
from typing import Any, TextIO

from aomc_sky.errors import AomcSkyError, InputWarning, ModelLimitWarning, visible


class VisibleStream:
    """A standard stream that escapes control characters, apart from line ends and tabs."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream

    def write(self, text: str) -> int:
        """Write a text, escaped."""
        self.stream.write(visible(text, keep_lines=True))
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
            with contextlib.suppress(OSError, ValueError):  # tables stand before the warnings; main reports this fault
                sys.stdout.flush()
            for text in kept:
                print_warning(text)


def print_warning(text: str) -> None:
    """Print one warning, a rendered problem or a sentence, on standard error."""
    print(text if "warning[" in text else f"aomc-sky: warning: {text}", file=sys.stderr)


def error_text(error: AomcSkyError) -> str:
    """An error as every command prints it: problems with their place, or a sentence."""
    text = str(error)
    return text if "error[" in text else f"aomc-sky: error: {text}"


def table(rows: Sequence[Sequence[str]], head: Sequence[str], *, n_left: int = 0) -> str:
    """Text of a table, a line per row; the first `n_left` columns are aligned to the left, the others to the right."""
    cells = [[visible(cell) for cell in row] for row in (head, *rows)]
    widths = [max(len(row[k]) for row in cells) for k in range(len(head))]
    lines = (
        "  ".join(c.ljust(w) if k < n_left else c.rjust(w) for k, (c, w) in enumerate(zip(row, widths, strict=True)))
        for row in cells
    )
    return "\n".join(map(str.rstrip, lines) if n_left else lines)
