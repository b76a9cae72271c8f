"""Where keys of a TOML text stand: the standard library's reader gives values without lines."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass

from aomc_sky.errors import Span

_PART = r"""(?:"(?:[^"\\\n]|\\.)*"|'[^'\n]*'|[A-Za-z0-9_-]+)"""
_KEY = rf"{_PART}(?:[ \t]*\.[ \t]*{_PART})*"
#: A header, or a key with what is assigned in its line, without a comment
_LINE = re.compile(
    rf"""^[ \t]*(?:(?P<brackets>\[\[?)[ \t]*(?P<table>{_KEY})[ \t]*\]"""
    rf"""|(?P<key>{_KEY})[ \t]*=[ \t]*(?P<value>(?:"(?:[^"\\\n]|\\.)*"|'[^'\n]*'|[^#\n])*))""",
    re.MULTILINE,
)


@dataclass(frozen=True, kw_only=True, slots=True)
class KeySpans:
    """`key` is the name, `value` what is assigned in its line; a table's header has its name twice."""

    key: Span
    value: Span


class SpansOfKeys(dict[tuple[str, ...], KeySpans]):
    """Spans by the path of a key: what has no line of its own stands where the key does that it is part of."""

    def __missing__(self, path: tuple[str, ...]) -> KeySpans:
        nowhere = Span(0, 0, "")
        return self[path[:-1]] if path else KeySpans(key=nowhere, value=nowhere)


def key_spans(text: str) -> SpansOfKeys:
    """Find the keys of a TOML text that `tomllib.loads` accepts, lines ended by LF.

    The path of a key is (("perez", "dni")); arrays of tables have their index from 0 as a part of it (("background",
    "1", "file")). Keys inside braces have no span of their own.
    """
    spans, table, last = SpansOfKeys(), (), {}  # type: tuple[SpansOfKeys, tuple[str, ...], dict[tuple[str, ...], int]]
    for match in _LINE.finditer(text):
        parts = match["key"] or match["table"]
        names = tuple(tomllib.loads(f"k = {one}")["k"] if one[0] in "\"'" else one for one in re.findall(_PART, parts))
        if match["key"]:
            path = (*table, *names)
            first, noted = len(table) + 1, KeySpans(key=_span(text, match, "key"), value=_span(text, match, "value"))
        else:
            path = ()
            for number, name in enumerate(names, start=1):
                path = (*path, name)
                if match["brackets"] == "[[" and number == len(names):
                    last[path] = last.get(path, -1) + 1
                path = (*path, str(last[path])) if path in last else path
            table, first = path, 1
            noted = KeySpans(key=_span(text, match, "table"), value=_span(text, match, "table"))
        for length in range(first, len(path) + 1):
            spans.setdefault(path[:length], noted)
    return spans


def _span(text: str, match: re.Match[str], group: str) -> Span:
    start, width = match.start(group), len(match[group].rstrip())
    line_start = text.rfind("\n", 0, start) + 1
    line = text[line_start:].split("\n", 1)[0]
    return Span(text.count("\n", 0, start) + 1, start - line_start + 1, line, max(width, 1))
