"""sky.toml: the weather of the Perez sky and the exact place of the sun, beside amc.inp."""

from __future__ import annotations

import os
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from aomc_sky.formats.sky_keys import (
    KEYS,
    PerezSection,
    SunSection,
    nearest,
    perez_section,
    set_problem,
    shown_value,
    value_problem,
)
from aomc_sky.formats.text_file import Report, read_bytes, refuse
from aomc_sky.formats.toml_places import KeyPlaces, Place, key_places

MAX_BYTES = 65_536
MAX_LINE_CHARACTERS = 2000
"""A key of very many parts in one line would keep the standard library's reader busy for many seconds."""

_LATER = ("sky", "background", "atmosphere")
_TOML_PLACE = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)\Z")


@dataclass(frozen=True, kw_only=True, slots=True)
class SkyToml:
    """What sky.toml says; a section that is left out is empty."""

    perez: PerezSection = field(default_factory=PerezSection)
    sun: SunSection = field(default_factory=SunSection)


def read_sky_toml(path: str | Path, *, lenient: bool = False) -> SkyToml:
    """Read sky.toml.

    Parameters
    ----------
    path : str or Path
        The file.
    lenient : bool
        Accepted for symmetry: no other program reads this file, so no error of it is downgraded.

    Returns
    -------
    SkyToml

    Raises
    ------
    InputFileError
        Every problem of the file.
    """
    text = _text(path)
    report = Report(path=str(path))
    content, places = _parsed(text, report)
    reader = _Reader(report=report, lines=text.split("\n"), places=places)
    sections = {name: reader.section(name, content.get(name, {})) for name in KEYS}
    for name in content:
        if name not in KEYS and not report.is_full:
            reader.refuse_section(name)
    reader.check_set(content.get("perez", {}))
    report.problems.sort(key=lambda problem: (problem.line, problem.column))
    report.close()
    return SkyToml(perez=perez_section(sections["perez"]), sun=SunSection(**sections["sun"]))


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
            report.add("E701", message, line=number, column=1, text=line, advice="break the line")
    report.close()


def _parsed(text: str, report: Report) -> tuple[dict[str, Any], dict[tuple[str, ...], KeyPlaces]]:
    _refuse_long_lines(text, report)
    try:
        return tomllib.loads(text), key_places(text)
    except RecursionError:
        raise refuse(report.path, "arrays or tables are nested too deeply", code="E701") from None
    except ValueError as error:  # a TOMLDecodeError, or a number that Python refuses
        reason = str(error)
    match = _TOML_PLACE.search(reason)
    message = _TOML_PLACE.sub("", reason)[:120]
    lines = text.rstrip("\n").split("\n")
    line, column = (int(match[1]), int(match[2])) if match and match[1] else (len(lines), len(lines[-1]) + 1)
    shown = lines[line - 1] if line <= len(lines) else ""
    message = f"not TOML: {message[:1].lower()}{message[1:]}"
    is_comma = shown[column - 2 : column - 1].isdigit() and shown[column - 1 : column] == ","
    advice = "write a decimal point" if is_comma else "see docs/formats/sky_toml.md"
    report.add("E701", message, line=line, column=column, text=shown, advice=advice)
    report.close()
    raise AssertionError("a report with an error raises")


@dataclass(frozen=True, kw_only=True, slots=True)
class _Reader:
    """Turns problems of a parsed file into reports with places."""

    report: Report
    lines: list[str]
    places: dict[tuple[str, ...], KeyPlaces]

    def add(self, code: str, message: str, place: Place, *, name: str = "", advice: str = "") -> None:
        self.report.add(
            code,
            message,
            line=place.line,
            column=place.column,
            width=place.width,
            text=self.lines[place.line - 1],
            name=name,
            advice=advice,
        )

    def section(self, section: str, content: object) -> dict[str, Any]:
        """The good values of a section; the others are reported."""
        if not isinstance(content, dict):
            self.add(
                "E703",
                f"{shown_value(content)} where a section is wanted",
                self.places[section,].key,
                advice=f"write [{section}]",
            )
            return {}
        good = {}
        for name, value in content.items():
            if self.report.is_full:
                break
            place = self.places[section, name]
            if name not in KEYS[section]:
                self.refuse_key(section, name, place.key)
                continue
            code, message, advice = value_problem(section, name, value)
            if code:
                self.add(code, message, place.value, name=name, advice=advice)
            else:
                good[name] = value if isinstance(value, bool) else float(value)
        return good

    def refuse_key(self, section: str, name: str, place: Place) -> None:
        elsewhere = [other for other in KEYS if name in KEYS[other]]
        if elsewhere:
            message, advice = f"{name} is a key of [{elsewhere[0]}]", f"write it below [{elsewhere[0]}]"
        else:
            best = nearest(name, KEYS[section])
            message = f"[{section}] has no key {shown_value(name)}; the nearest is {best}"
            advice = f"known keys: {', '.join(KEYS[section])}"
        self.add("E702", message, place, advice=advice)

    def refuse_section(self, name: str) -> None:
        place = self.places[name,].key
        owner = next((section for section in KEYS if name in KEYS[section]), None)
        if name in _LATER:
            self.add("E706", f"[{name}] is not part of this version", place, advice="remove the section")
        elif owner is not None:
            self.add("E702", f"{name} is a key of [{owner}]", place, advice=f"write it below [{owner}]")
        else:
            best = nearest(name, (*KEYS, *_LATER))
            known = " and ".join(f"[{section}]" for section in KEYS)
            self.add(
                "E702",
                f"there is no section {shown_value(name)}; the nearest is [{best}]",
                place,
                advice=f"this version reads {known}",
            )

    def check_set(self, content: object) -> None:
        """Report an incomplete or contradicting choice at its first key; a misspelt key is reported elsewhere."""
        names = list(content) if isinstance(content, dict) else []
        if all(name in KEYS["perez"] for name in names):
            message, advice = set_problem(names)
            if message:
                self.add("E705", message, self.places["perez", names[0]].key, name="perez", advice=advice)
