"""Texts of commands for a person: tables, reports and errors."""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from aomc_sky.errors import AomcSkyError, visible


def error_text(error: AomcSkyError) -> str:
    """An error as every command prints it: problems with their place, or a sentence."""
    text = str(error)
    return text if "error[" in text else f"aomc-sky: error: {text}"


WIDTH = 100
"""Most columns of a table."""

_LEAST_TEXT, _MOST_KEY = 20, 30
"""Texts are broken into lines of no fewer letters, and the name of a row into lines of no more."""


def table(rows: Sequence[Sequence[str]], head: Sequence[str], *, n_left: int = 0, n_keys: int = 1) -> str:
    """A table of at most `WIDTH` columns; the first `n_left` are texts, aligned left, the others are aligned right.

    In a wider table the widest texts are broken into lines. If that is not enough, the columns go into several blocks
    that begin with the `n_keys` columns that name a row.
    """
    cells = [[visible(cell) for cell in row] for row in (head, *rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    while _extent(widths) > WIDTH and max(widths[:n_left], default=0) > _LEAST_TEXT:
        widths[widths.index(max(widths[:n_left]))] -= 1
    if _extent(widths) > WIDTH:
        widths[:n_keys] = [min(width, _MOST_KEY) for width in widths[:n_keys]]
        room = WIDTH - _extent(widths[:n_keys]) - _GAP
        widths[n_keys:] = [min(width, room) for width in widths[n_keys:]]
    blocks = _blocks(widths, n_keys, WIDTH)
    for most in range(WIDTH - 1, 0, -1):  # as even as they can be
        narrower = _blocks(widths, n_keys, most)
        if len(narrower) > len(blocks):
            break
        blocks = narrower
    return "\n\n".join("\n".join(_lines(cells, block, widths, n_left)) for block in blocks)


_GAP = 2


def _extent(widths: Sequence[int]) -> int:
    return sum(widths) + _GAP * (len(widths) - 1)


def _blocks(widths: Sequence[int], n_keys: int, most: int) -> list[list[int]]:
    """Columns of blocks that begin with the keys and are, if they can be, no wider than `most`."""
    blocks = [list(range(min(n_keys, len(widths))))]
    for k in range(n_keys, len(widths)):
        if len(blocks[-1]) > n_keys and _extent([widths[j] for j in (*blocks[-1], k)]) > most:
            blocks.append(list(range(n_keys)))
        blocks[-1].append(k)
    return blocks


def _lines(cells: Sequence[Sequence[str]], block: Sequence[int], widths: Sequence[int], n_left: int) -> Iterator[str]:
    """The lines of some columns; a cell that is too wide has several."""
    for row in cells:
        parts = [textwrap.wrap(row[k], widths[k]) if len(row[k]) > widths[k] else [row[k]] for k in block]
        for line in itertools.zip_longest(*parts, fillvalue=""):
            aligned = (
                c.ljust(widths[k]) if k < n_left else c.rjust(widths[k]) for k, c in zip(block, line, strict=True)
            )
            if text := (" " * _GAP).join(aligned).rstrip():
                yield text


MAX_ROWS = 40
"""Rows of a table for a person; --json has all."""


def shown(value: Any, *, most: int = 400, items: int = 12) -> str:
    """A JSON value in one line: texts are cut after `most` characters, lists of more than `items` show their ends.

    Values of a group that are not set are left out.
    """
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {shown(v, most=most)}" for name, v in value.items() if v is not None and v != [])
    if isinstance(value, list | tuple):
        ends = [value[0], "...", value[-1]] if len(value) > items else value
        return " ".join(shown(v, most=most) for v in ends)
    if value is None or isinstance(value, bool):
        return "-" if value is None else "yes" if value else "no"
    text = f"{value:.6g}" if isinstance(value, float) else " ".join(str(value).split())
    return text if len(text) <= most else f"{text[:most]} ..."


def report_text(head: str, values: Mapping[str, Any]) -> str:
    """A report for a person: a line for each value, a table for each list of objects, and one for all spectra.

    Spectra are lists as long as ``wavelength_nm``.
    """
    n_wavelengths = len(values.get("wavelength_nm") or ())
    lines, tables = [head], []
    spectra: dict[str, list[float]] = {}
    for name, value in values.items():
        members = value if isinstance(value, Mapping) else {"": value}
        found = {
            f"{name} {key}".strip(): v
            for key, v in members.items()
            if isinstance(v, list) and 0 < len(v) == n_wavelengths and isinstance(v[0], float)
        }
        spectra |= found
        if name == "notes":
            lines += [f"note: {note}" for note in value]
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            tables.append(f"\n{_plain(name)}:\n{_objects(value, values.get('wavelength_nm') or ())}")
        elif any(isinstance(member, Mapping) for member in members.values()):
            lines += [f"{key}: {shown(member)}" for key, member in members.items()]
        elif value not in (None, [], {}, "") and not found:
            lines.append(f"{_plain(name)}: {shown(value)}")
    if spectra:
        rows = zip(*spectra.values(), strict=True)
        tables.append("\n" + _objects([dict(zip(spectra, row, strict=True)) for row in rows]))
    return "\n".join([*lines, *tables])


def _plain(name: str) -> str:
    return name.replace("_", " ")


_PARTS = {"quaternion": "wxyz"}
"""Members that are several numbers, and the names of the numbers."""


def _objects(objects: Sequence[Mapping[str, Any]], wavelength_nm: Sequence[float] = ()) -> str:
    """A table of objects with the same members; each word of a column's name has its own line."""
    objects = [_labelled(one, wavelength_nm) for one in objects]
    names = [name for name in objects[0] if any(one[name] is not None for one in objects)]
    words = [_plain(name).split() for name in names]
    height = max(map(len, words))
    head, *more = zip(*([""] * (height - len(name)) + name for name in words), strict=True)
    rows = [[shown(one[name]) for name in names] for one in objects[:MAX_ROWS]]
    hidden = len(objects) - MAX_ROWS
    return table([*more, *rows], head) + (f"\n... and {hidden} more (--json has all)" if hidden > 0 else "")


def _labelled(one: Mapping[str, Any], wavelength_nm: Sequence[float]) -> dict[str, Any]:
    """An object whose values are one number each, or numbers with their names or wavelengths."""
    found: dict[str, Any] = {}
    for name, value in one.items():
        if name in _PARTS:
            found[name] = shown(dict(zip(_PARTS[name], value, strict=True))).replace(",", "")
        elif isinstance(value, list) and 0 < len(value) == len(wavelength_nm):
            texts = [f"{nm:g} nm {shown(number)}" for nm, number in zip(wavelength_nm, value, strict=True)]
            found[name] = ", ".join(texts) if len(texts) < 3 else f"{texts[0]} ... {texts[-1]}"
        else:
            found[name] = shown(value, most=40) if isinstance(value, str) else value
    return found
