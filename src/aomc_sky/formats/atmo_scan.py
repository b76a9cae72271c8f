"""The lines of a description file put together: entries, sections and code blocks, each with its place; no values."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from aomc_sky.formats.atmo_keys import DIRECTIVES, SCATTERER_DIRECTIVE, SECTION_KEYS, TOP_KEYS, Code
from aomc_sky.formats.bad_value import BadValueError, quoted
from aomc_sky.formats.sky_keys import nearest
from aomc_sky.formats.text_file import Report
from aomc_sky.source_text import SourceText

_SECTION = re.compile(r'(scatterer|absorber) "([^"]+)"\Z')
_SECTION_WORD = re.compile(r"(scatterer|absorber)\b")
_FENCE = re.compile(r"\s*```\s*\Z")


@dataclass(frozen=True, kw_only=True, slots=True)
class Entry:
    """A key and its value; a directive has no value.

    Parameters
    ----------
    key : str
        In lower case, blanks simplified.
    value : str
        Trimmed.
    line, column, value_column : int
        Place of key and value. [1-based]
    code : SourceText or None
        The code block below, where there is one.
    """

    key: str
    value: str
    line: int
    column: int
    value_column: int
    code: SourceText | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class Section:
    """A scatterer or an absorber; `is_whole` is False where its end was not found."""

    kind: str
    name: str
    line: int
    column: int
    width: int
    entries: list[Entry] = field(default_factory=list)
    is_whole: bool = True


class Scanner:
    """Puts the lines of a file together.

    Parameters
    ----------
    lines : list of str
        The file, without line ends.
    report : Report
        Gets every problem.
    """

    def __init__(self, lines: list[str], report: Report) -> None:
        self.lines = lines
        self.report = report
        self.at = 0  # index of the line to be read next

    def items(self) -> list[Entry | Section]:
        """Everything in the file, in its order."""
        found: list[Entry | Section] = []
        while (text := self._next()) is not None and not self.report.is_full:
            if text in DIRECTIVES:
                found.append(self._directive(text))
            elif (parts := self._parts(text, TOP_KEYS, DIRECTIVES)) is not None:
                item = self._section(parts) if _SECTION_WORD.match(parts.key) else self._block(parts, TOP_KEYS)
                if item is not None:
                    found.append(item)
        return found

    def problem(
        self,
        code: str,
        line: int,
        column: int,
        message: str,
        *,
        name: str = "",
        advice: str = "",
        width: int = 1,
        is_warning: bool = False,
    ) -> None:
        """Note a problem at a place of the file."""
        text = self.lines[line - 1]
        self.report.add(
            code,
            message,
            line=line,
            column=column,
            name=name,
            advice=advice,
            text=text,
            width=width,
            is_warning=is_warning,
        )

    def value_problem(self, entry: Entry, problem: BadValueError, *, is_warning: bool = False) -> None:
        """Note what is wrong with the value of an entry."""
        self.problem(
            problem.code,
            entry.line,
            entry.value_column + problem.offset,
            problem.message,
            name=entry.key,
            advice=problem.advice,
            width=problem.width or max(len(entry.value), 1),
            is_warning=is_warning,
        )

    def _content(self, index: int) -> str:
        return self.lines[index].split("#", 1)[0]

    def _next(self) -> str | None:
        """The next line that is not blank, without its comment; None at the end of the file."""
        while self.at < len(self.lines):
            text = self._content(self.at)
            self.at += 1
            if text.strip():
                return text
        return None

    def _directive(self, text: str) -> Entry:
        column = len(text) - len(text.lstrip()) + 1
        return Entry(key=text.strip(), value="", line=self.at, column=column, value_column=column)

    def _parts(self, text: str, keys: dict[str, object], directives: tuple[str, ...]) -> Entry | None:
        """Split the line that was read last at its colon."""
        column = len(text) - len(text.lstrip()) + 1
        parts = text.split(":")
        if len(parts) == 2:
            key, value = " ".join(parts[0].split()).lower(), parts[1].strip()
            value_column = len(parts[0]) + 2 + (len(parts[1]) - len(parts[1].lstrip()) if value else 0)
            return Entry(key=key, value=value, line=self.at, column=column, value_column=value_column)
        shown = text.strip()
        if len(parts) > 2:
            message = f"{len(parts) - 1} colons in one line; a line is a key, a colon and a value"
            advice, column = "keep one colon; a path may hold none", len(parts[0]) + len(parts[1]) + 2
            self.problem("E401", self.at, column, message, advice=advice)
            return None
        stray = {"{": "an opening brace without a section", "}": "a closing brace without a section"}.get(shown)
        best = nearest(shown, (*keys, *directives))
        advice = (
            "remove it"
            if stray
            else (f"write '{best}' alone" if best in directives else f"write a colon, such as '{best}: ...'")
        )
        message = stray or f"{quoted(shown)} is not a key, a colon and a value"
        self.problem("E401", self.at, column, message, advice=advice, width=len(shown))
        return None

    def _section(self, head: Entry) -> Section | None:
        """Read a section from the line behind its key on."""
        match = _SECTION.match(head.key)
        if match is None:
            kind = head.key.split()[0].strip('"')
            message = f"{quoted(head.key)} has no name in quotes"
            self.problem(
                "E401",
                head.line,
                head.column,
                message,
                advice=f'write {kind.capitalize()} "name":',
                width=len(head.key),
            )
            match = _SECTION_WORD.match(head.key)
            assert match is not None, "the caller looked"
        kind, name = match[1], (match[2] if match.re is _SECTION else "")
        section = Section(kind=kind, name=name, line=head.line, column=head.column, width=len(head.key))
        return self._body(section, opened=self._open(head))

    def _open(self, head: Entry) -> bool:
        """Read the opening brace; report one that stands elsewhere."""
        advice = "write { alone, at the start of the line below"
        if head.value.startswith("{"):
            self.problem("E401", head.line, head.value_column, "an opening brace on the line of the key", advice=advice)
            return True
        if head.value:
            message = f"{quoted(head.value)} behind the key of a section means nothing"
            self.problem(
                "E401",
                head.line,
                head.value_column,
                message,
                advice="remove it",
                width=len(head.value),
                is_warning=True,
            )
        start = self.at
        text = self._next()
        if text == "{":
            return True
        if text is not None and text.strip() == "{":
            place = text.index("{") + 1
            self.problem(
                "E401",
                self.at,
                place,
                "a blank beside the opening brace",
                advice="write { alone, at the start of the line",
            )
            return True
        self.at = start
        self.problem(
            "E401", head.line, head.column, "a section without an opening brace", advice=advice, width=len(head.key)
        )
        return text is not None

    def _body(self, section: Section, *, opened: bool) -> Section:
        keys = SECTION_KEYS[section.kind]
        directives = (SCATTERER_DIRECTIVE,) if section.kind == "scatterer" else ()
        while opened and not self.report.is_full:
            start = self.at
            text = self._next()
            if text is None:
                break
            if text.strip() == "}":
                self._close(section, text)
                return section
            if text.strip().lower() in directives:
                section.entries.append(self._directive(text.lower()))
            elif (parts := self._parts(text, keys, directives)) is not None:
                if _SECTION.match(parts.key):
                    self.at = start
                    break
                section.entries.append(self._block(parts, keys))
        message = f"the section of {quoted(section.name)} has no closing brace"
        self.problem(
            "E401",
            section.line,
            section.column,
            message,
            advice="write } alone in the line behind it",
            width=section.width,
        )
        return Section(
            kind=section.kind,
            name=section.name,
            line=section.line,
            column=section.column,
            width=section.width,
            entries=section.entries,
            is_whole=False,
        )

    def _close(self, section: Section, text: str) -> None:
        """The tool wants the brace of an absorber alone in its line, that of a scatterer first in it."""
        if text == "}" or (section.kind == "scatterer" and text.startswith("}")):
            return
        what = "a blank or a comment beside the closing brace" if text.startswith("}") else "an indented closing brace"
        self.problem("E401", self.at, text.index("}") + 1, what, advice="write } alone, at the start of the line")

    def _block(self, entry: Entry, keys: dict[str, object]) -> Entry:
        """Take the code block below an entry, if its key wants one or if there is one."""
        wants_code = isinstance(keys.get(entry.key), Code)
        has_fence = self.at < len(self.lines) and _FENCE.match(self.lines[self.at]) is not None
        if not wants_code and not has_fence:
            return entry
        if wants_code and entry.value and not entry.value.startswith("```"):
            message = f"{quoted(entry.value)} is not read; the code stands in the lines below"
            self.problem(
                "E401",
                entry.line,
                entry.value_column,
                message,
                name=entry.key,
                advice="remove it",
                width=len(entry.value),
                is_warning=True,
            )
        if not wants_code:
            self.problem(
                "E401", self.at + 1, 1, f"{quoted(entry.key)} takes no code block", advice="remove the block", width=3
            )
        if not has_fence and not self._find_fence(entry):
            return entry
        return self._code(entry)

    def _find_fence(self, entry: Entry) -> bool:
        """Report that the fence is not in the next line, and go to where it is, if it is near."""
        advice = "write ``` alone in the line below the key"
        if entry.value.startswith("```"):
            self.problem(
                "E401",
                entry.line,
                entry.value_column,
                "the fence stands on the line of the key",
                name=entry.key,
                advice=advice,
                width=3,
            )
            self.at -= 1
            return True
        self.problem(
            "E401",
            entry.line,
            entry.column,
            "no ``` in the next line",
            name=entry.key,
            advice=advice,
            width=len(entry.key),
        )
        look = self.at
        while look < len(self.lines) and not self._content(look).strip():
            look += 1
        if look < len(self.lines) and _FENCE.match(self._content(look)):
            self.at = look
            return True
        return False

    def _code(self, entry: Entry) -> Entry:
        """Read raw lines from the fence at the next line to the closing one."""
        opening = self.at
        self.at += 1
        while self.at < len(self.lines) and not _FENCE.match(self.lines[self.at]):
            self.at += 1
        text = "\n".join(self.lines[opening + 1 : self.at])
        if self.at == len(self.lines):
            fence = self.lines[opening]
            column = len(fence) - len(fence.lstrip()) + 1
            message = "the code block is not closed before the end of the file"
            self.problem(
                "E401", opening + 1, column, message, name=entry.key, advice="write ``` alone behind the code", width=3
            )
        self.at += 1
        code = SourceText(text=text, path=self.report.path, line=opening + 2)
        return Entry(
            key=entry.key,
            value=entry.value,
            line=entry.line,
            column=entry.column,
            value_column=entry.value_column,
            code=code,
        )
