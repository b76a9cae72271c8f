"""Atmosphere descriptions (``.atmo``), the format of CalcMySky: all is read and checked, no code is evaluated."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from aomc_sky.errors import NOWHERE
from aomc_sky.formats.quote import quote
from aomc_sky.formats.report import MAX_PROBLEMS, BadValueError, Report, nearest, quoted
from aomc_sky.formats.text_file import read_bytes
from aomc_sky.formats.units import AU_M
from aomc_sky.skies.atmosphere.description.data import (
    AbsorberDescription,
    AtmosphereDescription,
    PhaseFunctionType,
    ScattererDescription,
)
from aomc_sky.skies.atmosphere.description.keys import (
    ALBEDO,
    DIRECTIVES,
    EXAMPLES,
    GLOW,
    SCATTERER_DIRECTIVE,
    SECTION_KEYS,
    SIZES,
    SOLAR,
    TOP_KEYS,
    WAVELENGTHS,
    Code,
    Rule,
    Spectral,
)
from aomc_sky.skies.atmosphere.description.scan import Entry, Lines, Section, scan
from aomc_sky.skies.atmosphere.description.spectra import SpectrumReader, Term, is_weighted, out_of_range

MAX_BYTES = 2**20
MAX_SPECIES = 256
_NAME = re.compile(r"[a-z0-9_]+\Z", re.ASCII)


def read_atmo(path: str | Path, *, allow_paths: Sequence[str | Path] = ()) -> AtmosphereDescription:
    """Read a description of an atmosphere and the tables that it names.

    Parameters
    ----------
    path : str or Path
        The file, of format version 6, at most 1 MiB.
    allow_paths : sequence of str or Path
        Folders below which tables may lie, beside the folder of the file.

    Returns
    -------
    AtmosphereDescription
        Numbers in SI, spectra on the wavelengths of the file, code blocks as text that knows where it stands. Unknown
        keys, keys given twice and a missing ground albedo are warnings.

    Raises
    ------
    InputFileError
        Every problem of the file and of its tables.
    OutputError
        The operating system refuses.

    Examples
    --------
    >>> air = sky.atmosphere.read_atmo("inputs/atmosphere/molecules_only.atmo")
    >>> [scatterer.name for scatterer in air.scatterers]
    ['air']
    """
    text = read_bytes(path, most_bytes=MAX_BYTES, code="E401").decode("utf-8", "surrogateescape")
    lines = [line.removesuffix("\r") for line in text.split("\n")]
    report = Report(path=str(path))
    spectra = SpectrumReader(path=str(path), allow_paths=allow_paths)
    file = Lines(lines=lines, report=report)
    description = _description(scan(file), file, spectra)
    report.problems.sort(key=lambda problem: (problem.line == 0, problem.line, problem.column))
    for problem in spectra.problems:
        report.problems.append(problem)
        report.n_errors += problem.is_error
    report.close()
    assert description is not None, "a report with an error raises"
    return description


def _description(
    items: Sequence[Entry | Section], file: Lines, spectra: SpectrumReader
) -> AtmosphereDescription | None:
    """A description of what was found in a file, or None where a problem has been reported."""
    report = file.report
    if not items:
        report.add("E405", "the file has no entries", advice="begin with version: 6")
    elif (first := items[0].head if isinstance(items[0], Section) else items[0]).key != "version":
        report.at(first.key_span, "E405", "the first entry is not the version", advice="write version: 6 above it")
    top = Level(keys=TOP_KEYS, file=file, spectra=spectra)
    sections: list[tuple[Section, Level]] = []
    names: set[str] = set()
    for item in items:
        if report.is_full:
            return None
        if isinstance(item, Entry):
            top.read(item)
            continue
        _check_name(item, names, report)
        level = Level(keys=SECTION_KEYS[item.kind], file=file, spectra=spectra)
        for entry in item.entries:
            level.read(entry)
        level.finish(item.head)
        sections.append((item, level))
    top.finish(None)
    if not any(section.kind == "scatterer" for section, _ in sections):
        report.add("E407", "there is no scatterer", advice='add a section Scatterer "molecules":')
    if report.has_errors or spectra.problems:
        return None
    wavelength, values = spectra.wavelength_nm, top.values
    assert wavelength is not None, "no errors"
    if ALBEDO not in values:
        message = "there is no ground albedo; a white ground is assumed"
        report.add("E405", message, advice="write ground albedo: file grass.csv", is_warning=True)
    if "earth-sun distance" not in values:
        message = "there is no Earth-Sun distance; 1 AU is assumed"
        report.add("E405", message, advice="write Earth-Sun distance: 1 AU", is_warning=True)
    glow, candelas = _glow(top)
    if report.has_errors:
        return None
    return AtmosphereDescription(
        path=report.path,
        atmosphere_height_m=values["atmosphere height"],
        earth_radius_m=values["earth radius"],
        earth_sun_distance_m=values.get("earth-sun distance", float(AU_M)),
        earth_moon_distance_m=values.get("earth-moon distance"),
        scattering_orders=int(values["scattering orders"]),
        wavelength_nm=wavelength,
        solar_irradiance=values[SOLAR],
        ground_albedo=values.get(ALBEDO, _ones(wavelength)),
        ground_glow=glow,
        glow_luminance_cd_m2=candelas,
        species=tuple(_species(*section, wavelength) for section in sections),
        sizes=MappingProxyType({key: values[key] for key in SIZES if key in values}),
        textures_are_radiances=DIRECTIVES[0] in top.directives,
        has_eclipsed_double_scattering_textures=DIRECTIVES[1] not in top.directives,
        texts=tuple(quote(spectra.said.values())),
    )


def _check_name(section: Section, names: set[str], report: Report) -> None:
    """Report the name of a section if it is bad or one of `names`, those of the sections above; and add it there."""
    message = ""
    if section.name and not _NAME.match(section.name):
        message = f"the name {quoted(section.name)} has other characters than letters, digits and underscores"
    elif section.name in names:
        message = f"a second species has the name {quoted(section.name)}; upper and lower case are the same"
    elif len(names) >= MAX_SPECIES:
        message = f"more than {MAX_SPECIES} species"
    if message:
        report.at(section.head.key_span, "E407", message, advice="rename or remove it")
    if section.name:
        names.add(section.name)


def _species(section: Section, level: Level, wavelength_nm: np.ndarray) -> ScattererDescription | AbsorberDescription:
    """The species of a section without errors."""
    line, values = section.head.key_span.line, level.values
    if section.kind == "absorber":
        return AbsorberDescription(
            name=section.name,
            line=line,
            number_density=values["number density"],
            cross_section_m2=values["cross section"],
        )
    return ScattererDescription(
        name=section.name,
        line=line,
        number_density=values["number density"],
        phase_function=values["phase function"],
        cross_section_1um_m2=values["cross section at 1 um"],
        angstrom_exponent=values["angstrom exponent"],
        single_scattering_albedo=values.get("single scattering albedo", _ones(wavelength_nm)),
        phase_function_type=values.get("phase function type", PhaseFunctionType.GENERAL),
        needs_interpolation_guides=SCATTERER_DIRECTIVE in level.directives,
    )


def _glow(top: Level) -> tuple[np.ndarray | None, float | None]:
    """Divide the glow of the ground by its luminance; return it and the luminance that it had."""
    spectrum = top.values.get(GLOW)
    if spectrum is None or not np.any(spectrum):
        return None, None
    span, candelas = top.parts[GLOW][0][0].value_span, top.luminance[GLOW]
    if not candelas > 0.0:
        message = f"its luminance is {candelas:g} cd/m2, so it cannot be scaled to 1 cd/m2"
        advice = "give a table with light between 380 and 780 nm"
        top.file.report.at(span, "E409", message, name=GLOW, advice=advice)
        return None, None
    if abs(candelas - 1.0) > 0.01:
        message = f"its luminance is {candelas:.6g} cd/m2, not 1; it is divided by that"
        top.file.report.at(span, "E409", message, name=GLOW, advice="scale it to 1 cd/m2", is_warning=True)
    scaled = spectrum / candelas
    scaled.flags.writeable = False
    return scaled, candelas


def _ones(wavelength_nm: np.ndarray) -> np.ndarray:
    ones = np.ones(len(wavelength_nm))
    ones.flags.writeable = False
    return ones


_FIRST_WINS = (WAVELENGTHS, SOLAR)
"""The tool writes these two in front of its copy of a file, so the first one counts."""


@dataclass(kw_only=True, slots=True)
class Level:
    """Reads the entries of a file outside its sections, or those of one section."""

    keys: Mapping[str, Rule]  #: The keys of this level
    file: Lines
    spectra: SpectrumReader
    values: dict[str, Any] = field(default_factory=dict)  #: Good values so far; spectra arrive with `finish`
    luminance: dict[str, float] = field(default_factory=dict)  #: Of glows; 0 for other spectra. [cd m-2]
    #: The entries of each spectrum, in their order, with what they add; None for one that was refused
    parts: dict[str, list[tuple[Entry, Term | None]]] = field(default_factory=dict)
    seen: set[str] = field(default_factory=set)  #: Keys that stood there, good or bad
    #: Entries of unknown keys by the known key that is most like theirs
    unknown: dict[str, Entry] = field(default_factory=dict)
    directives: set[str] = field(default_factory=set)

    def read(self, entry: Entry) -> None:
        """Read one entry; what is wrong with it is reported."""
        if entry.key in DIRECTIVES or entry.key == SCATTERER_DIRECTIVE:
            self.directives.add(entry.key)
            return
        rule = self.keys.get(entry.key)
        if rule is None:
            self._unknown(entry)
            return
        try:
            if isinstance(rule, Spectral):
                self._spectrum(entry, rule)
            elif entry.key not in self.seen or self._repeated(entry):
                self._single(entry, rule)
        except BadValueError as first:
            for problem in (first, *first.more):
                self.file.report.bad_value(entry.value_span, problem, name=entry.key)
        self.seen.add(entry.key)

    def finish(self, head: Entry | None) -> None:
        """Add up the spectra, and report required keys that stand nowhere: at the head of the section, if it is one."""
        report = self.file.report
        for key, parts in self.parts.items():
            rule, entry, terms = self.keys[key], parts[0][0], [term for _, term in parts if term is not None]
            assert isinstance(rule, Spectral), "it has parts"
            if len(terms) < len(parts):
                continue
            values, self.luminance[key] = np.zeros(()), 0.0
            for term in terms:
                values = values + term[0]
                self.luminance[key] += term[1]
            values.flags.writeable = False
            bad = np.flatnonzero(~((values >= 0.0) & (values <= rule.high)))
            if not bad.size:
                self.values[key] = values
                continue
            assert self.spectra.wavelength_nm is not None, "there are values"
            shown = f"{values[bad[0]]:.9g} at {self.spectra.wavelength_nm[bad[0]]:g} nm"
            report.bad_value(entry.value_span, out_of_range(shown, rule), name=key)
        for key in EXAMPLES:
            if key not in self.keys or key in self.seen or key in self.file.spoilt:
                continue
            span, message = NOWHERE, f"the entry {quoted(key)} is missing"
            if (other := self.unknown.get(key)) is not None:
                # at the key that it was mistaken for
                span, message = other.key_span, f"{quoted(key)} is missing; found {quoted(other.key)}"
            elif head is not None:
                span, message = head.key_span, f"{message} in this section"
            report.at(span, "E405", message, advice=f"write {EXAMPLES[key]}")

    def _repeated(self, entry: Entry) -> bool:
        """Report that a key stands twice; whether the new value counts."""
        keeps = "first" if entry.key in _FIRST_WINS else "last"
        message = f"is given twice; the {keeps} value is used"
        self.file.report.at(entry.value_span, "E405", message, name=entry.key, advice="keep one", is_warning=True)
        return keeps == "last"

    def _single(self, entry: Entry, rule: Code | Callable[[str], Any]) -> None:
        if entry.key == WAVELENGTHS:
            self.spectra.has_wavelengths = True
        value: Any = entry.code
        if not isinstance(rule, Code):
            value = rule(entry.value)
        elif entry.code is None:
            self._require_wavelengths("a table")
            value = self.spectra.phase_table(entry.value)
        if entry.key == WAVELENGTHS:
            self.spectra.wavelength_nm = value
        if value is not None:
            self.values[entry.key] = value

    def _require_wavelengths(self, what: str) -> None:
        if not self.spectra.has_wavelengths:
            raise BadValueError("E405", f"{what} before the wavelengths", advice="write wavelengths: above it")

    def _spectrum(self, entry: Entry, rule: Spectral) -> None:
        """Read one entry of a spectrum: a new one, or a weighted part that is added."""
        self._require_wavelengths("a spectrum")
        parts = self.parts.setdefault(entry.key, [])
        if parts and not is_weighted(entry.value):
            if is_weighted(parts[-1][0].value):
                message = "a spectrum after weighted files of the same key"
                raise BadValueError("E405", message, advice="write weighted file 1, or remove one")
            if not self._repeated(entry):
                return
            parts.clear()
        parts.append((entry, None))  # it stays so where it is refused
        parts[-1] = entry, self.spectra.term(entry.value, rule)

    def _unknown(self, entry: Entry) -> None:
        if len(self.file.report.problems) >= MAX_PROBLEMS:
            return  # enough is reported, and to look for the nearest key takes time
        best = nearest(entry.key, self.keys)
        self.unknown[best] = entry
        message = f"there is no key {quoted(entry.key)}; the nearest is '{best}'"
        self.file.report.at(entry.key_span, "E401", message, advice="it is not read", is_warning=True)
