"""Pieces of a text file that know where they stand, so that errors can name it: a span of a line, and whole lines."""

from __future__ import annotations

from dataclasses import dataclass

from aomc_sky.errors import Problem


@dataclass(frozen=True, slots=True)
class Span:
    """Some characters of one line of a file; width 1 where nothing stands."""

    line: int  #: [1-based]
    column: int  #: Of the first character. [1-based]
    text: str  #: The whole line
    width: int = 1  #: Characters. [1 or more]

    def part(self, offset: int, width: int) -> Span:
        """The characters from `offset` on."""
        return Span(self.line, self.column + offset, self.text, width)


@dataclass(frozen=True, kw_only=True, slots=True)
class SourceText:
    """Some whole lines of a text file, as they stand there."""

    text: str  #: The lines, joined by a line feed
    path: str  #: The file as the user named it
    line: int  #: Line of the file that the first line of `text` is. [1-based]

    def problem(self, offset: int, code: str, field: str, message: str, advice: str = "", width: int = 1) -> Problem:
        """Return a problem that stands at a character of the text; the end of the text is allowed."""
        start = self.text.rfind("\n", 0, offset) + 1
        end = self.text.find("\n", offset)
        shown = self.text[start:] if end < 0 else self.text[start:end]
        return Problem(
            path=self.path,
            line=self.line + self.text.count("\n", 0, offset),
            column=offset - start + 1,
            code=code,
            field=field,
            message=message,
            advice=advice,
            text=shown,
            width=max(1, min(width, len(shown) - (offset - start))),
        )
