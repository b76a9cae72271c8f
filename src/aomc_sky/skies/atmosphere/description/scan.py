"""The lines of a description file put together: entries, sections and code blocks with their spans; no values."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NoReturn

from aomc_sky.errors import InputFileError, SourceText, Span
from aomc_sky.formats.report import Report, nearest, quoted
from aomc_sky.skies.atmosphere.description.keys import (
    DIRECTIVES,
    SCATTERER_DIRECTIVE,
    SECTION_KEYS,
    TOP_KEYS,
    Code,
    Rule,
)

_FENCE = re.compile(r"\s*```\s*\Z")
_ADVICE = "write ``` alone in the line below the key"
_SECTION = re.compile(r'(scatterer|absorber) "([^"]+)"\Z')
_SECTION_WORD = re.compile(r"(scatterer|absorber)\b")
_OPENING = "write { alone, at the start of the line below"
_CLOSING = "write } alone, at the start of the line"


@dataclass(frozen=True, kw_only=True, slots=True)
class Entry:
    """A key and its value; a directive has no value."""

    key: str  #: In lower case, blanks simplified
    value: str  #: Trimmed
    key_span: Span
    value_span: Span
    code: SourceText | None = None  #: The code block below, where there is one


@dataclass(frozen=True, kw_only=True, slots=True)
class Section:
    """A scatterer or an absorber."""

    kind: str  #: "scatterer" or "absorber"
    head: Entry  #: Its first line
    name: str  #: In lower case; empty where it is missing, and reported
    entries: tuple[Entry, ...]  #: What stands inside


@dataclass(kw_only=True, slots=True)
class Lines:
    """A file that is read line by line."""

    lines: list[str]  #: The file, without line ends
    report: Report
    at: int = 0  #: The line that is read next. [0-based]
    #: Keys that lines without a place in the grammar were probably meant to have
    spoilt: set[str] = field(default_factory=set)

    def next(self) -> str | None:
        """Read the next line that is not blank, up to its comment, or None at the end of the file."""
        while self.at < len(self.lines):
            text = self.lines[self.at].split("#", 1)[0]
            self.at += 1
            if text.strip():
                return text
        return None

    def span(self, line: int, column: int, width: int = 1) -> Span:
        """A piece of a line. [both 1-based]"""
        return Span(line, column, self.lines[line - 1], width)

    def fence(self, index: int) -> Span:
        """The three letters of a fence, blanks aside. [0-based]"""
        return self.span(index + 1, _indent(self.lines[index]) + 1, 3)

    def entry(self, text: str, key: str, value: str, value_column: int) -> Entry:
        """The entry of the line that was read last."""
        return Entry(
            key=key,
            value=value,
            key_span=self.span(self.at, _indent(text) + 1, len(key)),
            value_span=self.span(self.at, value_column, max(len(value), 1)),
        )

    def read(self, text: str, keys: Mapping[str, Rule], directives: tuple[str, ...], word: str) -> Entry | None:
        """The entry of the line that was read last, with the code block below it; or report what is no entry.

        `word` is the line as a directive is compared with it.
        """
        if word in directives:
            return self.entry(text, text.strip().lower(), "", _indent(text) + 1)
        parts = text.split(":")
        if len(parts) == 2:
            key, value = " ".join(parts[0].split()).lower(), parts[1].strip()
            column = len(parts[0]) + 2 + (_indent(parts[1]) if value else 0)
            return _with_code(self, self.entry(text, key, value, column), keys.get(key))
        if len(parts) > 2:
            self.spoilt.add(" ".join(parts[0].split()).lower())
            message = f"{len(parts) - 1} colons in one line; a line is a key, a colon and a value"
            second = self.span(self.at, len(parts[0]) + len(parts[1]) + 2)
            self.report.at(second, "E401", message, advice="keep one colon; a path cannot contain one")
            return None
        shown = text.strip()
        if shown in ("{", "}"):
            message, advice = f"{'an opening' if shown == '{' else 'a closing'} brace without a section", "remove it"
        else:
            best = nearest(shown, (*keys, *directives))
            self.spoilt.add(best)
            message = f"{quoted(shown)} is not a key, a colon and a value"
            advice = f"write '{best}' alone" if best in directives else f"write a colon, such as '{best}: ...'"
        self.report.at(self.span(self.at, _indent(text) + 1, len(shown)), "E401", message, advice=advice)
        return None


def _indent(text: str) -> int:
    return len(text) - len(text.lstrip())


def scan(lines: Lines) -> list[Entry | Section]:
    """Entries and sections of a whole file; its report gets every line that has no place in the grammar."""
    items: list[Entry | Section] = []
    while (text := lines.next()) is not None and not lines.report.is_full:
        if _SECTION_WORD.match(text.strip().lower()):
            items.append(_section(lines, text))
        elif (entry := lines.read(text, TOP_KEYS, DIRECTIVES, word=text)) is not None:
            items.append(entry)
    return items


def _section(lines: Lines, text: str) -> Section:
    """Read a section, from the line of its key on, which was read last."""
    key, colon, value = text.partition(":")
    head = lines.entry(text, " ".join(key.split()).lower(), value.strip(), len(text) - len(value.lstrip()) + 1)
    match = _SECTION.match(head.key)
    kind = "scatterer" if head.key.startswith("scatterer") else "absorber"
    advice = f'write {kind.capitalize()} "name":'
    if ":" in value:
        span = head.value_span.part(0, len(value))
        lines.report.at(span, "E401", "more than one colon in the key of a section", advice="keep one")
    if not colon:
        lines.report.at(head.key_span, "E401", "the key of a section without a colon", advice=advice)
    elif match is None:
        lines.report.at(head.key_span, "E401", f"{quoted(head.key)} has no name in quotes", advice=advice)
    _open(lines, head)
    return Section(kind=kind, head=head, name=match[2] if match else "", entries=_body(lines, head, kind))


def _open(lines: Lines, head: Entry) -> None:
    """Read the opening brace; one that is near is reported, without one the reading ends."""
    if head.value.startswith("{"):
        span = head.value_span.part(0, 1)
        lines.report.at(span, "E401", "an opening brace on the line of the key", advice=_OPENING)
        return
    if head.value:
        message = f"{quoted(head.value)} after the key of a section is not read"
        lines.report.at(head.value_span, "E401", message, advice="remove it", is_warning=True)
    text = lines.next()
    if text is None or text.strip() != "{":
        _end(lines, head.key_span, "a section without an opening brace", advice=_OPENING)
    if text != "{":
        message = "a blank or a comment next to the opening brace"
        advice = "write { alone, at the start of the line"
        lines.report.at(lines.span(lines.at, text.index("{") + 1), "E401", message, advice=advice)


def _end(lines: Lines, span: Span, message: str, *, advice: str, name: str = "") -> NoReturn:
    """Report a fault that hides the structure of the rest, and raise all errors so far."""
    lines.report.at(span, "E401", message, name=name, advice=advice)
    raise InputFileError([problem for problem in lines.report.problems if problem.is_error])


def _body(lines: Lines, head: Entry, kind: str) -> tuple[Entry, ...]:
    """Read up to the closing brace; if another section or the end of the file comes first, the reading ends."""
    directives = (SCATTERER_DIRECTIVE,) if kind == "scatterer" else ()
    entries: list[Entry] = []
    while not lines.report.is_full:
        text = lines.next()
        if text is None or _SECTION.match(text.partition(":")[0].strip().lower()):
            message = "the section has no closing brace"
            _end(lines, head.key_span, message, advice="write } alone in the line after it")
        if text.strip() == "}":
            # the tool wants the brace of an absorber alone in its line, and that of a scatterer first in it
            if not (text == "}" or (kind == "scatterer" and text.startswith("}"))):
                brace, message = text.index("}") + 1, "a blank or a comment next to the closing brace"
                lines.report.at(lines.span(lines.at, brace), "E401", message, advice=_CLOSING)
            break
        entry = lines.read(text, SECTION_KEYS[kind], directives, word=text.strip().lower())
        if entry is not None:
            entries.append(entry)
    return tuple(entries)


def names_file(value: str) -> bool:
    """Whether a value is ``file PATH``."""
    return value == "file" or value.startswith("file ")


def _with_code(lines: Lines, entry: Entry, rule: Rule | None) -> Entry:
    """Add the code block below an entry, if its key wants one or if there is one. Without a fence the reading ends."""
    wants_code = isinstance(rule, Code) and not (rule.or_table and names_file(entry.value))
    has_fence = lines.at < len(lines.lines) and _FENCE.match(lines.lines[lines.at]) is not None
    if not wants_code and not has_fence:
        return entry
    if not wants_code:
        message = f"{quoted(entry.key)} takes no code block"
        if isinstance(rule, Code):
            message = f"{quoted(entry.key)} names a file and has a code block"
        lines.report.at(lines.fence(lines.at), "E401", message, advice="remove the block")
    elif entry.value and not entry.value.startswith("```"):
        message = f"{quoted(entry.value)} is not read; the code is in the lines below"
        lines.report.at(entry.value_span, "E401", message, name=entry.key, advice="remove it", is_warning=True)
    if not has_fence:
        _end(lines, entry.key_span, "no ``` in the next line", advice=_ADVICE, name=entry.key)
    return replace(entry, code=_code(lines, entry))


def _code(lines: Lines, entry: Entry) -> SourceText:
    """Read raw lines from the fence in the next line to the closing one."""
    opening = lines.at
    lines.at += 1
    while lines.at < len(lines.lines) and not _FENCE.match(lines.lines[lines.at]):
        lines.at += 1
    text = "\n".join(lines.lines[opening + 1 : lines.at])
    if lines.at == len(lines.lines):
        message = "the code block is not closed before the end of the file"
        _end(lines, lines.fence(opening), message, advice="write ``` alone after the code", name=entry.key)
    lines.at += 1
    return SourceText(text=text, path=lines.report.path, line=opening + 2)
