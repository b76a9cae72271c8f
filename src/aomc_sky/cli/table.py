"""Tables: rich ones or plain ones on a terminal, folded to its width, and plain whole ones everywhere else."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Iterator, Sequence
from itertools import zip_longest
from typing import Any

from aomc_sky.cli.terminal import EXTRA, coloured, terminal_of
from aomc_sky.errors import visible
from aomc_sky.extras import optional_module

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
    room = width - sum(widths[:n_keys]) - _GAP * (n_keys - 1)

    def needed(columns: Sequence[int]) -> int:
        return sum(widths[k] + _GAP for k in columns)

    units = _units(head, n_keys)
    if any(needed(unit) > room for unit in units):
        units = [[k] for unit in units for k in unit]
    part: list[int] = []
    for unit in units:
        if part and needed([*part, *unit]) > room:
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
