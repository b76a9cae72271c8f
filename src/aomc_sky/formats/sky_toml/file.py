"""sky.toml, beside amc.inp: the weather of the Perez sky, the sun's exact direction, backgrounds, absolute units."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from aomc_sky.errors import Span
from aomc_sky.formats.report import Report
from aomc_sky.formats.sky_toml.keys import (
    BUILDERS,
    KEYS,
    REPEATED,
    AtmosphereSection,
    BackgroundSection,
    PerezSection,
    SkySection,
    SunSection,
)
from aomc_sky.formats.sky_toml.sections import SectionReader
from aomc_sky.formats.sky_toml.spans import KeySpans, key_spans
from aomc_sky.formats.text_file import read_bytes, refuse

MAX_BYTES = 65_536
MAX_LINE_CHARACTERS = 2000
"""A key of very many parts in one line would keep the standard library's reader busy for many seconds."""

_SPANS_DEPTH = 4  # ("background", "0", "animation", "1")
_TOML_POSITION = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)\Z")


@dataclass(frozen=True, kw_only=True, slots=True)
class SkyToml:
    """What sky.toml says; a section that is left out is empty."""

    perez: PerezSection = field(default_factory=PerezSection)
    sun: SunSection = field(default_factory=SunSection)
    sky: SkySection = field(default_factory=SkySection)
    background: tuple[BackgroundSection, ...] = ()
    atmosphere: AtmosphereSection | None = None


def read_sky_toml(
    path: str | Path, *, lenient: bool = False, n_wavebands: int | None = None, allow_paths: Sequence[str] = ()
) -> SkyToml:
    """Read sky.toml; `n_wavebands` values are wanted of arrays with one for each waveband.

    `lenient` is there for symmetry: no other program reads this file, so no error of it is downgraded. The files
    that it names may lie below its own folder and below `allow_paths`.
    """
    text = _text(path)
    report = Report(path=str(path))
    content, spans = _parsed(text, report)
    reader = SectionReader(
        report=report,
        spans=spans,
        folder=Path(path).parent,
        allow_paths=allow_paths,
        n_wavebands=n_wavebands,
    )
    once = [name for name in KEYS if name not in REPEATED]
    single = {name: reader.section(name, content[name]) if name in content else {} for name in once}
    several = {name: reader.repeated(name, content.get(name, [])) for name in REPEATED}
    for name in content:
        if name not in KEYS and not report.is_full:
            reader.refuse_section(name)
    reader.check_sets(content)
    report.problems.sort(key=lambda problem: (problem.line, problem.column))
    report.close()
    sections: dict[str, Any] = {name: BUILDERS[name](values) for name, values in single.items()}
    sections |= {name: tuple(BUILDERS[name](one) for one in values) for name, values in several.items()}
    return SkyToml(**sections)


def _text(path: str | Path) -> str:
    """The text of the file, lines ended by LF; small, for nobody writes a long one by hand."""
    size = os.stat(path).st_size if os.path.isfile(path) else 0
    if size > MAX_BYTES:
        raise refuse(path, f"the file has {size} bytes; at most {MAX_BYTES} are read", code="E701")
    data = read_bytes(path)
    try:
        return data.decode().replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line_start = before.rfind(b"\n") + 1
        column = len(before[line_start:].decode()) + 1
        text = data[line_start:].split(b"\n")[0]
        message, line = "the file is not UTF-8", before.count(b"\n") + 1
        raise refuse(
            path, message, code="E701", line=line, column=column, text=text, advice="save it as UTF-8"
        ) from None


def _refuse_long_lines(text: str, report: Report) -> None:
    for number, line in enumerate(text.split("\n"), start=1):
        if len(line) > MAX_LINE_CHARACTERS:
            message = f"the line is longer than {MAX_LINE_CHARACTERS} characters"
            report.at(Span(number, 1, line), "E701", message, advice="break the line")
    report.close()


def _parsed(text: str, report: Report) -> tuple[dict[str, Any], dict[tuple[str, ...], KeySpans]]:
    _refuse_long_lines(text, report)
    try:
        return tomllib.loads(text), key_spans(text, depth=_SPANS_DEPTH)
    except RecursionError:
        raise refuse(report.path, "arrays or tables are nested too deeply", code="E701") from None
    except ValueError as error:  # a TOMLDecodeError, or a number that Python refuses
        reason = str(error)
    match = _TOML_POSITION.search(reason)
    message = _TOML_POSITION.sub("", reason)[:120]
    lines = text.rstrip("\n").split("\n")
    line, column = (int(match[1]), int(match[2])) if match and match[1] else (len(lines), len(lines[-1]) + 1)
    shown = lines[line - 1] if line <= len(lines) else ""
    message = f"not TOML: {message[:1].lower()}{message[1:]}"
    is_comma = shown[column - 2 : column - 1].isdigit() and shown[column - 1 : column] == ","
    advice = "write a decimal point" if is_comma else "see docs/formats/sky_toml.md"
    report.at(Span(line, column, shown), "E701", message, advice=advice)
    report.close()
    raise AssertionError("a report with an error raises")
