"""The lines of a description file put together: entries and sections with their places; no values."""

from __future__ import annotations

import re

from aomc_sky.formats.atmo.code import with_code
from aomc_sky.formats.atmo.keys import DIRECTIVES, SCATTERER_DIRECTIVE, SECTION_KEYS, TOP_KEYS
from aomc_sky.formats.atmo.lines import Entry, Lines, Section
from aomc_sky.formats.bad_value import quoted

_SECTION = re.compile(r'(scatterer|absorber) "([^"]+)"\Z')
_SECTION_WORD = re.compile(r"(scatterer|absorber)\b")
_OPENING = "write { alone, at the start of the line below"
_CLOSING = "write } alone, at the start of the line"


def scan(lines: Lines) -> list[Entry | Section]:
    """Put the lines of a whole file together.

    Parameters
    ----------
    lines : Lines
        The file; its report gets every line that has no place in the grammar.

    Returns
    -------
    list of Entry and Section
        In the order of the file.
    """
    found: list[Entry | Section] = []
    while (text := lines.next()) is not None and not lines.report.is_full:
        if text in DIRECTIVES:
            found.append(lines.directive(text))
        elif _SECTION_WORD.match(text.strip().lower()):
            found.append(_section(lines, text))
        elif (entry := lines.key_and_value(text, TOP_KEYS, DIRECTIVES)) is not None:
            found.append(with_code(lines, entry, TOP_KEYS))
    return found


def _section(lines: Lines, text: str) -> Section:
    """Read a section, from the line of its key on, which was read last."""
    head = _head(lines, text)
    match = _SECTION.match(head.key)
    kind = "scatterer" if head.key.startswith("scatterer") else "absorber"
    if match is None and ":" in text:
        message = f"{quoted(head.key)} has no name in quotes"
        lines.key_problem(head, "E401", message, advice=f'write {kind.capitalize()} "name":')
    n_errors = lines.report.n_errors
    entries: list[Entry] = []
    if _open(lines, head):
        is_closed = _body(lines, kind, entries)
        if not is_closed:
            message = "the section has no closing brace"
            lines.key_problem(head, "E401", message, advice="write } alone in the line behind it")
    is_whole = lines.report.n_errors == n_errors
    name = match[2] if match else ""
    return Section(kind=kind, head=head, name=name, entries=tuple(entries), is_whole=is_whole)


def _head(lines: Lines, text: str) -> Entry:
    """Key and rest of the first line of a section, with a colon or not."""
    key, colon, value = text.partition(":")
    column = len(text) - len(text.lstrip()) + 1
    head = Entry(
        key=" ".join(key.split()).lower(),
        value=value.strip(),
        line=lines.at,
        column=column,
        value_column=len(text) - len(value.lstrip()) + 1,
    )
    if ":" in value:
        place = (head.line, head.value_column)
        lines.problem("E401", place, "more than one colon in the key of a section", advice="keep one", width=len(value))
    if not colon:
        kind = head.key.split()[0].capitalize()
        lines.key_problem(head, "E401", "the key of a section without a colon", advice=f'write {kind} "name":')
    return head


def _open(lines: Lines, head: Entry) -> bool:
    """Read the opening brace; whether there is one, in its place or told to be elsewhere."""
    place = (head.line, head.value_column)
    if head.value.startswith("{"):
        lines.problem("E401", place, "an opening brace on the line of the key", advice=_OPENING)
        return True
    if head.value:
        message, width = f"{quoted(head.value)} behind the key of a section is not read", len(head.value)
        lines.problem("E401", place, message, advice="remove it", width=width, is_warning=True)
    start = lines.at
    text = lines.next()
    if text == "{":
        return True
    if text is not None and text.strip() == "{":
        message = "a blank or a comment beside the opening brace"
        advice = "write { alone, at the start of the line"
        lines.problem("E401", (lines.at, text.index("{") + 1), message, advice=advice)
        return True
    lines.at = start
    lines.key_problem(head, "E401", "a section without an opening brace", advice=_OPENING)
    return text is not None and not _SECTION_WORD.match(text.strip().lower())


def _body(lines: Lines, kind: str, entries: list[Entry]) -> bool:
    """Read up to the closing brace; False if another section or the end of the file comes first."""
    keys = SECTION_KEYS[kind]
    directives = (SCATTERER_DIRECTIVE,) if kind == "scatterer" else ()
    while not lines.report.is_full:
        start = lines.at
        text = lines.next()
        if text is None or _SECTION.match(text.partition(":")[0].strip().lower()):
            lines.at = start
            return False
        if text.strip() == "}":
            _check_close(lines, kind, text)
            return True
        if text.strip().lower() in directives:
            entries.append(lines.directive(text))
        elif (entry := lines.key_and_value(text, keys, directives)) is not None:
            entries.append(with_code(lines, entry, keys))
    return True


def _check_close(lines: Lines, kind: str, text: str) -> None:
    """The tool wants the brace of an absorber alone in its line, and that of a scatterer first in it."""
    if text == "}" or (kind == "scatterer" and text.startswith("}")):
        return
    message = "a blank or a comment beside the closing brace"
    lines.problem("E401", (lines.at, text.index("}") + 1), message, advice=_CLOSING)
