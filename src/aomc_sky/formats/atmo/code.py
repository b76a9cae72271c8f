"""Code blocks of a description file: raw lines between two fences, taken as they stand."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

from aomc_sky.formats.atmo.keys import Code, Rule
from aomc_sky.formats.atmo.lines import Entry, Lines
from aomc_sky.formats.bad_value import quoted
from aomc_sky.source_text import SourceText

_FENCE = re.compile(r"\s*```\s*\Z")
_ADVICE = "write ``` alone in the line below the key"


def with_code(lines: Lines, entry: Entry, keys: Mapping[str, Rule]) -> Entry:
    """Add the code block below an entry, if its key wants one or if there is one.

    Parameters
    ----------
    lines : Lines
        Read up to the line of the entry.
    entry : Entry
        Key and value.
    keys : mapping of str to Rule
        What the keys of its section accept.

    Returns
    -------
    Entry
        With its code where a block was found; everything else is told.
    """
    wants_code = isinstance(keys.get(entry.key), Code)
    has_fence = lines.at < len(lines.lines) and _FENCE.match(lines.lines[lines.at]) is not None
    if not wants_code and not has_fence:
        return entry
    if not wants_code:
        message = f"{quoted(entry.key)} takes no code block"
        lines.problem("E401", (lines.at + 1, _column(lines, lines.at)), message, advice="remove the block", width=3)
    elif entry.value and not entry.value.startswith("```"):
        message = f"{quoted(entry.value)} is not read; the code stands in the lines below"
        place, width = (entry.line, entry.value_column), len(entry.value)
        lines.problem("E401", place, message, name=entry.key, advice="remove it", width=width, is_warning=True)
    if not has_fence and not _find_fence(lines, entry):
        return entry
    return replace(entry, code=_code(lines, entry))


def _column(lines: Lines, index: int) -> int:
    text = lines.lines[index]
    return len(text) - len(text.lstrip()) + 1


def _find_fence(lines: Lines, entry: Entry) -> bool:
    """Report that the fence is not in the next line, and go to where it is, if it is near."""
    if entry.value.startswith("```"):
        place, message = (entry.line, entry.value_column), "the fence stands on the line of the key"
        lines.problem("E401", place, message, name=entry.key, advice=_ADVICE, width=3)
        lines.at -= 1
        return True
    lines.key_problem(entry, "E401", "no ``` in the next line", name=entry.key, advice=_ADVICE)
    look = lines.at
    while look < len(lines.lines) and not lines.content(look).strip():
        look += 1
    if look < len(lines.lines) and _FENCE.match(lines.content(look)):
        lines.at = look
        return True
    _skip_code(lines)
    return False


def _skip_code(lines: Lines) -> None:
    """Go behind the closing fence of code that has no opening one, so that its lines are no further problems."""
    for look in range(lines.at, len(lines.lines)):
        if _FENCE.match(lines.lines[look]):
            lines.at = look + 1
            return
        if ":" in lines.content(look) or lines.content(look).strip() == "}":
            lines.at = look
            return


def _code(lines: Lines, entry: Entry) -> SourceText:
    """Read raw lines from the fence in the next line to the closing one."""
    opening = lines.at
    lines.at += 1
    while lines.at < len(lines.lines) and not _FENCE.match(lines.lines[lines.at]):
        lines.at += 1
    text = "\n".join(lines.lines[opening + 1 : lines.at])
    if lines.at == len(lines.lines):
        place, message = (
            (opening + 1, _column(lines, opening)),
            "the code block is not closed before the end of the file",
        )
        lines.problem("E401", place, message, name=entry.key, advice="write ``` alone behind the code", width=3)
    lines.at += 1
    return SourceText(text=text, path=lines.report.path, line=opening + 2)
