"""Entries of one level of a description file, the file itself or a section, read to values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from aomc_sky.formats.atmo.keys import (
    DIRECTIVES,
    EXAMPLES,
    SCATTERER_DIRECTIVE,
    SOLAR,
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
from aomc_sky.formats.atmo.lines import Entry, Lines
from aomc_sky.formats.atmo.spectra import SpectrumReader, Term, out_of_range
from aomc_sky.formats.atmo.values import (
    quantity_value,
    real_value,
    size_value,
    version_value,
    wavelength_values,
    word_value,
)
from aomc_sky.formats.bad_value import BadValueError, quoted
from aomc_sky.formats.sky_toml.keys import nearest
from aomc_sky.formats.text_file import MAX_PROBLEMS

_FIRST_WINS = (WAVELENGTHS, SOLAR)
"""The tool writes these two in front of its copy of a file, so the first one counts."""


@dataclass(kw_only=True, slots=True)
class Sum:
    """A spectrum while it is read.

    Parameters
    ----------
    entry : Entry
        Where it begins.
    terms : list of Term
        Its parts so far.
    is_weighted : bool
        A weighted file is among them.
    is_bad : bool
        A part was refused.
    """

    entry: Entry
    terms: list[Term] = field(default_factory=list)
    is_weighted: bool = False
    is_bad: bool = False


@dataclass(kw_only=True, slots=True)
class Shared:
    """What all levels of a file have in common.

    Parameters
    ----------
    lines : Lines
        Where problems are told.
    spectra : SpectrumReader
        Reads spectra.
    wavelength_nm : ndarray or None
        The wavelengths of the file, once they are read. [nm]
    has_wavelengths : bool
        They were there, good or bad.
    """

    lines: Lines
    spectra: SpectrumReader
    wavelength_nm: np.ndarray | None = None
    has_wavelengths: bool = False


@dataclass(kw_only=True, slots=True)
class EntryReader:
    """Reads the entries of one level.

    Parameters
    ----------
    shared : Shared
        Of the file.
    keys : mapping of str to Rule
        What may stand in this level.
    values : dict
        Good values so far; spectra arrive with `finish`.
    sums : dict of str to Sum
        Spectra.
    seen : set of str
        Keys that stood there, good or bad.
    unknown : dict of str to Entry
        Entries of unknown keys by the known key that is most like theirs.
    directives : set of str
        Directives that stood there.
    """

    shared: Shared
    keys: Mapping[str, Rule]
    values: dict[str, Any] = field(default_factory=dict)
    sums: dict[str, Sum] = field(default_factory=dict)
    seen: set[str] = field(default_factory=set)
    unknown: dict[str, Entry] = field(default_factory=dict)
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
            elif entry.key not in self.seen or self._repeated(entry):
                self._single(entry, rule)
        except BadValueError as first:
            for problem in (first, *first.more):
                self.shared.lines.value_problem(entry, problem)
        self.seen.add(entry.key)

    def finish(self) -> dict[str, Any]:
        """All good values, spectra summed up and checked."""
        for key, total in self.sums.items():
            rule = self.keys[key]
            assert isinstance(rule, Spectral), "sums are spectra"
            if total.is_bad or not total.terms:
                continue
            values = np.sum([term.values for term in total.terms], axis=0)
            bad = np.flatnonzero(~((values >= 0.0) & (values <= rule.high)))
            values.flags.writeable = False
            if not bad.size:
                self.values[key] = values
                continue
            assert self.shared.wavelength_nm is not None, "a term has values"
            shown = f"{values[bad[0]]:.9g} at {self.shared.wavelength_nm[bad[0]]:g} nm"
            self.shared.lines.value_problem(total.entry, out_of_range(shown, rule))
        return self.values

    def require(self, key: str, head: Entry | None) -> None:
        """Report a required key that stands nowhere, at the section's head, or at the key that it was mistaken for."""
        lines, advice = self.shared.lines, f"write {EXAMPLES[key]}"
        if key in self.seen or key in lines.spoilt:
            return
        if key in self.unknown:
            entry = self.unknown[key]
            message = f"{quoted(entry.key)} where {quoted(key)} is missing"
            lines.key_problem(entry, "E405", message, advice=advice)
        elif head is None:
            lines.report.add("E405", f"the entry {quoted(key)} is missing", advice=advice)
        else:
            lines.key_problem(head, "E405", f"the entry {quoted(key)} is missing in this section", advice=advice)

    def _repeated(self, entry: Entry) -> bool:
        """Tell that a key stands twice; whether the new value counts."""
        keeps = "first" if entry.key in _FIRST_WINS else "last"
        problem = BadValueError("E405", f"stands a second time; the {keeps} one counts", advice="keep one")
        self.shared.lines.value_problem(entry, problem, is_warning=True)
        return keeps == "last"

    def _single(self, entry: Entry, rule: Rule) -> None:
        text = entry.value
        match rule:
            case Code():
                value: Any = entry.code
            case Quantity():
                value = quantity_value(text, rule)
                self._check_document(entry, value, rule)
            case Real():
                value = real_value(text, rule)
            case Integer():
                value = size_value(text, rule)
            case Word():
                value = word_value(text, rule)
            case Version():
                value = version_value(text)
            case _:
                self.shared.has_wavelengths = True
                value = self.shared.wavelength_nm = wavelength_values(text)
        if value is not None:
            self.values[entry.key] = value

    def _check_document(self, entry: Entry, value: float, rule: Quantity) -> None:
        if rule.document_low is not None and value < rule.document_low:
            message = f"{quoted(entry.value)} is below the 100 km that the document of the format allows"
            problem = BadValueError("E404", message, advice="the tool itself takes it")
            self.shared.lines.value_problem(entry, problem, is_warning=True)

    def _spectrum(self, entry: Entry, rule: Spectral) -> None:
        """Read one entry of a spectrum: a new one, or a weighted part that is added."""
        if not self.shared.has_wavelengths:
            raise BadValueError("E405", "a spectrum above the wavelengths", advice="write wavelengths: further up")
        is_weighted = entry.value.startswith("weighted file")
        total = self.sums.get(entry.key)
        if total is not None and not is_weighted:
            if total.is_weighted:
                message = "a whole spectrum below weighted files of the same key"
                raise BadValueError("E405", message, advice="write weighted file 1, or remove one")
            if not self._repeated(entry):
                return
            total = None
        if total is None:
            total = self.sums[entry.key] = Sum(entry=entry)
        total.is_weighted |= is_weighted
        was_bad, total.is_bad = total.is_bad, True
        term = self.shared.spectra.term(entry.value, rule, self.shared.wavelength_nm)
        if term is not None:
            total.terms.append(term)
            total.is_bad = was_bad

    def _unknown(self, entry: Entry) -> None:
        if len(self.shared.lines.report.problems) >= MAX_PROBLEMS:
            return  # enough is told, and to look for the nearest key takes time
        best = nearest(entry.key, self.keys)
        self.unknown[best] = entry
        message = f"there is no key {quoted(entry.key)}; the nearest is '{best}'"
        self.shared.lines.key_problem(entry, "E401", message, advice="it is not read", is_warning=True)
