"""Warnings of a command: kept while it works, printed once each when it is done."""

from __future__ import annotations

import contextlib
import sys
import warnings
from collections.abc import Iterator
from typing import Any

from aomc_sky.cli.terminal import EXTRA, coloured, terminal_of
from aomc_sky.errors import AomcSkyError, InputWarning, ModelLimitWarning, visible
from aomc_sky.extras import optional_module

_OURS = (InputWarning, ModelLimitWarning)


@contextlib.contextmanager
def warnings_at_end() -> Iterator[None]:
    """Keep our warnings while the block runs; print each text once after it, before an error that ends the command.

    Warnings of other packages go their usual way.
    """
    kept: dict[str, None] = {}
    with warnings.catch_warnings():
        for category in _OURS:
            warnings.simplefilter("always", category)
        previous = warnings.showwarning

        def keep(message: Any, category: Any, filename: str, lineno: int, file: Any = None, line: Any = None) -> None:
            if issubclass(category, _OURS):
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
    """Print one warning on standard error, its kind in colour on a terminal.

    Parameters
    ----------
    text : str
        A problem of a file, rendered with its place, or a plain sentence.
    """
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
