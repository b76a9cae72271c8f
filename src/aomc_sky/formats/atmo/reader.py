"""Atmosphere descriptions (``.atmo``), the format of CalcMySky: all of it read and checked, no code evaluated."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from aomc_sky.formats.atmo.data import (
    AbsorberDescription,
    AtmosphereDescription,
    PhaseFunctionType,
    ScattererDescription,
)
from aomc_sky.formats.atmo.entries import EntryReader, Shared
from aomc_sky.formats.atmo.keys import (
    ALBEDO,
    DIRECTIVES,
    GLOW,
    REQUIRED,
    SCATTERER_DIRECTIVE,
    SECTION_KEYS,
    SIZES,
    SOLAR,
    TOP_KEYS,
)
from aomc_sky.formats.atmo.scan import Entry, Lines, Section, scan
from aomc_sky.formats.atmo.spectra import SpectrumReader
from aomc_sky.formats.report import Report, quoted
from aomc_sky.formats.text_file import read_bytes, refuse
from aomc_sky.formats.units import AU_M

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
    """
    size = os.stat(path).st_size if os.path.isfile(path) else 0
    if size > MAX_BYTES:
        raise refuse(path, f"the file has {size} bytes; at most {MAX_BYTES} are read", code="E401")
    text = read_bytes(path).decode("utf-8", "surrogateescape")
    lines = [line.removesuffix("\r") for line in text.split("\n")]
    report = Report(path=str(path))
    spectra = SpectrumReader(path=str(path), allow_paths=allow_paths)
    file = Lines(lines=lines, report=report)
    description = Builder(shared=Shared(report=report, spoilt=file.spoilt, spectra=spectra)).description(scan(file))
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

    shared: Shared
    names: set[str] = field(default_factory=set)

    def description(self, items: Sequence[Entry | Section]) -> AtmosphereDescription | None:
        """Return the description, or None where a problem has been reported."""
        report = self.shared.report
        self._check_first(items)
        reader = EntryReader(shared=self.shared, keys=TOP_KEYS)
        species = []
        for item in items:
            if report.is_full:
                return None
            if isinstance(item, Entry):
                reader.read(item)
            else:
                species.append(self._species(item))
        values = reader.finish()
        for key in REQUIRED[""]:
            reader.require(key, None)
        if not any(isinstance(item, Section) and item.kind == "scatterer" for item in items):
            report.add("E407", "there is no scatterer", advice='add a section Scatterer "molecules":')
        if report.has_errors or self.shared.spectra.problems:
            return None
        return self._assembled(values, reader, tuple(part for part in species if part is not None))

    def _assembled(
        self, values: dict[str, Any], reader: EntryReader, species: tuple[Species, ...]
    ) -> AtmosphereDescription | None:
        """Put values without errors together."""
        report, wavelength = self.shared.report, self.shared.wavelength_nm
        assert wavelength is not None, "no errors"
        if ALBEDO not in values:
            message = "there is no ground albedo; a white ground is assumed"
            report.add("E405", message, advice="write ground albedo: file grass.csv", is_warning=True)
        if "earth-sun distance" not in values:
            message = "there is no Earth-Sun distance; 1 AU is assumed"
            report.add("E405", message, advice="write Earth-Sun distance: 1 AU", is_warning=True)
        glow, found = self._glow(values.get(GLOW), reader)
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
            glow_luminance_cd_m2=found,
            species=species,
            sizes=MappingProxyType({key: values[key] for key in SIZES if key in values}),
            textures_are_radiances=DIRECTIVES[0] in reader.directives,
            has_eclipsed_double_scattering_textures=DIRECTIVES[1] not in reader.directives,
        )

    def _check_first(self, items: Sequence[Entry | Section]) -> None:
        if not items:
            self.shared.report.add("E405", "the file has no entries", advice="begin with version: 6")
            return
        first = items[0].head if isinstance(items[0], Section) else items[0]
        if first.key != "version":
            message = "the first entry is not the version"
            self.shared.report.at(first.key_span, "E405", message, advice="write version: 6 above it")

    def _species(self, section: Section) -> Species | None:
        """Read a section."""
        self._check_name(section)
        reader = EntryReader(shared=self.shared, keys=SECTION_KEYS[section.kind])
        for entry in section.entries:
            reader.read(entry)
        values = reader.finish()
        for key in REQUIRED[section.kind] if section.is_whole else ():
            reader.require(key, section.head)
        if any(key not in values for key in REQUIRED[section.kind]) or self.shared.wavelength_nm is None:
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
            single_scattering_albedo=values.get("single scattering albedo", _ones(self.shared.wavelength_nm)),
            phase_function_type=PhaseFunctionType(values.get("phase function type", "general")),
            needs_interpolation_guides=SCATTERER_DIRECTIVE in reader.directives,
        )

    def _check_name(self, section: Section) -> None:
        message = ""
        if section.name and not _NAME.match(section.name):
            message = f"the name {quoted(section.name)} has other characters than letters, digits and underscores"
        elif section.name in self.names:
            message = f"a second species of the name {quoted(section.name)}; capitals do not count"
        elif len(self.names) >= MAX_SPECIES:
            message = f"more than {MAX_SPECIES} species"
        if message:
            self.shared.report.at(section.head.key_span, "E407", message, advice="rename or remove it")
        if section.name:
            self.names.add(section.name)

    def _glow(self, spectrum: np.ndarray | None, reader: EntryReader) -> tuple[np.ndarray | None, float | None]:
        """Divide the glow of the ground by its luminance; return it and the luminance that it had."""
        if spectrum is None or not np.any(spectrum):
            return None, None
        entry = reader.sums[GLOW].entry
        found = sum(term.luminance for term in reader.sums[GLOW].terms)
        if not found > 0.0:
            message = f"its luminance is {found:g} cd/m2, so it cannot be scaled to 1 cd/m2"
            advice = "give a table with light between 380 and 780 nm"
            self.shared.report.at(entry.value_span, "E409", message, name=GLOW, advice=advice)
            return None, None
        if abs(found - 1.0) > 0.01:
            message = f"its luminance is {found:.6g} cd/m2, not 1; it is divided by that"
            advice = "scale it to 1 cd/m2"
            self.shared.report.at(entry.value_span, "E409", message, name=GLOW, advice=advice, is_warning=True)
        scaled = spectrum / found
        scaled.flags.writeable = False
        return scaled, found


def _ones(wavelength_nm: np.ndarray) -> np.ndarray:
    ones = np.ones(len(wavelength_nm))
    ones.flags.writeable = False
    return ones
