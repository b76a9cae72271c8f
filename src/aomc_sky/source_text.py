"""A piece of text taken out of a file, which keeps its place so that later errors can name it."""

from __future__ import annotations

from dataclasses import dataclass

from aomc_sky.errors import Problem


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
