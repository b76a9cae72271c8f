"""Spectra of a description file: lists of numbers, tables in other files, weighted sums of such; and phase tables."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np

from aomc_sky.errors import InputFileError, Problem
from aomc_sky.formats.radiance_words import doubt_of_gaps
from aomc_sky.formats.report import BadValueError, Gathered, Report, outside, quoted
from aomc_sky.formats.spectrum_csv import MAX_VALUE, Spectrum, bin_means, numbers, read_rows, read_spectrum_csv
from aomc_sky.formats.units import parse_real
from aomc_sky.skies.atmosphere.description.keys import HIGHEST_NM, LOWEST_NM, Spectral
from aomc_sky.skies.atmosphere.description.scan import names_file
from aomc_sky.skies.atmosphere.phase_table import PhaseTable
from aomc_sky.system import regular_status

MAX_FILES = 64
MAX_TOTAL_BYTES = 2**23
"""Of all tables together."""
MAX_REFERENCES = 1024

_NOISE = 1e-3  #: Measured cross sections have noise around 0, this share of the largest at most.
_SAY_GAPS = "leave out the rows of gaps"
_END = 70  #: Characters that are quoted of the begin, and of the end, of the comments of a table.
_WEIGHTED = re.compile(r"(weighted file\s+)(\S+)\s+(.*)\Z", re.DOTALL)


Term = tuple[np.ndarray, float]
"""What a list or a table adds to a spectrum, and to its luminance: 0 for what is no glow, or has no bins. [cd m-2]"""


def is_weighted(value: str) -> bool:
    """Whether a value is ``weighted file WEIGHT PATH``."""
    return value.startswith("weighted file")


@dataclass(kw_only=True, slots=True)
class SpectrumReader:
    """Reads the spectra of one description, every table once."""

    path: str  #: Of the description
    allow_paths: Sequence[str | Path] = ()  #: Folders beside its own, below which tables may lie
    has_wavelengths: bool = False  #: They were there, good or bad
    wavelength_nm: np.ndarray | None = None  #: Those of the description, once they are read. [nm]
    problems: list[Problem] = field(default_factory=list)  #: Gets what is wrong inside the tables
    said: dict[str, str] = field(default_factory=dict)  #: Comments above the rows of tables, by their names
    _tables: dict[str, Spectrum | None] = field(default_factory=dict)
    _means: dict[str, np.ndarray] = field(default_factory=dict)
    _n_tables: int = 0
    _n_bytes: int = 0
    _n_references: int = 0

    def term(self, text: str, rule: Spectral) -> Term | None:
        """Read ``0.1, 0.2``, ``file PATH`` or ``weighted file WEIGHT PATH``: values on the wavelengths, and luminance.

        A bad table is reported and gives None.
        Without wavelengths, because they could not be read, only the text is checked.
        """
        if names_file(text):
            name = text[4:].strip()
            return self._from_file(name, len(text) - len(name), 1.0, rule)
        if is_weighted(text):
            match = _WEIGHTED.match(text)
            if match is None:
                raise BadValueError(
                    "E401", "a weight and a path are expected", advice="write weighted file 0.8 grass.csv"
                )
            weight = parse_real(match[2], offset=match.start(2))
            if not abs(weight) <= MAX_VALUE:
                message, advice = f"weight {quoted(match[2])} is too large", f"write -{MAX_VALUE:g} to {MAX_VALUE:g}"
                raise BadValueError("E404", message, advice=advice, offset=match.start(2), width=len(match[2]))
            return self._from_file(match[3], match.start(3), weight, rule)
        values, wavelength_nm = _listed(text, rule), self.wavelength_nm
        if wavelength_nm is None:
            return None
        if len(values) != len(wavelength_nm):
            message = f"{len(values)} number{'s' * (len(values) != 1)} for {len(wavelength_nm)} wavelengths"
            raise BadValueError("E408", message, advice="write one for each wavelength, or name a file")
        listed = np.array(values, np.float64)
        if not rule.is_glow or len(values) == 1:
            return listed, 0.0
        # the numbers are means over their bins: a stair, its outer bins whole
        half = (wavelength_nm[-1] - wavelength_nm[0]) / (len(values) - 1) / 2.0
        edges = np.append(wavelength_nm - half, wavelength_nm[-1] + half)
        return listed, luminance(np.repeat(edges, 2)[1:-1], np.repeat(listed, 2))

    def _from_file(self, name: str, offset: int, weight: float, rule: Spectral) -> Term | None:
        try:
            shown, real = self._found(name)
            table = self._table(shown, real)
            if table is None or self.wavelength_nm is None:
                return None
            if text := " ".join(" ".join(table.head).split()):
                self.said[name] = f"{name}: {_both_ends(text)}"
            if doubt := doubt_of_gaps([table.value]):
                message = f"{quoted(name)}: {doubt[0].replace('radiance', 'value')}"
                raise BadValueError("E404", message, advice=_SAY_GAPS)
            if (least := table.value.min()) < -_NOISE * table.value.max():
                raise BadValueError("E404", f"{quoted(name)}: {least:g} is below 0", advice=_SAY_GAPS)
            _check_cover(name, table.wavelength_nm, self.wavelength_nm)
        except BadValueError as problem:
            problem.offset, problem.width = offset, max(len(name), 1)
            raise
        if real not in self._means:
            self._means[real] = bin_means(table, self.wavelength_nm)
        glow = weight * luminance(table.wavelength_nm, table.value) if rule.is_glow else 0.0
        return weight * self._means[real], glow

    def phase_table(self, text: str) -> PhaseTable | None:
        """Read ``file PATH`` of a phase function; a bad table is reported and gives None."""
        name = text[4:].strip()
        try:
            shown, real = self._found(name)
            self._count(real)
            try:
                table = read_phase_csv(real, shown=shown, text=f"file {name}")
            except InputFileError as error:
                self.problems.extend(error.problems)
                return None
            if table.wavelength_nm.size > 1 and self.wavelength_nm is not None:
                _check_cover(name, table.wavelength_nm, self.wavelength_nm)
        except BadValueError as problem:
            problem.offset, problem.width = len(text) - len(name), max(len(name), 1)
            raise
        return table

    def _found(self, name: str) -> tuple[str, str]:
        """Path for messages and path to open of a table, which is named once more."""
        if not name:
            raise BadValueError("E401", "the path is missing", advice="write file table.csv")
        found = referenced_file(name, self.path, self.allow_paths)
        self._n_references += 1
        if self._n_references > MAX_REFERENCES:
            raise BadValueError("E402", f"more than {MAX_REFERENCES} names of tables", advice="name fewer")
        return found

    def _count(self, real: str) -> None:
        """Count a table that will be read."""
        self._n_tables += 1
        self._n_bytes += os.stat(real).st_size
        if self._n_tables > MAX_FILES or self._n_bytes > MAX_TOTAL_BYTES:
            message = f"more than {MAX_FILES} tables, or {MAX_TOTAL_BYTES} bytes of them"
            raise BadValueError("E402", message, advice="name fewer or smaller files")

    def _table(self, shown: str, real: str) -> Spectrum | None:
        """Read a table, or take it from those that were read; a bad one is reported and gives None."""
        if real in self._tables:
            return self._tables[real]
        self._count(real)
        try:
            # the path that was checked, without links; the user sees the one of the file
            self._tables[real] = read_spectrum_csv(real)
        except InputFileError as error:
            self.problems.extend(replace(problem, path=shown) for problem in error.problems)
            self._tables[real] = None
        return self._tables[real]


def _listed(text: str, rule: Spectral) -> list[float]:
    """Numbers of a list, each inside the range of its key."""
    values, offset, gathered = [], 0, Gathered()
    for item in text.split(","):
        start = offset + len(item) - len(item.lstrip())
        value = gathered.attempt(partial(_listed_number, item.strip(), start, rule))
        values.append(math.nan if value is None else value)
        offset += len(item) + 1
        if gathered.is_full:
            break
    gathered.close()
    return values


def _listed_number(text: str, offset: int, rule: Spectral) -> float:
    value = parse_real(text, offset=offset)
    if not 0.0 <= value <= rule.high:
        raise out_of_range(text, rule, offset=offset, width=len(text))
    return value


def out_of_range(shown: str, rule: Spectral, *, offset: int = 0, width: int = 0) -> BadValueError:
    """Return the problem of a value of a spectrum that lies outside its range."""
    limits = f"0 to {rule.high:g}{' ' if rule.unit else ''}{rule.unit}"
    return outside(shown, limits, offset=offset, width=width)


def _both_ends(text: str) -> str:
    """A text with its middle left out where it is long: a unit often stands in the line above the rows."""
    return text if len(text) <= 2 * _END else f"{text[:_END]} ... {text[-_END:]}"


def _check_cover(name: str, known_nm: np.ndarray, wavelength_nm: np.ndarray) -> None:
    low, high = known_nm[0], known_nm[-1]
    if wavelength_nm[0] < low or wavelength_nm[-1] > high:
        needed = f"{wavelength_nm[0]:g} to {wavelength_nm[-1]:g} nm"
        message = f"{quoted(name)} has data from {low:g} to {high:g} nm; the wavelengths go from {needed}"
        advice = "name a table that covers them, or narrow the wavelengths"
        for factor, unit in ((1e3, "micrometres"), (0.1, "angstroms")):
            if low * factor <= wavelength_nm[0] and wavelength_nm[-1] <= high * factor:
                advice = f"write wavelengths in nm: are these {unit}?"
        raise BadValueError("E408", message, advice=advice)


def referenced_file(name: str, owner: str | Path, allow_paths: Sequence[str | Path] = ()) -> tuple[str, str]:
    """Path for messages, and real path, of a file that `owner` names from its own folder.

    It must lie below that folder or below one of `allow_paths`, with all links followed; otherwise E402.
    """
    folder = os.path.dirname(os.fspath(owner))
    shown = os.path.join(folder, name)
    try:
        real = os.path.realpath(shown)
        roots = [os.path.realpath(root) for root in (folder or ".", *allow_paths)]
        if not any(os.path.commonpath((root, real)) == root for root in roots):
            advice = "move the file there, or give --allow-path DIR"
            raise BadValueError("E402", f"{quoted(name)} is not below the folder of this file", advice=advice)
        regular_status(real)
    except FileNotFoundError:
        raise BadValueError(
            "E402", f"there is no file {quoted(name)}", advice="paths are relative to the folder of this file"
        ) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise BadValueError("E402", f"{quoted(name)} cannot be read: {reason}", advice="name a readable file") from None
    if os.path.samefile(real, owner):
        raise BadValueError(
            "E402", f"{quoted(name)} is this file itself", advice="name a table of wavelength and value"
        )
    return shown, real


MAX_ANGLES = 2**14
MAX_COLUMNS = 256
_HEAD = "write angle, 400, 550, 700 above the numbers: the wavelengths in nm"


def read_phase_csv(path: str, *, shown: str, text: str) -> PhaseTable:
    """Read a table of angle [deg] and value, with a row of wavelengths where there are several columns of values.

    InputFileError with every problem: E401 form or order, E404 range, E408 angles that do not go from 0 to 180.
    """
    report = Report(path=shown)
    wavelength: list[float] = []  # 0 for a table without a head

    def row_of(cells: list[str]) -> list[float] | None:
        if cells[0].split()[:1] == ["angle"] and not wavelength:
            wavelength.extend(_wavelengths(cells))
            return None
        wavelength.extend([] if wavelength else [0.0])
        _check_width(cells, len(wavelength), has_head=wavelength != [0.0])
        return numbers(cells, (0.0, 180.0), (0.0, MAX_VALUE))

    rows = read_rows(path, report, row_of, ("angle", "angle in degrees, value"), MAX_ANGLES)
    if not report.has_errors and (rows[0][0] != 0.0 or rows[-1][0] != 180.0):
        message = f"the angles go from {rows[0][0]:g} to {rows[-1][0]:g} degrees"
        report.add("E408", message, advice="write rows from 0, straight on, to 180, straight back")
    elif not report.has_errors and not all(any(row[k] for row in rows) for k in range(1, len(rows[0]))):
        report.add("E404", "a column of zeros, which cannot be normalised", advice="write one that scatters some light")
    report.close()
    table = np.array(rows, np.float64)
    table.flags.writeable = False
    known = np.array(wavelength, np.float64)
    return PhaseTable(path=shown, text=text, angle_deg=table[:, 0], wavelength_nm=known, value=table[:, 1:].T)


def _wavelengths(cells: list[str]) -> list[float]:
    if not 2 <= len(cells) <= MAX_COLUMNS + 1:
        raise BadValueError("E401", f"{len(cells) - 1} wavelengths after the word angle", advice=_HEAD)
    limits = (LOWEST_NM, HIGHEST_NM)
    values = numbers(cells[1:], limits, limits, len(cells[0]) + 1)
    if any(not low < high for low, high in pairwise(values)):
        raise BadValueError("E401", "the wavelengths do not rise", advice="sort the columns")
    return values


def _check_width(cells: list[str], n_column: int, *, has_head: bool) -> None:
    if len(cells) == n_column + 1:
        return
    advice = "write angle in degrees, comma, value"
    if has_head:
        advice = "write the angle and one value for each wavelength"
    elif len(cells) > 2:
        advice = _HEAD
    message = f"a row of {len(cells)} column{'s' * (len(cells) != 1)} where {n_column + 1} are expected"
    raise BadValueError("E401", message, advice=advice)


# The photopic luminous efficiency V(wavelength), which the unit cd/m2 needs: CIE 1924, in steps of 5 nm, as
# CIE 018:2019 and ISO/CIE 23539 print it. Between its points V is linear here, outside it is 0.
LUMINOUS_EFFICACY_LM_W = 683.0
"""Luminous efficacy at 540 THz. [lm W-1, exact in the SI; Km of V differs from it by less than 2e-5]"""

FIRST_NM = 380
STEP_NM = 5
V_E7 = (
    390, 640, 1200, 2170, 3960, 6400, 12100, 21800, 40000, 73000, 116000, 168400, 230000, 298000, 380000, 480000,
    600000, 739000, 909800, 1126000, 1390200, 1693000, 2080200, 2586000, 3230000, 4073000, 5030000, 6082000, 7100000,
    7932000, 8620000, 9148500, 9540000, 9803000, 9949500, 10000000, 9950000, 9786000, 9520000, 9154000, 8700000,
    8163000, 7570000, 6949000, 6310000, 5668000, 5030000, 4412000, 3810000, 3210000, 2650000, 2170000, 1750000,
    1382000, 1070000, 816000, 610000, 445800, 320000, 232000, 170000, 119200, 82100, 57230, 41020, 29290, 20910, 14840,
    10470, 7400, 5200, 3611, 2492, 1719, 1200, 848, 600, 424, 300, 212, 150,
)  # fmt: skip
"""V at 380, 385 ... 780 nm. [1e-7]"""


def photopic_efficiency() -> tuple[np.ndarray, np.ndarray]:
    """Return wavelengths [nm] and V, float64, shape (81,)."""
    wavelength = np.arange(FIRST_NM, FIRST_NM + STEP_NM * len(V_E7), STEP_NM, dtype=np.float64)
    return wavelength, np.array(V_E7, np.float64) / 1e7


def luminance(wavelength_nm: np.ndarray, radiance: np.ndarray) -> float:
    """Luminance of a spectrum that is linear between its points and zero outside. [W m-2 sr-1 nm-1 to cd m-2]

    A wavelength that stands twice is a step. A flat spectrum is within 1e-6 of V in steps of 1 nm, a sharp line within
    2 % above 425 nm and 7 % below.
    """
    grid, v = photopic_efficiency()
    seen = wavelength_nm[(wavelength_nm > grid[0]) & (wavelength_nm < grid[-1])]
    low, high = max(wavelength_nm[0], grid[0]), min(wavelength_nm[-1], grid[-1])
    if not low < high:
        return 0.0
    inside = grid[(grid > low) & (grid < high)]
    x = np.unique(np.concatenate(([low], seen, inside, [high])))
    left, right = x[:-1], x[1:]
    # the segment is found by the middle, so that a step belongs to neither side
    k = np.searchsorted(wavelength_nm, 0.5 * (left + right)) - 1
    slope = (radiance[k + 1] - radiance[k]) / (wavelength_nm[k + 1] - wavelength_nm[k])
    y0, y1 = (radiance[k] + (end - wavelength_nm[k]) * slope for end in (left, right))
    v0, v1 = np.interp(left, grid, v), np.interp(right, grid, v)
    # Simpson's rule is exact for the product of two linear functions
    pieces = (right - left) * (v0 * y0 + (v0 + v1) * (y0 + y1) + v1 * y1) / 6.0
    return LUMINOUS_EFFICACY_LM_W * math.fsum(pieces.tolist())
