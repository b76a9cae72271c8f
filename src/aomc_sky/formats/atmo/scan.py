"""The lines of a description file put together: entries, sections and code blocks with their spans; no values."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from aomc_sky.formats.atmo.keys import DIRECTIVES, SCATTERER_DIRECTIVE, SECTION_KEYS, TOP_KEYS, Code, Rule
from aomc_sky.formats.report import BadValueError, Report, nearest, quoted
from aomc_sky.source_text import SourceText


@dataclass(frozen=True, kw_only=True, slots=True)
class Entry:
    """A key and its value; a directive has no value."""

    key: str  #: In lower case, blanks simplified
    value: str  #: Trimmed
    #: Place of key and value. [1-based]
    line: int
    column: int
    value_column: int
    code: SourceText | None = None  #: The code block below, where there is one


@dataclass(frozen=True, kw_only=True, slots=True)
class Section:
    """A scatterer or an absorber."""

    kind: str  #: "scatterer" or "absorber"
    head: Entry  #: Its first line
    name: str  #: In lower case; empty where it is missing, and reported
    entries: tuple[Entry, ...]  #: What stands inside
    is_whole: bool  #: False where its braces or fences are wrong, so that keys may be missing by that alone


@dataclass(kw_only=True, slots=True)
class Lines:
    """A file that is read line by line."""

    lines: list[str]  #: The file, without line ends
    report: Report
    at: int = 0  #: The line that is read next. [0-based]
    #: Keys that lines without a place in the grammar were probably meant to have
    spoilt: set[str] = field(default_factory=set)

    def content(self, index: int) -> str:
        """A line up to its comment."""
        return self.lines[index].split("#", 1)[0]

    def next(self) -> str | None:
        """Read the next line that is not blank, up to its comment; None at the end of the file."""
        while self.at < len(self.lines):
            text = self.content(self.at)
            self.at += 1
            if text.strip():
                return text
        return None

    def problem(
        self,
        code: str,
        place: tuple[int, int],
        message: str,
        *,
        name: str = "",
        advice: str = "",
        width: int = 1,
        is_warning: bool = False,
    ) -> None:
        """Note a problem at a line and a column."""
        line, column = place
        self.report.add(
            code,
            message,
            line=line,
            column=column,
            name=name,
            advice=advice,
            text=self.lines[line - 1],
            width=width,
            is_warning=is_warning,
        )

    def key_problem(
        self, entry: Entry, code: str, message: str, *, advice: str = "", name: str = "", is_warning: bool = False
    ) -> None:
        """Note a problem at a key."""
        place = (entry.line, entry.column)
        width = len(entry.key)
        self.problem(code, place, message, name=name, advice=advice, width=width, is_warning=is_warning)

    def value_problem(self, entry: Entry, problem: BadValueError, *, is_warning: bool = False) -> None:
        """Note what is wrong with the value of an entry."""
        place = (entry.line, entry.value_column + problem.offset)
        width = problem.width or max(len(entry.value), 1)
        name, advice = entry.key, problem.advice
        self.problem(problem.code, place, problem.message, name=name, advice=advice, width=width, is_warning=is_warning)

    def directive(self, text: str) -> Entry:
        """The entry of a line without a colon that was read last."""
        column = len(text) - len(text.lstrip()) + 1
        return Entry(key=text.strip().lower(), value="", line=self.at, column=column, value_column=column)

    def key_and_value(self, text: str, keys: Iterable[str], directives: tuple[str, ...]) -> Entry | None:
        """Split the line that was read last at its colon; None where it has not exactly one, and told."""
        column = len(text) - len(text.lstrip()) + 1
        parts = text.split(":")
        if len(parts) == 2:
            key, value = " ".join(parts[0].split()).lower(), parts[1].strip()
            value_column = len(parts[0]) + 2 + (len(parts[1]) - len(parts[1].lstrip()) if value else 0)
            return Entry(key=key, value=value, line=self.at, column=column, value_column=value_column)
        if len(parts) > 2:
            self.spoilt.add(" ".join(parts[0].split()).lower())
            message = f"{len(parts) - 1} colons in one line; a line is a key, a colon and a value"
            place = (self.at, len(parts[0]) + len(parts[1]) + 2)
            self.problem("E401", place, message, advice="keep one colon; a path may hold none")
            return None
        shown = text.strip()
        if shown in ("{", "}"):
            message, advice = f"{'an opening' if shown == '{' else 'a closing'} brace without a section", "remove it"
        else:
            best = nearest(shown, (*keys, *directives))
            self.spoilt.add(best)
            message = f"{quoted(shown)} is not a key, a colon and a value"
            advice = f"write '{best}' alone" if best in directives else f"write a colon, such as '{best}: ...'"
        self.problem("E401", (self.at, column), message, advice=advice, width=len(shown))
        return None


_FENCE = re.compile(r"\s*```\s*\Z")
_ADVICE = "write ``` alone in the line below the key"


def with_code(lines: Lines, entry: Entry, keys: Mapping[str, Rule]) -> Entry:
    """Add the code block below an entry, if its key wants one or if there is one; everything else is reported."""
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


_SECTION = re.compile(r'(scatterer|absorber) "([^"]+)"\Z')
_SECTION_WORD = re.compile(r"(scatterer|absorber)\b")
_OPENING = "write { alone, at the start of the line below"
_CLOSING = "write } alone, at the start of the line"


def scan(lines: Lines) -> list[Entry | Section]:
    """Entries and sections of a whole file; its report gets every line that has no place in the grammar."""
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
