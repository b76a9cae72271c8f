"""From the entries of a description file to its values: ranges, order, what is missing, what stands twice."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from aomc_sky.formats.atmo_data import (
    AbsorberDescription,
    AtmosphereDescription,
    PhaseFunctionType,
    ScattererDescription,
)
from aomc_sky.formats.atmo_keys import (
    ALBEDO,
    DIRECTIVES,
    EXAMPLES,
    GLOW,
    REQUIRED,
    SCATTERER_DIRECTIVE,
    SECTION_KEYS,
    SIZES,
    SOLAR,
    TOP_KEYS,
    WAVELENGTHS,
    Code,
    Integer,
    Quantity,
    Real,
    Rule,
    Spectral,
    Version,
    Word,
)
from aomc_sky.formats.atmo_scan import Entry, Scanner, Section
from aomc_sky.formats.atmo_spectra import SpectrumReader, Term, out_of_range
from aomc_sky.formats.atmo_values import (
    quantity_value,
    real_value,
    size_value,
    version_value,
    wavelength_values,
    word_value,
)
from aomc_sky.formats.bad_value import BadValueError, quoted
from aomc_sky.formats.sky_keys import nearest
from aomc_sky.formats.text_file import MAX_PROBLEMS
from aomc_sky.formats.units import AU_M

MAX_SPECIES = 256
_NAME = re.compile(r"[a-z0-9_]+\Z", re.ASCII)
_FIRST_WINS = (WAVELENGTHS, SOLAR)
"""The tool writes these two in front of a copy of the file, so the first one counts."""


@dataclass(kw_only=True, slots=True)
class _Sum:
    """A spectrum while it is read: its terms so far and the entry that began it; `is_bad` where a term was refused."""

    entry: Entry
    terms: list[Term] = field(default_factory=list)
    is_weighted: bool = False
    is_bad: bool = False


@dataclass(kw_only=True, slots=True)
class Builder:
    """Makes a description of what a scanner found.

    Parameters
    ----------
    scanner : Scanner
        Where problems are told.
    path : str
        The file.
    allow_paths : sequence of str or Path
        As `read_atmo` has them.
    """

    scanner: Scanner
    path: str
    allow_paths: Sequence[str | Path] = ()
    spectra: SpectrumReader = field(init=False)
    wavelength_nm: np.ndarray | None = None
    has_wavelengths: bool = False
    names: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.spectra = SpectrumReader(path=self.path, allow_paths=self.allow_paths)

    def description(self, items: Sequence[Entry | Section]) -> AtmosphereDescription | None:
        """Return the description, or None where a problem has been told."""
        self._check_first(items)
        reader = _EntryReader(builder=self, keys=TOP_KEYS)
        species: list[ScattererDescription | AbsorberDescription | None] = []
        for item in items:
            if isinstance(item, Entry):
                reader.read(item)
            else:
                species.append(self._species(item))
            if self.scanner.report.is_full:
                return None
        values = reader.finish()
        self._require(values, reader.seen, "", 0, 0, 0)
        self._check_species(items)
        if self.scanner.report.has_errors or self.spectra.problems:
            return None
        return self._assembled(values, reader, [s for s in species if s is not None])

    def _assembled(
        self, values: dict[str, Any], reader: _EntryReader, species: list[ScattererDescription | AbsorberDescription]
    ) -> AtmosphereDescription | None:
        assert self.wavelength_nm is not None, "no errors"
        albedo = values.get(ALBEDO)
        if albedo is None:
            self._warn_file("E405", "no ground albedo; a white ground is assumed", "add ground albedo: 0.1, 0.1, ...")
            albedo = np.ones(len(self.wavelength_nm))
        if "earth-sun distance" not in values:
            self._warn_file("E405", "no Earth-Sun distance; 1 AU is assumed", "add Earth-Sun distance: 1 AU")
        glow, found = self._glow(values.get(GLOW), reader)
        if self.scanner.report.has_errors:
            return None
        return AtmosphereDescription(
            path=self.path,
            atmosphere_height_m=values["atmosphere height"],
            earth_radius_m=values["earth radius"],
            earth_sun_distance_m=values.get("earth-sun distance", float(AU_M)),
            earth_moon_distance_m=values.get("earth-moon distance"),
            scattering_orders=int(values["scattering orders"]),
            wavelength_nm=self.wavelength_nm,
            solar_irradiance=values[SOLAR],
            ground_albedo=_read_only(albedo),
            ground_glow=glow,
            glow_luminance_cd_m2=found,
            species=tuple(species),
            sizes=MappingProxyType({key: values[key] for key in SIZES if key in values}),
            textures_are_radiances=DIRECTIVES[0] in reader.directives,
            has_eclipsed_double_scattering_textures=DIRECTIVES[1] not in reader.directives,
        )

    def _warn_file(self, code: str, message: str, advice: str) -> None:
        self.scanner.report.add(code, message, advice=advice, is_warning=True)

    def _check_first(self, items: Sequence[Entry | Section]) -> None:
        first = items[0] if items else None
        if first is None:
            self.scanner.report.add("E405", "the file has no entries", advice="begin with version: 6")
        elif not isinstance(first, Entry) or first.key != "version":
            message = "the first entry is not the version"
            self.scanner.problem("E405", first.line, first.column, message, advice="write version: 6 above it")

    def _check_species(self, items: Sequence[Entry | Section]) -> None:
        sections = [item for item in items if isinstance(item, Section)]
        if items and not any(section.kind == "scatterer" for section in sections):
            self.scanner.report.add("E407", "there is no scatterer", advice='add a section Scatterer "molecules":')

    def _species(self, section: Section) -> ScattererDescription | AbsorberDescription | None:
        """Read a section."""
        self._check_name(section)
        reader = _EntryReader(builder=self, keys=SECTION_KEYS[section.kind])
        for entry in section.entries:
            reader.read(entry)
        values = reader.finish()
        if section.is_whole:
            self._require(values, reader.seen, section.kind, section.line, section.column, section.width)
        if any(key not in values for key in REQUIRED[section.kind]) or self.wavelength_nm is None:
            return None
        shared = {"name": section.name, "line": section.line, "number_density": values["number density"]}
        if section.kind == "absorber":
            return AbsorberDescription(**shared, cross_section_m2=values["cross section"])
        albedo = values.get("single scattering albedo")
        return ScattererDescription(
            **shared,
            phase_function=values["phase function"],
            cross_section_1um_m2=values["cross section at 1 um"],
            angstrom_exponent=values["angstrom exponent"],
            single_scattering_albedo=_read_only(np.ones(len(self.wavelength_nm)) if albedo is None else albedo),
            phase_function_type=PhaseFunctionType(values.get("phase function type", "general")),
            needs_interpolation_guides=SCATTERER_DIRECTIVE in reader.directives,
        )

    def _check_name(self, section: Section) -> None:
        place = (section.line, section.column)
        if section.name and not _NAME.match(section.name):
            message = f"the name {quoted(section.name)} has other characters than letters, digits and underscores"
            self.scanner.problem("E407", *place, message, advice="rename the species", width=section.width)
        elif section.name in self.names:
            message = f"a second species with the name {quoted(section.name)} (capitals do not count)"
            self.scanner.problem("E407", *place, message, advice="rename one", width=section.width)
        elif len(self.names) >= MAX_SPECIES:
            message = f"more than {MAX_SPECIES} species"
            self.scanner.problem("E407", *place, message, advice="join some of them", width=section.width)
        self.names.add(section.name)

    def _require(
        self, values: Mapping[str, Any], seen: Mapping[str, Any], kind: str, line: int, column: int, width: int
    ) -> None:
        """Report required keys that are not there at all."""
        for key in REQUIRED[kind]:
            if key in values or key in seen:
                continue
            message, advice = f"no {key}", f"write {EXAMPLES[key]}"
            if line:
                self.scanner.problem("E405", line, column, message, name=kind, advice=advice, width=width)
            else:
                self.scanner.report.add("E405", message, advice=advice)

    def _glow(self, spectrum: np.ndarray | None, reader: _EntryReader) -> tuple[np.ndarray | None, float | None]:
        """Divide the glow of the ground by its luminance."""
        if spectrum is None or not np.any(spectrum):
            return None, None
        total = reader.sums[GLOW]
        found = sum(term.luminance for term in total.terms)
        if not found > 0.0:
            message = f"its luminance is {found:g} cd/m2, so it cannot be scaled to 1 cd/m2"
            advice = "give a file with light between 380 and 780 nm"
            self.scanner.value_problem(total.entry, BadValueError("E409", message, advice=advice))
            return None, None
        if abs(found - 1.0) > 0.01:
            message = f"its luminance is {found:.6g} cd/m2; it is divided by this"
            advice = "scale it to 1 cd/m2"
            self.scanner.value_problem(total.entry, BadValueError("E409", message, advice=advice), is_warning=True)
        return _read_only(spectrum / found), found


@dataclass(kw_only=True, slots=True)
class _EntryReader:
    """Reads the entries of one level: the file itself, or one section."""

    builder: Builder
    keys: Mapping[str, Rule]
    values: dict[str, Any] = field(default_factory=dict)
    sums: dict[str, _Sum] = field(default_factory=dict)
    seen: dict[str, Entry] = field(default_factory=dict)
    directives: set[str] = field(default_factory=set)

    def read(self, entry: Entry) -> None:
        """Read one entry; what is wrong with it is told."""
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
            else:
                self._single(entry, rule)
        except BadValueError as problem:
            self.builder.scanner.value_problem(entry, problem)
        self.seen.setdefault(entry.key, entry)

    def finish(self) -> dict[str, Any]:
        """All good values, spectra summed up."""
        for key, total in self.sums.items():
            rule = self.keys[key]
            if total.is_bad or not total.terms or not isinstance(rule, Spectral):
                continue
            values = np.sum([term.values for term in total.terms], axis=0)
            bad = np.flatnonzero(~((values >= 0.0) & (values <= rule.high)))
            if bad.size:
                assert self.builder.wavelength_nm is not None, "a term has values"
                shown = f"{values[bad[0]]:.9g} at {self.builder.wavelength_nm[bad[0]]:g} nm"
                self.builder.scanner.value_problem(total.entry, out_of_range(shown, rule))
            else:
                self.values[key] = _read_only(values)
        return self.values

    def _single(self, entry: Entry, rule: Rule) -> None:
        if entry.key in self.seen:
            keeps = "first" if entry.key in _FIRST_WINS else "last"
            message = f"stands a second time; the {keeps} one counts"
            problem = BadValueError("E405", message, advice="keep one")
            self.builder.scanner.value_problem(entry, problem, is_warning=True)
            if keeps == "first":
                return
        if isinstance(rule, Code):
            if entry.code is not None:
                self.values[entry.key] = entry.code
        elif isinstance(rule, Quantity):
            self.values[entry.key] = quantity_value(entry.value, rule)
            self._check_document(entry, rule)
        elif isinstance(rule, Real):
            self.values[entry.key] = real_value(entry.value, rule)
        elif isinstance(rule, Integer):
            self.values[entry.key] = size_value(entry.value, rule)
        elif isinstance(rule, Word):
            self.values[entry.key] = word_value(entry.value, rule)
        elif isinstance(rule, Version):
            self.values[entry.key] = version_value(entry.value)
        else:
            self.builder.has_wavelengths = True
            self.builder.wavelength_nm = wavelength_values(entry.value)
            self.values[entry.key] = self.builder.wavelength_nm

    def _check_document(self, entry: Entry, rule: Quantity) -> None:
        if rule.document_low is not None and self.values[entry.key] < rule.document_low:
            message = f"{quoted(entry.value)} is below the 100 km that the document of the format allows"
            problem = BadValueError("E404", message, advice="the tool itself takes it")
            self.builder.scanner.value_problem(entry, problem, is_warning=True)

    def _spectrum(self, entry: Entry, rule: Spectral) -> None:
        """Read one entry of a spectrum: a new one, or a weighted part that is added."""
        if not self.builder.has_wavelengths:
            raise BadValueError("E405", "a spectrum above the wavelengths", advice="write wavelengths: further up")
        before = self.sums.get(entry.key)
        is_weighted = entry.value.startswith("weighted file")
        if before is None:
            before = self.sums[entry.key] = _Sum(entry=entry)
        elif not is_weighted and before.is_weighted:
            message = "a whole spectrum below weighted files of the same key"
            raise BadValueError("E405", message, advice="write weighted file 1 instead, or remove one")
        elif not is_weighted:
            keeps = "first" if entry.key in _FIRST_WINS else "last"
            problem = BadValueError("E405", f"stands a second time; the {keeps} one counts", advice="keep one")
            self.builder.scanner.value_problem(entry, problem, is_warning=True)
            if keeps == "first":
                return
            before = self.sums[entry.key] = _Sum(entry=entry)
        before.is_weighted |= is_weighted
        was_bad, before.is_bad = before.is_bad, True
        term = self.builder.spectra.term(entry.value, rule, self.builder.wavelength_nm)
        if term is not None:
            before.terms.append(term)
            before.is_bad = was_bad

    def _unknown(self, entry: Entry) -> None:
        scanner = self.builder.scanner
        if len(scanner.report.problems) >= MAX_PROBLEMS:
            return  # enough is told, and looking for the nearest key costs time
        best = nearest(entry.key, self.keys)
        message = f"there is no key {quoted(entry.key)}; the nearest is '{best}'"
        width = len(entry.key)
        scanner.problem(
            "E401", entry.line, entry.column, message, advice="it is not read", width=width, is_warning=True
        )


def _read_only(values: np.ndarray) -> np.ndarray:
    values.flags.writeable = False
    return values
