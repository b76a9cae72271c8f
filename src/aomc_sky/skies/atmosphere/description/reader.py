"""Atmosphere descriptions (``.atmo``), the format of CalcMySky: all is read and checked, no code is evaluated."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

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
from aomc_sky.skies.atmosphere.description.spectra import SpectrumReader, out_of_range

MAX_BYTES = 2**20
MAX_SPECIES = 256
_NAME = re.compile(r"[a-z0-9_]+\Z", re.ASCII)
Species = ScattererDescription | AbsorberDescription


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
    >>> air = sky.read_atmo("inputs/atmosphere/molecules_only.atmo")
    >>> [scatterer.name for scatterer in air.scatterers]
    ['air']
    """
    text = read_bytes(path, most_bytes=MAX_BYTES, code="E401").decode("utf-8", "surrogateescape")
    lines = [line.removesuffix("\r") for line in text.split("\n")]
    report = Report(path=str(path))
    spectra = SpectrumReader(path=str(path), allow_paths=allow_paths)
    file = Lines(lines=lines, report=report)
    description = Builder(report=report, spoilt=file.spoilt, spectra=spectra).description(scan(file))
    report.problems.sort(key=lambda problem: (problem.line == 0, problem.line, problem.column))
    for problem in spectra.problems:
        report.problems.append(problem)
        report.n_errors += problem.is_error
    report.close()
    assert description is not None, "a report with an error raises"
    return description


@dataclass(kw_only=True, slots=True)
class Builder:
    """Makes a description of what was found in a file."""

    report: Report
    spoilt: set[str]  #: See `Lines`
    spectra: SpectrumReader
    wavelength_nm: np.ndarray | None = None  #: The wavelengths of the file, once they are read. [nm]
    has_wavelengths: bool = False  #: They were there, good or bad
    names: set[str] = field(default_factory=set)

    def description(self, items: Sequence[Entry | Section]) -> AtmosphereDescription | None:
        """Return the description, or None where a problem has been reported."""
        report = self.report
        if not items:
            report.add("E405", "the file has no entries", advice="begin with version: 6")
        elif (first := items[0].head if isinstance(items[0], Section) else items[0]).key != "version":
            report.at(first.key_span, "E405", "the first entry is not the version", advice="write version: 6 above it")
        reader = EntryReader(builder=self, keys=TOP_KEYS)
        species = []
        for item in items:
            if report.is_full:
                return None
            if isinstance(item, Entry):
                reader.read(item)
            else:
                species.append(self._species(item))
        values = reader.finish()
        reader.require(None)
        if not any(isinstance(item, Section) and item.kind == "scatterer" for item in items):
            report.add("E407", "there is no scatterer", advice='add a section Scatterer "molecules":')
        if report.has_errors or self.spectra.problems:
            return None
        return self._assembled(values, reader, tuple(part for part in species if part is not None))

    def _assembled(
        self, values: dict[str, Any], reader: EntryReader, species: tuple[Species, ...]
    ) -> AtmosphereDescription | None:
        """Put values without errors together."""
        report, wavelength = self.report, self.wavelength_nm
        assert wavelength is not None, "no errors"
        if ALBEDO not in values:
            message = "there is no ground albedo; a white ground is assumed"
            report.add("E405", message, advice="write ground albedo: file grass.csv", is_warning=True)
        if "earth-sun distance" not in values:
            message = "there is no Earth-Sun distance; 1 AU is assumed"
            report.add("E405", message, advice="write Earth-Sun distance: 1 AU", is_warning=True)
        glow, candelas = self._glow(values.get(GLOW), reader)
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
            species=species,
            sizes=MappingProxyType({key: values[key] for key in SIZES if key in values}),
            textures_are_radiances=DIRECTIVES[0] in reader.directives,
            has_eclipsed_double_scattering_textures=DIRECTIVES[1] not in reader.directives,
            texts=tuple(quote(self.spectra.said.values())),
        )

    def _species(self, section: Section) -> Species | None:
        """Read a section."""
        self._check_name(section)
        reader = EntryReader(builder=self, keys=SECTION_KEYS[section.kind])
        for entry in section.entries:
            reader.read(entry)
        values = reader.finish()
        required = reader.require(section.head)
        if any(key not in values for key in required) or self.wavelength_nm is None:
            return None
        head = section.head
        if section.kind == "absorber":
            return AbsorberDescription(
                name=section.name,
                line=head.key_span.line,
                number_density=values["number density"],
                cross_section_m2=values["cross section"],
            )
        return ScattererDescription(
            name=section.name,
            line=head.key_span.line,
            number_density=values["number density"],
            phase_function=values["phase function"],
            cross_section_1um_m2=values["cross section at 1 um"],
            angstrom_exponent=values["angstrom exponent"],
            single_scattering_albedo=values.get("single scattering albedo", _ones(self.wavelength_nm)),
            phase_function_type=values.get("phase function type", PhaseFunctionType.GENERAL),
            needs_interpolation_guides=SCATTERER_DIRECTIVE in reader.directives,
        )

    def _check_name(self, section: Section) -> None:
        message = ""
        if section.name and not _NAME.match(section.name):
            message = f"the name {quoted(section.name)} has other characters than letters, digits and underscores"
        elif section.name in self.names:
            message = f"a second species has the name {quoted(section.name)}; upper and lower case are the same"
        elif len(self.names) >= MAX_SPECIES:
            message = f"more than {MAX_SPECIES} species"
        if message:
            self.report.at(section.head.key_span, "E407", message, advice="rename or remove it")
        if section.name:
            self.names.add(section.name)

    def _glow(self, spectrum: np.ndarray | None, reader: EntryReader) -> tuple[np.ndarray | None, float | None]:
        """Divide the glow of the ground by its luminance; return it and the luminance that it had."""
        if spectrum is None or not np.any(spectrum):
            return None, None
        entry = reader.sums[GLOW].entry
        candelas = reader.sums[GLOW].luminance
        if not candelas > 0.0:
            message = f"its luminance is {candelas:g} cd/m2, so it cannot be scaled to 1 cd/m2"
            advice = "give a table with light between 380 and 780 nm"
            self.report.at(entry.value_span, "E409", message, name=GLOW, advice=advice)
            return None, None
        if abs(candelas - 1.0) > 0.01:
            message = f"its luminance is {candelas:.6g} cd/m2, not 1; it is divided by that"
            advice = "scale it to 1 cd/m2"
            self.report.at(entry.value_span, "E409", message, name=GLOW, advice=advice, is_warning=True)
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
class Sum:
    """A spectrum while it is read."""

    entry: Entry  #: Where it begins
    values: np.ndarray | None = None  #: Of its parts so far, on the wavelengths of the file
    luminance: float = 0.0  #: That of a glow; 0 for other spectra, and for one number, which has no bins. [cd m-2]
    is_weighted: bool = False  #: A weighted file is among them
    is_bad: bool = False  #: A part was refused


@dataclass(kw_only=True, slots=True)
class EntryReader:
    """Reads the entries of one level."""

    builder: Builder
    keys: Mapping[str, Rule]  #: The keys of this level
    values: dict[str, Any] = field(default_factory=dict)  #: Good values so far; spectra arrive with `finish`
    sums: dict[str, Sum] = field(default_factory=dict)
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
                self.builder.report.bad_value(entry.value_span, problem, name=entry.key)
        self.seen.add(entry.key)

    def finish(self) -> dict[str, Any]:
        """All good values, spectra summed up and checked."""
        for key, total in self.sums.items():
            rule = self.keys[key]
            assert isinstance(rule, Spectral), "sums are spectra"
            values = total.values
            if total.is_bad or values is None:
                continue
            bad = np.flatnonzero(~((values >= 0.0) & (values <= rule.high)))
            values.flags.writeable = False
            if not bad.size:
                self.values[key] = values
                continue
            assert self.builder.wavelength_nm is not None, "there are values"
            shown = f"{values[bad[0]]:.9g} at {self.builder.wavelength_nm[bad[0]]:g} nm"
            self.builder.report.bad_value(total.entry.value_span, out_of_range(shown, rule), name=total.entry.key)
        return self.values

    def require(self, head: Entry | None) -> list[str]:
        """Report required keys that stand nowhere, at the section's head, or at the key that each was mistaken for."""
        report, required = self.builder.report, [key for key in EXAMPLES if key in self.keys]
        for key in required:
            advice = f"write {EXAMPLES[key]}"
            if key in self.seen or key in self.builder.spoilt:
                continue
            if key in self.unknown:
                entry = self.unknown[key]
                message = f"{quoted(key)} is missing; found {quoted(entry.key)}"
                report.at(entry.key_span, "E405", message, advice=advice)
            elif head is None:
                report.add("E405", f"the entry {quoted(key)} is missing", advice=advice)
            else:
                message = f"the entry {quoted(key)} is missing in this section"
                report.at(head.key_span, "E405", message, advice=advice)
        return required

    def _repeated(self, entry: Entry) -> bool:
        """Report that a key stands twice; whether the new value counts."""
        keeps = "first" if entry.key in _FIRST_WINS else "last"
        message = f"is given twice; the {keeps} value is used"
        self.builder.report.at(entry.value_span, "E405", message, name=entry.key, advice="keep one", is_warning=True)
        return keeps == "last"

    def _single(self, entry: Entry, rule: Code | Callable[[str], Any]) -> None:
        is_range = entry.key == WAVELENGTHS
        self.builder.has_wavelengths |= is_range
        if not isinstance(rule, Code):
            value: Any = rule(entry.value)
        elif entry.code is None:
            self._require_wavelengths("a table")
            value = self.builder.spectra.phase_table(entry.value, self.builder.wavelength_nm)
        else:
            value = entry.code
        if is_range:
            self.builder.wavelength_nm = value
        if value is not None:
            self.values[entry.key] = value

    def _require_wavelengths(self, what: str) -> None:
        if not self.builder.has_wavelengths:
            raise BadValueError("E405", f"{what} before the wavelengths", advice="write wavelengths: above it")

    def _spectrum(self, entry: Entry, rule: Spectral) -> None:
        """Read one entry of a spectrum: a new one, or a weighted part that is added."""
        self._require_wavelengths("a spectrum")
        is_weighted = entry.value.startswith("weighted file")
        total = self.sums.get(entry.key)
        if total is not None and not is_weighted:
            if total.is_weighted:
                message = "a spectrum after weighted files of the same key"
                raise BadValueError("E405", message, advice="write weighted file 1, or remove one")
            if not self._repeated(entry):
                return
            total = None
        if total is None:
            total = self.sums[entry.key] = Sum(entry=entry)
        total.is_weighted |= is_weighted
        was_bad, total.is_bad = total.is_bad, True
        term = self.builder.spectra.term(entry.value, rule, self.builder.wavelength_nm)
        if term is not None:
            total.values = term[0] + (0.0 if total.values is None else total.values)
            total.luminance += term[1]
            total.is_bad = was_bad

    def _unknown(self, entry: Entry) -> None:
        if len(self.builder.report.problems) >= MAX_PROBLEMS:
            return  # enough is reported, and to look for the nearest key takes time
        best = nearest(entry.key, self.keys)
        self.unknown[best] = entry
        message = f"there is no key {quoted(entry.key)}; the nearest is '{best}'"
        self.builder.report.at(entry.key_span, "E401", message, advice="it is not read", is_warning=True)
