"""What the terminal behind a stream can show; a pipe, a file and a dumb terminal get plain text.

All that a command prints passes through a `VisibleStream`: texts of files cannot move the cursor, hide or turn letters.
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
import textwrap
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import zip_longest
from typing import Any, TextIO

from aomc_sky.errors import AomcSkyError, InputWarning, ModelLimitWarning, visible
from aomc_sky.extras import optional_module

EXTRA = "pretty"
_USUAL_WIDTH = 80
_LEAST_WIDTH = 20
_WITHOUT_CURSOR = ("", "dumb", "unknown")
_OURS = f"\x1b{os.urandom(8).hex()}"
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
    """Print one warning, a rendered problem or a sentence, on standard error."""
    print_problem(text if "warning[" in text else f"aomc-sky: warning: {text}")


def print_problem(text: str) -> None:
    """Print errors or warnings on standard error, in colour where that is wanted."""
    print(_painted(text, _OF_PROBLEMS, sys.stderr), file=sys.stderr)


def error_text(error: AomcSkyError) -> str:
    """An error as every command prints it: problems with their place, or a sentence."""
    text = str(error)
    return text if "error[" in text else f"aomc-sky: error: {text}"


_BOLD, _RED, _YELLOW, _CYAN, _GREEN = "1", "1;31", "33", "36", "1;32"
_OF_PROBLEMS = (
    (re.compile(r"(?m)^(?=\S)([^\n]*?\b)(error(?:\[\w+\])?:)"), (_BOLD, _RED)),
    (re.compile(r"(?m)^(?=\S)([^\n]*?\b)(warning(?:\[\w+\])?:)"), (_BOLD, _YELLOW)),
    (re.compile(r"(?m)^( {6}(?:=|\| *(?=\^)))(.*)$"), ("", _CYAN)),
)
_OF_HELP = (
    (re.compile(r"(?m)^()(usage:|[^\s:][^:\n]*:$)"), ("", _GREEN)),
    (re.compile(r"(?m)^(  )((?:-\w, )?--?[a-z][a-z0-9-]*)"), ("", _CYAN)),
)
"""Texts of two groups, and the colours of both: place and kind of a problem, and what to do; heads and options."""


def painted_help(text: str, stream: TextIO) -> str:
    """Help with colours where the stream shows them."""
    return _painted(text, _OF_HELP, stream)


def _painted(text: str, rules: Sequence[tuple[re.Pattern[str], tuple[str, str]]], stream: TextIO) -> str:
    if not wants_colour(stream):
        return text
    escape = _OURS if isinstance(stream, VisibleStream) else "\x1b"

    def paint(code: str, part: str) -> str:
        return f"{escape}[{code}m{part}{escape}[0m" if code and part else part

    for pattern, (first, second) in rules:
        text = pattern.sub(lambda found, a=first, b=second: paint(a, found[1]) + paint(b, found[2]), text)  # type: ignore[misc]
    return text


def wants_colour(stream: TextIO, environment: Mapping[str, str] = os.environ) -> bool:
    """Whether a text may have colours: on a terminal, or with ``FORCE_COLOR``; never with ``NO_COLOR``."""
    if environment.get("NO_COLOR", "") or environment.get("FORCE_COLOR", "") == "0":
        return False
    return bool(environment.get("FORCE_COLOR", "")) or terminal_of(stream, environment) is not None


_GAP = 2
"""Blanks between columns."""

_LEAST_TEXT = 24
"""Words in narrower columns are hard to read; columns are rather folded."""

Row = Sequence[str]


def table(rows: Sequence[Row], head: Row, *, n_left: int = 0, n_keys: int = 1) -> str:
    """Text of a table for standard output; the first `n_left` columns are aligned to the left, the others to the right.

    A pipe or a file gets one line per row, whatever its length. On a terminal that is too narrow long cells are folded
    into several lines, and where that is not enough the columns into several tables one below the other, each with the
    first `n_keys` columns, which say what a row is, again.
    """
    head, rows = _printable(head), [_printable(row) for row in rows]
    terminal = terminal_of(sys.stdout)
    if terminal is None:
        return _plain(rows, head, _widths(rows, head), n_left)
    console = terminal.console()
    natural = _widths(rows, head)
    widths = _squeezed(natural, terminal.width) or _limited(natural, n_keys, terminal.width)
    parts = []
    for columns in _folds(widths, head, n_keys, terminal.width):
        own_rows = [[row[k] for k in columns] for row in rows]
        own_head = [head[k] for k in columns]
        own_widths = [widths[k] for k in columns]
        if console is None:
            parts.append(_plain(own_rows, own_head, own_widths, n_left))
        else:
            parts.append(_rich(console, own_rows, own_head, own_widths))
    return "\n\n".join(parts)


def _printable(row: Row) -> list[str]:
    """Cells without control characters: names in files need not be kind to a terminal."""
    return [cell if cell.isprintable() else _without_controls(cell) for cell in row]


def _without_controls(text: str) -> str:
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def _widths(rows: Sequence[Row], head: Row) -> list[int]:
    return [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]


def _squeezed(widths: Sequence[int], width: int, least: int = _LEAST_TEXT) -> list[int]:
    """Widths at which columns stand side by side, the widest made narrower; none where that gets too narrow."""
    squeezed = list(widths)
    while sum(squeezed) + _GAP * (len(squeezed) - 1) > width:
        widest = max(range(len(squeezed)), key=squeezed.__getitem__)
        if squeezed[widest] <= least:
            return []
        squeezed[widest] -= 1
    return squeezed


def _limited(widths: Sequence[int], n_keys: int, width: int) -> list[int]:
    """Widths at which the keys, in half of the width, and any one column stand side by side."""
    keys = _squeezed(widths[:n_keys], width // 2, least=1) or [1] * n_keys
    left = width - sum(keys) - _GAP * n_keys
    return [*keys, *(min(w, left) for w in widths[n_keys:])]


def _units(head: Row, n_keys: int) -> list[list[int]]:
    """Indices of the columns beside the keys; one with its head in brackets belongs to the one before it."""
    units: list[list[int]] = []
    for k in range(n_keys, len(head)):
        if units and head[k].startswith("("):
            units[-1].append(k)
        else:
            units.append([k])
    return units


def _folds(widths: Sequence[int], head: Row, n_keys: int, width: int) -> Iterator[list[int]]:
    """Indices of the columns of every part: the keys, and as many others as the width takes."""
    keys = list(range(n_keys))
    free_width = width - sum(widths[:n_keys]) - _GAP * (n_keys - 1)

    def needed(columns: Sequence[int]) -> int:
        return sum(widths[k] + _GAP for k in columns)

    units = _units(head, n_keys)
    if any(needed(unit) > free_width for unit in units):
        units = [[k] for unit in units for k in unit]
    part: list[int] = []
    for unit in units:
        if part and needed([*part, *unit]) > free_width:
            yield [*keys, *part]
            part = []
        part += unit
    yield [*keys, *part]


def _lines_of(cell: str, width: int) -> list[str]:
    """A cell in lines of a width; a cell that fits stays as it is."""
    return [cell] if len(cell) <= width else textwrap.wrap(cell, width)


def _plain(rows: Sequence[Row], head: Row, widths: Sequence[int], n_left: int) -> str:
    lines = []
    for row in (head, *rows):
        cells = [_lines_of(cell, width) for cell, width in zip(row, widths, strict=True)]
        for line in zip_longest(*cells, fillvalue=""):
            padded = [
                c.rjust(w) if k >= n_left else c.ljust(w) for k, (c, w) in enumerate(zip(line, widths, strict=True))
            ]
            lines.append((" " * _GAP).join(padded))
    return "\n".join(lines if not n_left else map(str.rstrip, lines))


def _is_number(text: str) -> bool:
    try:
        float(text.split(" ", 1)[0])
    except ValueError:
        return text in ("", "-")
    return True


def _rich(console: Any, rows: Sequence[Row], head: Row, widths: Sequence[int]) -> str:
    """Numbers to the right, words to the left, a rule below the heads."""
    box, rich_table, text = (optional_module(f"rich.{name}", extra=EXTRA) for name in ("box", "table", "text"))
    drawn = rich_table.Table(
        box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0), header_style="bold"
    )
    for k, (name, width) in enumerate(zip(head, widths, strict=True)):
        is_number = all(_is_number(row[k]) for row in rows)
        drawn.add_column(
            text.Text("\n".join(_lines_of(name, width))),
            justify="right" if is_number else "left",
            width=width,
            overflow="fold",
            style="" if k else "cyan",
        )
    for row in rows:
        drawn.add_row(*(text.Text("\n".join(_lines_of(visible(cell), w))) for cell, w in zip(row, widths, strict=True)))
    with console.capture() as capture:
        console.print(drawn)
    shown: str = capture.get()
    return coloured(shown.rstrip("\n"))
