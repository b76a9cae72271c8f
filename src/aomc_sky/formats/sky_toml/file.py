"""sky.toml, beside amc.inp: the weather of the Perez sky, the sun's exact direction, backgrounds, absolute units."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aomc_sky.errors import Problem, Span
from aomc_sky.formats.report import BadValueError, Report, nearest_text
from aomc_sky.formats.sky_models import is_sunless
from aomc_sky.formats.sky_toml.keys import (
    DIFFUSE_MODELS,
    FIELD_KEYS,
    KEYS,
    MOON_KEYS,
    PATHS,
    PER_WAVEBAND,
    POLARISATION,
    REPEATED,
    REQUIRED,
    joined,
    moon_problem,
    set_problem,
    shown_value,
)
from aomc_sky.formats.sky_toml.sections import (
    BUILDERS,
    SkyOption,
    SkyToml,
)
from aomc_sky.formats.text_file import read_bytes, refuse

MAX_BYTES = 65_536
MAX_LINE_CHARACTERS = 2000
"""A key of very many parts in one line would keep the standard library's reader busy for many seconds."""

_PART = r"""(?:"(?:[^"\\\n]|\\.)*"|'[^'\n]*'|[A-Za-z0-9_-]+)"""
_KEY = rf"{_PART}(?:[ \t]*\.[ \t]*{_PART})*"
#: A header, or a key with what is assigned in its line, without a comment
_LINE = re.compile(
    rf"""^[ \t]*(?:(?P<brackets>\[\[?)[ \t]*(?P<table>{_KEY})[ \t]*\]"""
    rf"""|(?P<key>{_KEY})[ \t]*=[ \t]*(?P<value>(?:"(?:[^"\\\n]|\\.)*"|'[^'\n]*'|[^#\n])*))""",
    re.MULTILINE,
)
_SYNTAX = "write name = value: texts in quotes, numbers with a point, true or false; see docs/formats/sky_toml.md"
_TOML_POSITION = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)\Z")


def read_sky_toml(path: str | Path, *, n_wavebands: int | None = None, allow_paths: Sequence[str] = ()) -> SkyToml:
    """Read sky.toml; arrays for the wavebands must have `n_wavebands` values.

    The files that it names may lie below its own folder and below `allow_paths`.
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
    not_repeated = [name for name in KEYS if name not in REPEATED]
    single = {name: reader.section(name, content[name]) if name in content else {} for name in not_repeated}
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


def problem_of_key(path: str | Path, key: tuple[str, ...], code: str, message: str, advice: str) -> Problem:
    """A problem that appears when the file is used, at the value of a key such as ("sky", "table")."""
    span = key_spans(_text(path))[key].value
    return span.problem(str(path), code, message, field=key[-1], advice=advice)


def _text(path: str | Path) -> str:
    """The text of the file, with LF as line ends."""
    data = read_bytes(path, most_bytes=MAX_BYTES, code="E701")
    try:
        return data.decode().replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line_start = before.rfind(b"\n") + 1
        text = data[line_start:].split(b"\n")[0].decode("latin-1")
        span = Span(before.count(b"\n") + 1, len(before[line_start:].decode()) + 1, text)
        raise refuse(path, "the file is not UTF-8", code="E701", span=span, advice="save it as UTF-8") from None


def _refuse_long_lines(text: str, report: Report) -> None:
    for number, line in enumerate(text.split("\n"), start=1):
        if len(line) > MAX_LINE_CHARACTERS:
            message = f"the line is longer than {MAX_LINE_CHARACTERS} characters"
            report.at(Span(number, 1, line), "E701", message, advice="break the line")
    report.close()


def _parsed(text: str, report: Report) -> tuple[dict[str, Any], SpansOfKeys]:
    _refuse_long_lines(text, report)
    try:
        return tomllib.loads(text), key_spans(text)
    except RecursionError:
        raise refuse(report.path, "arrays or tables are nested too deeply", code="E701") from None
    except ValueError as error:  # a TOMLDecodeError, or a number that Python refuses
        reason = str(error)
    match = _TOML_POSITION.search(reason)
    message = _TOML_POSITION.sub("", reason)[:120]
    lines = text.rstrip("\n").split("\n")
    line, column = (int(match[1]), int(match[2])) if match and match[1] else (len(lines), len(lines[-1]) + 1)
    shown = lines[line - 1] if line <= len(lines) else ""
    if message == "Cannot overwrite a value" or message.endswith(" twice"):
        span, name = Span(line, 1, shown, max(len(shown.rstrip()), 1)), shown.partition("=")[0].strip()
        report.at(span, "E701", f"{name} stands twice", advice="write each key and each section once")
    else:
        message = f"not TOML: {message[:1].lower()}{message[1:]}"
        report.at(Span(line, column, shown), "E701", message, advice=_SYNTAX)
    report.close()
    raise AssertionError("a report with an error raises")


def _header(section: str) -> str:
    """The line that begins a section."""
    return f"[[{section}]]" if section in REPEATED else f"[{section}]"


@dataclass(frozen=True, kw_only=True, slots=True)
class SectionReader:
    """Turns problems of a parsed file into reports with spans."""

    report: Report
    spans: SpansOfKeys  #: Positions of the keys
    folder: Path  #: Folder of the file, from which the paths in it count
    allow_paths: Sequence[str] = ()  #: Folders beside it, below which the files named may lie
    n_wavebands: int | None = None  #: Values that an array for the wavebands must have, where that is known

    def section(self, section: str, content: object) -> dict[str, Any]:
        """The good values of a section that may stand once."""
        if isinstance(content, dict):
            return self._values(section, content, (section,))
        shown, advice = shown_value(content), f"write [{section}]"
        self.report.at(self.spans[section,].key, "E703", f"{shown} where a section is expected", advice=advice)
        return {}

    def repeated(self, section: str, content: object) -> list[dict[str, Any]]:
        """The good values of each of the sections of a name; [section] alone is reported."""
        if isinstance(content, list) and all(isinstance(element, dict) for element in content):
            return [self._values(section, one, (section, str(k))) for k, one in enumerate(content)]
        shown, advice = shown_value(content), f"write [[{section}]]: there may be several"
        self.report.at(self.spans[section,].key, "E703", f"{shown} where sections are expected", advice=advice)
        return []

    def _values(self, section: str, content: dict[str, Any], path: tuple[str, ...]) -> dict[str, Any]:
        good: dict[str, Any] = {}
        model = content.get("model") if section == "sky" else None
        is_of_others = isinstance(model, str) and model not in DIFFUSE_MODELS
        options: list[SkyOption] = []
        for name, value in content.items():
            if self.report.is_full:
                break
            if name in KEYS[section] and not (is_of_others and name in FIELD_KEYS):
                if (read := self._value(section, name, value, (*path, name))) is not None:
                    good[name] = read
            elif is_of_others:
                span = self.spans[*path, name]
                options.append(SkyOption(name=name, value=value, key_span=span.key, value_span=span.value))
            else:
                self._refuse_key(section, name, self.spans[*path, name].key)
        if is_of_others:
            good |= {"options": tuple(options), "model_span": self.spans[*path, "model"].value}
        self._check_required(section, content, path)
        for name in PATHS.get(section, ()):
            if name in good:
                good[name] = self._allowed_path(good[name], name, self.spans[*path, name].value)
        return good

    def _value(self, section: str, name: str, value: object, path: tuple[str, ...]) -> Any:
        """The value of a key; a bad one is reported and gives None."""
        span, n_bands = self.spans[path].value, self.n_wavebands
        try:
            good = KEYS[section][name](value)
        except BadValueError as first:
            for problem in (first, *first.more):
                if not self.report.is_full:
                    self.report.at(span, problem.code, problem.message, name=name, advice=problem.advice)
            return None
        if name not in PER_WAVEBAND.get(section, ()) or n_bands is None or len(good) == n_bands:
            return good
        message = f"{len(good)} value{'s' * (len(good) != 1)} for {n_bands} waveband{'s' * (n_bands != 1)}"
        self.report.at(span, "E705", message, name=name, advice="write one for each line of lambbot.inp")
        return None

    def _check_required(self, section: str, content: dict[str, Any], path: tuple[str, ...]) -> None:
        missing = [name for name in REQUIRED.get(section, ()) if name not in content]
        if missing and all(name in KEYS[section] for name in content):  # else a name is misspelt, and reported
            span = self.spans[path].key
            self.report.at(
                span, "E705", f"{_header(section)} without {joined(missing)}", advice=f"add {' and '.join(missing)}"
            )

    def _allowed_path(self, name: str, key: str, span: Span) -> str:
        """The path as it can be opened, if it lies below an allowed folder, links followed."""
        path = self.folder / name
        real = path.resolve()
        roots: list[str | Path] = [self.folder, *self.allow_paths]
        if not any(real.is_relative_to(Path(root).resolve()) for root in roots):
            message = f"{shown_value(name)} is not below the folder of this file"
            near = Path(os.path.normpath(path.parent))
            allowed = near if near.resolve() == real.parent else real.parent  # links lead elsewhere
            self.report.at(span, "E707", message, name=key, advice=f"move it there, or write --allow-path {allowed}")
        return str(path)

    def _refuse_key(self, section: str, name: str, span: Span) -> None:
        owner = next((other for other in KEYS if name in KEYS[other]), None)
        if owner is not None and not nearest_text(name, KEYS[section]):  # azimuth of [sun] is no name of a column
            message, advice = f"{name} is a key of [{owner}]", f"write it below [{owner}]"
        else:
            message = f"[{section}] has no key {shown_value(name)}{nearest_text(name, KEYS[section])}"
            advice = f"known keys: {', '.join(KEYS[section])}"
        self.report.at(span, "E702", message, advice=advice)

    def refuse_section(self, name: str) -> None:
        """Report an unknown section, or a key outside all sections."""
        span = self.spans[name,].key
        owner = next((section for section in KEYS if name in KEYS[section]), None)
        if owner is not None:
            self.report.at(span, "E702", f"{name} is a key of [{owner}]", advice=f"write it below [{owner}]")
        else:
            known = list(map(_header, KEYS))
            message = f"there is no section {shown_value(name)}{nearest_text(name, known)}"
            self.report.at(span, "E702", message, advice=f"this version reads {', '.join(known)}")

    def check_sets(self, content: dict[str, Any]) -> None:
        """Report choices that are incomplete or contradict each other, at their first key."""
        sections = [content.get(name) for name in ("perez", "sun", "sky", "atmosphere")]
        perez, sun, sky, atmosphere = (one if isinstance(one, dict) else {} for one in sections)
        is_known = all(name in KEYS["perez"] for name in perez)  # a misspelt key is reported elsewhere
        if is_known and (problem := set_problem(perez)):
            self._contradict(("perez", next(iter(perez))), problem.message, problem.advice)
        zenith: Any = sun.get("zenith_deg")
        if "atmosphere" not in content and type(zenith) in (int, float) and 90 <= zenith <= 180:
            span, message = self.spans["sun", "zenith_deg"].value, f"{zenith} is outside the range 0 to below 90"
            advice = "write 0 to below 90; a sun that has set needs [atmosphere]"
            self.report.at(span, "E704", message, name="zenith_deg", advice=advice)
        moon = [name for name in atmosphere if name in MOON_KEYS]
        if problem := moon_problem(moon):
            self._contradict(("atmosphere", moon[0]), problem.message, problem.advice)
        model = sky.get("model")
        if "table" in sky and "model" in sky:
            self._contradict(("sky", "model"), "model and table describe the same sky twice", "remove one of them")
        elif "table" not in sky and (model is None or model in DIFFUSE_MODELS):  # another sky may have such options
            for name in (name for name in FIELD_KEYS if name in sky):
                self._contradict(("sky", name), f"{name} without table", 'add table = "field.nc"')
        for other in (name for name in ("model", "table") if name in sky and "weighting" in sky):
            message = f"weighting is that of skydist.inp, and {other} names another sky"
            self._contradict(("sky", "weighting"), message, "remove one of them")
        if "zenith" in sky and "elevation" in sky:
            self._contradict(("sky", "elevation"), "zenith and elevation name the same angle", "remove one of them")
        for one, other in (("variable_q", "variable_u"), ("variable_u", "variable_q")):
            if "table" in sky and one in sky and other not in sky:
                self._contradict(("sky", one), f"{one} without {other}", f"add {other}")
        if "atmosphere" in content:
            if perez:
                self._contradict(
                    ("perez",), "[perez] and [atmosphere] describe the same sky twice", "remove one of them", name=""
                )
            for name in (name for name in sky if name in KEYS["sky"] and name != POLARISATION):
                message = f"{name} together with [atmosphere], which already gives it"
                self._contradict(("sky", name), message, "remove it")
        elif model == "none":
            if not content.get("background"):
                message, advice = (
                    'model "none" without a background gives no light',
                    "add [[background]] with file and time",
                )
                self.report.at(self.spans["sky", "model"].value, "E705", message, name="sky", advice=advice)
            for name in (name for name in (*PER_WAVEBAND["sky"], POLARISATION) if name in sky):
                self._contradict(("sky", name), f'{name} with model "none"', "remove one of them")
        if POLARISATION in sky and is_sunless(model):
            message = f'{POLARISATION} with model "{model}", which has no sun for Rayleigh\'s pattern'
            self._contradict(("sky", POLARISATION), message, "remove one of them")

    def _contradict(self, path: tuple[str, ...], message: str, advice: str, *, name: str | None = None) -> None:
        """Report a key that contradicts others."""
        name = path[0] if name is None else name
        self.report.at(self.spans[path].key, "E705", message, name=name, advice=advice)


# Positions of keys: the standard library's reader gives values without lines.


@dataclass(frozen=True, kw_only=True, slots=True)
class KeySpans:
    """`key` is the name, `value` what is assigned in its line; a table's header has its name twice."""

    key: Span
    value: Span


class SpansOfKeys(dict[tuple[str, ...], KeySpans]):
    """Spans by the path of a key; a key without a line of its own has the span of the key around it."""

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
