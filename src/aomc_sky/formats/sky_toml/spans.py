"""Where every key of a TOML text stands: the standard library's reader gives values without spans."""

from __future__ import annotations

import re
import tomllib
from bisect import bisect_right
from dataclasses import dataclass

from aomc_sky.errors import Span

_BLANK = re.compile(r"(?:[ \t\n]|#[^\n]*)*")
_PART = re.compile(r"\"(?:[^\"\\]|\\.)*\"|'[^']*'|[A-Za-z0-9_-]+")
_STRING = re.compile(r"\"\"\"(?:[^\\]|\\.)*?\"\"\"+|'''.*?'''+|\"(?:[^\"\\]|\\.)*\"|'[^']*'", re.DOTALL)
_DOT = re.compile(r"[ \t]*\.[ \t]*")
_SCALAR = re.compile(r"[^,#\[\]{}\n]+")


@dataclass(frozen=True, kw_only=True, slots=True)
class KeySpans:
    """`key` is the name, `value` what is assigned; a table's header has its name twice."""

    key: Span
    value: Span


def key_spans(text: str, *, depth: int = 2) -> dict[tuple[str, ...], KeySpans]:
    """Find the span of every key of a TOML text that `tomllib.loads` accepts, lines ended by LF.

    The path of a key is (("perez", "dni")); elements of arrays, and of arrays of tables, have their index from 0 as a
    part of it (("background", "1", "file")); an array of tables has the span of its first header. Paths longer than
    `depth` are not listed: 2 is a section and its keys, 3 the keys of an array of tables.
    """
    walker = _Walker(text, depth)
    walker.walk()
    return walker.spans


class _Walker:
    def __init__(self, text: str, depth: int) -> None:
        self.text = text
        self.depth = depth
        self.lines = text.split("\n")
        self.line_starts = [0, *(match.end() for match in re.finditer("\n", text))]
        self.at = 0
        self.table: tuple[str, ...] = ()
        self.last: dict[tuple[str, ...], int] = {}  # index of the last element of each array of tables
        self.spans: dict[tuple[str, ...], KeySpans] = {}

    def walk(self) -> None:
        self._skip_blank()
        while self.at < len(self.text):
            if self.text[self.at] == "[":
                self._header()
            else:
                self._assignment(self.table)
            self._skip_blank()

    def _skip_blank(self) -> None:
        match = _BLANK.match(self.text, self.at)
        self.at = match.end() if match else self.at

    def _header(self) -> None:
        is_array = self.text[self.at : self.at + 2] == "[["
        while self.text[self.at] in "[ \t":
            self.at += 1
        start = self.at
        self.table = self._resolved(self._key(), is_array=is_array)
        for length in range(1, min(len(self.table), self.depth) + 1):
            self._note(self.table[:length], (start, self.at), (start, self.at))
        while self.text[self.at : self.at + 1] in ("]", " ", "\t"):
            self.at += 1

    def _resolved(self, parts: tuple[str, ...], *, is_array: bool) -> tuple[str, ...]:
        """The path of a table, with the indices of the arrays of tables that it passes."""
        path: tuple[str, ...] = ()
        for number, part in enumerate(parts, start=1):
            path = (*path, part)
            if is_array and number == len(parts):
                self.last[path] = self.last.get(path, -1) + 1
            if path in self.last:
                path = (*path, str(self.last[path]))
        return path

    def _key(self) -> tuple[str, ...]:
        """Read a dotted key; `at` is left behind its last part."""
        parts: list[str] = []
        while match := _PART.match(self.text, self.at):
            part = match.group()
            parts.append(tomllib.loads(f"k = {part}")["k"] if part[0] in "\"'" else part)
            self.at = match.end()
            behind = _DOT.match(self.text, self.at)
            if behind is None:
                break
            self.at = behind.end()
        return tuple(parts)

    def _assignment(self, table: tuple[str, ...] | None) -> None:
        """Read key = value; None as the table where keys need no span."""
        start = self.at
        key = self._key()
        key_end = self.at
        self.at = self.text.index("=", self.at) + 1
        while self.text[self.at] in " \t":
            self.at += 1
        value_start = self.at
        path = None if table is None else (*table, *key)
        self._value(path)
        if path is not None and table is not None:
            end = self.at
            for length in range(len(table) + 1, min(len(path), self.depth) + 1):
                self._note(path[:length], (start, key_end), (value_start, end))

    def _value(self, path: tuple[str, ...] | None) -> None:
        first = self.text[self.at]
        if first in "\"'":
            match = _STRING.match(self.text, self.at)
        elif first in "[{":
            self._nested("]" if first == "[" else "}", path)
            return
        else:
            match = _SCALAR.match(self.text, self.at)
        assert match is not None, "the text is TOML"
        self.at += len(match.group().rstrip(" \t"))

    def _nested(self, closing: str, path: tuple[str, ...] | None) -> None:
        self.at += 1
        index = 0
        while True:
            self._skip_blank()
            if self.text[self.at] == closing:
                self.at += 1
                return
            if self.text[self.at] == ",":
                self.at += 1
            elif closing == "}":
                self._assignment(path)
            else:
                self._element(path, index)
                index += 1

    def _element(self, path: tuple[str, ...] | None, index: int) -> None:
        inside = None if path is None or len(path) >= self.depth else (*path, str(index))
        start = self.at
        self._value(inside)
        if inside is not None:
            self._note(inside, (start, self.at), (start, self.at))

    def _note(self, path: tuple[str, ...], key: tuple[int, int], value: tuple[int, int]) -> None:
        if path not in self.spans:
            self.spans[path] = KeySpans(key=self._span(*key), value=self._span(*value))

    def _span(self, start: int, end: int) -> Span:
        line = bisect_right(self.line_starts, start)
        if line < len(self.line_starts):
            end = min(end, self.line_starts[line] - 1)
        return Span(line, start - self.line_starts[line - 1] + 1, self.lines[line - 1], max(end - start, 1))
