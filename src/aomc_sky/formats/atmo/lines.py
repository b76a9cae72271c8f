"""The lines of a description file one by one, what they are put together to, and problems at their places."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from aomc_sky.formats.bad_value import BadValueError, quoted
from aomc_sky.formats.sky_toml.keys import nearest
from aomc_sky.formats.text_file import Report
from aomc_sky.source_text import SourceText


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
    """A scatterer or an absorber.

    Parameters
    ----------
    kind : {"scatterer", "absorber"}
        What it is.
    head : Entry
        Its first line.
    name : str
        In lower case; empty where it is missing, and told.
    entries : tuple of Entry
        What stands inside.
    is_whole : bool
        False where its braces or fences are wrong, so that keys may be missing by that alone.
    """

    kind: str
    head: Entry
    name: str
    entries: tuple[Entry, ...]
    is_whole: bool


@dataclass(kw_only=True, slots=True)
class Lines:
    """A file that is read line by line.

    Parameters
    ----------
    lines : list of str
        The file, without line ends.
    report : Report
        Gets every problem.
    at : int
        The line that is read next. [0-based]
    spoilt : set of str
        Keys that lines without a place in the grammar were probably meant to have.
    """

    lines: list[str]
    report: Report
    at: int = 0
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
