"""Measured radiances of the sky as a table of text: one row for each direction, in the words that people use."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aomc_sky.directions import AzimuthConvention, azimuth_from_sun_deg, to_enu_azimuth_deg
from aomc_sky.errors import Span, UsageError
from aomc_sky.formats.radiance_words import (
    CONVENTIONS,
    GAP_NUMBERS,
    GAPS,
    KEYS,
    Name,
    angle_degrees,
    convention_of,
    length_nm,
    name_of_column,
    radiance_factor,
)
from aomc_sky.formats.report import MAX_PER_VALUE, BadValueError, Report, printable, quoted
from aomc_sky.formats.text_file import read_bytes
from aomc_sky.formats.units import parse_real

MAX_BYTES = 2**27
MAX_VALUE = 1e30
_DIGITS = 10  #: Of a degree: radians become the degrees that they were.
_OTHER = {"elevation": "zenith", "relative azimuth": "azimuth"}
"""Columns in the place of others."""

_SAY_AZIMUTH = (
    f"write --azimuth-convention {'|'.join(CONVENTIONS)} (azimuth_convention=), or a line '# azimuth: clockwise from "
    "north', '# azimuth: from the sun'"
)
_SAY_ANGLE = "write --angle-unit deg or rad (angle_unit=), or a line '# angle unit: deg', or name the column zenith_deg"
_SAY_SUN = (
    "write --sun-azimuth DEG, from east towards north (sun_azimuth_deg=), or a line '# sun azimuth: 225 clockwise from "
    "north'"
)
_SAY_UNIT = (
    "write --radiance-unit 'W m-2 nm-1 sr-1' (radiance_unit=), or a line '# radiance unit: mW m-2 nm-1 sr-1', or "
    "relative"
)
_DELIMITERS = {",": "commas", ";": "semicolons", "\t": "tabs"}
_NEEDED = {
    "zenith": "name it 'zenith (deg)' or 'elevation (deg)'",
    "azimuth": "name it 'azimuth (deg)'",
    "radiance": "name it 'radiance', or 'L_412' and so on for each wavelength",
}


@dataclass(frozen=True, kw_only=True, slots=True)
class RadiancePoints:
    """Radiances of directions as a file has them, NaN where there is a gap."""

    zenith_deg: np.ndarray  #: (n,); negative: beyond the zenith
    azimuth_deg: np.ndarray  #: (n,), from +x towards +y
    wavelength_nm: np.ndarray | None  #: (n,)
    radiance: np.ndarray  #: (n,), in W m-2 nm-1 sr-1 where `is_absolute`
    is_absolute: bool
    sun_zenith_deg: float | None
    sun_azimuth_deg: float | None  #: from +x towards +y
    remarks: tuple[str, ...]


@dataclass(slots=True)
class _Column:
    """One column that is used."""

    name: Name
    index: int
    span: Span
    values: np.ndarray = None  # type: ignore[assignment]


def read_radiance_points(
    path: str | Path,
    *,
    azimuth_convention: AzimuthConvention | str | None = None,
    angle_unit: str | None = None,
    radiance_unit: str | None = None,
    sun_zenith_deg: float | None = None,
    sun_azimuth_deg: float | None = None,
) -> RadiancePoints:
    """Read a table; what is given wins over the file. InputFileError: every problem of the file (E651 to E654)."""
    convention = azimuth_convention
    if isinstance(convention, AzimuthConvention):
        convention = convention.name.lower()
    if convention is not None and convention not in CONVENTIONS:
        raise UsageError(f"azimuth_convention must be one of {', '.join(map(repr, CONVENTIONS))}, got {convention!r}")
    if angle_unit not in (None, "deg", "rad"):
        raise UsageError(f"angle_unit must be 'deg' or 'rad', got {angle_unit!r}")
    if radiance_unit is not None and radiance_factor(radiance_unit) is None:
        raise UsageError(
            f"radiance unit {radiance_unit!r} is not known; write 'W m-2 nm-1 sr-1', its like, or 'relative'"
        )
    given = {"azimuth": convention, "angle": angle_unit, "radiance": radiance_unit}
    given |= {"sun_zenith": sun_zenith_deg, "sun_azimuth": sun_azimuth_deg}  # type: ignore[dict-item]
    return _Table(path, {name: value for name, value in given.items() if value is not None}).points()


class _Table:
    """A file while it is read."""

    def __init__(self, path: str | Path, given: dict[str, object]) -> None:
        data = read_bytes(path, most_bytes=MAX_BYTES, code="E651")
        self.report = Report(path=str(path))
        self.given = given
        self.head: dict[str, tuple[str, Span]] = {}
        self.remarks: list[str] = []
        self.rows: list[tuple[int, str]] = []
        self.n_names = 0
        comments: list[tuple[int, str]] = []
        for number, line in enumerate(data.decode("utf-8", "replace").splitlines(), start=1):
            if line.lstrip().startswith("#"):
                comments += [(number, line)] * (not self.rows)
                self._read_key(number, line)
            elif line.strip(" ,;\t") and not line.lower().startswith("sep="):
                self.rows.append((number, line))
        if self.rows and comments and not re.search("[A-Za-z]{2}", self.rows[0][1].lower().replace("nan", "")):
            self.rows.insert(0, comments[-1])  # names behind a '#', as numpy.savetxt writes them
        self.delimiter = next((d for d in ("\t", ";", ",") if self.rows and d in self.rows[0][1]), ",")

    def _read_key(self, number: int, line: str) -> None:
        match = re.match(r"\s*#+\s*([A-Za-z][\w ]*?)\s*[:=]\s*(\S.*?)\s*\Z", line)
        key = KEYS.get(re.sub(r"\W+", "_", match[1].lower())) if match else None
        if match and key:
            self.head[key] = match[2], Span(number, match.start(2) + 1, line, len(match[2]))

    def _cells(self, line: str) -> list[tuple[str, int]]:
        """Texts of a row and where they stand; delimiters at its end count for nothing."""
        cells, start = [], 0
        for part in line.split(self.delimiter):
            text = part.strip()
            cells.append((text.strip('"'), start + len(part) - len(part.lstrip())))
            start += len(part) + 1
        return cells

    def points(self) -> RadiancePoints:
        """What the file holds, or all its problems."""
        columns = self._columns()
        self._read_rows(columns)
        of = {_OTHER.get(one.name.role, one.name.role): one for one in columns}
        if not {"zenith", "azimuth", "radiance"} <= of.keys() or not self.rows:
            self._close()
        angles = [of["zenith"], of["azimuth"]]
        are_degrees = any(np.any(np.abs(one.values) > 2 * np.pi) for one in angles)
        zenith, azimuth = (self._angle(one, are_degrees) for one in angles)
        sun_zenith, sun_azimuth = self._sun("sun_zenith", 90.0), self._sun("sun_azimuth", 360.0)
        azimuth = self._converted(azimuth, of["azimuth"], sun_azimuth)
        light = [one for one in columns if one.name.role == "radiance"]
        factor = self._factor(light)
        wavelength = self._wavelengths(light, of.get("wavelength"))
        for one in light:
            self._refuse(one, one.values < 0, "a radiance is 0 or more")
        self._close()
        zenith, azimuth = np.tile(zenith, len(light)), np.tile(azimuth, len(light))
        is_whole = np.isfinite(zenith) & np.isfinite(azimuth)
        is_whole &= True if wavelength is None else np.isfinite(wavelength)
        if not is_whole.all():
            self.remarks.append(
                f"{np.count_nonzero(~is_whole)} radiances without direction or wavelength were left out"
            )
        return RadiancePoints(
            zenith_deg=zenith[is_whole],
            azimuth_deg=azimuth[is_whole],
            wavelength_nm=None if wavelength is None else wavelength[is_whole],
            radiance=np.concatenate([one.values for one in light])[is_whole] * (factor or 1.0),
            is_absolute=factor > 0,
            sun_zenith_deg=sun_zenith,
            sun_azimuth_deg=sun_azimuth,
            remarks=tuple(self.remarks),
        )

    def _close(self) -> None:
        self.report.problems.sort(key=lambda problem: (problem.line, problem.column))
        self.report.close()

    def _columns(self) -> list[_Column]:
        """The columns that are used; problems of the names are reported."""
        if not self.rows:
            self.report.add(
                "E654", "the file has no rows", advice="write names of columns, and a row for each direction"
            )
            return []
        number, line = self.rows.pop(0)
        line = re.sub(r"^(\s*)#", r"\1 ", line)
        columns: dict[tuple[str, float | None], _Column] = {}
        cells, unused = self._cells(line), []
        self.n_names = len(cells)
        for index, (text, start) in enumerate(cells):
            name, span = name_of_column(text), Span(number, start + 1, line, max(len(text), 1))
            if name is None:
                unused += [text] if text else []
                continue
            first = columns.setdefault(
                (_OTHER.get(name.role, name.role), name.wavelength_nm), _Column(name, index, span)
            )
            if first.index != index:
                message = f"columns {first.index + 1} and {index + 1} are both {name.role}"
                self.report.at(span, "E651", message, advice="give the one that is not meant another name")
        roles, named = {role for role, _ in columns}, ", ".join(quoted(text) for text, _ in cells[:12])
        for role, advice in _NEEDED.items():
            if role not in roles:
                message = f"there is no column of {role}{' angles' * (role == 'zenith')} among {named}"
                self.report.at(Span(number, 1, line, len(line.rstrip())), "E651", message, advice=advice)
        if unused:
            self.remarks.append(f"columns not used: {', '.join(map(printable, unused))}")
        if not self.rows:
            self.report.add("E654", "the file has no row of numbers", advice="write a row for each direction")
        return list(columns.values())

    def _read_rows(self, columns: list[_Column]) -> None:
        """The numbers of the columns; NaN is a gap."""
        width = max((one.index for one in columns), default=0) + 1
        values = np.full((len(columns), len(self.rows)), np.nan)
        for k, (number, line) in enumerate(self.rows):
            cells = self._cells(line)
            if len(cells) < width or any(text for text, _ in cells[self.n_names :]):
                message = f"a row of {len(cells)} columns under {self.n_names} names"
                advice = f"write {_DELIMITERS[self.delimiter]} between columns, and a point for decimals"
                self.report.at(Span(number, 1, line, len(line)), "E652", message, advice=advice)
                continue
            for row, one in enumerate(columns):
                text, start = cells[one.index]
                try:
                    values[row, k] = self._number(text)
                except BadValueError as problem:
                    span = Span(number, start + 1, line, max(len(text), 1))
                    self.report.at(span, "E652", problem.message, advice=f"{problem.advice}, or nothing for a gap")
            if self.report.is_full:
                break
        for one, row_values in zip(columns, values, strict=True):
            one.values = row_values

    def _number(self, text: str) -> float:
        if text.lower() in GAPS:
            return np.nan
        value = parse_real(text if self.delimiter == "," else text.replace(",", "."))
        if abs(value) > MAX_VALUE:
            raise BadValueError("E652", f"{quoted(text)} is beyond all ranges", advice="write a smaller number")
        return np.nan if value in GAP_NUMBERS else value

    def _refuse(self, column: _Column, is_bad: np.ndarray, allowed: str) -> None:
        """Report numbers of a column that are outside of what is allowed."""
        for k in np.flatnonzero(is_bad)[:MAX_PER_VALUE]:
            number, line = self.rows[k]
            text, start = self._cells(line)[column.index]
            what = f"{column.name.role}{' angle' * (column.name.role in ('zenith', 'elevation'))}"
            message, advice = f"{quoted(text)} is no {what}", f"{allowed}; nothing, nan or -999 is a gap"
            self.report.at(Span(number, start + 1, line, len(text)), "E653", message, advice=advice)

    def _stated(self, key: str, column: _Column) -> tuple[str, Span]:
        """The unit that an option, the name of a column or the head says, and where it stands."""
        text, span = self.head.get(key, ("", column.span))
        given = self.given.get(key)
        if given is None and column.name.unit:
            return column.name.unit, column.span
        return (text, span) if given is None else (str(given), column.span)

    def _angle(self, column: _Column, are_degrees: bool) -> np.ndarray:
        """Zenith angles, or azimuths as they count in the file [deg]; `are_degrees`: no radian is so large."""
        unit, span = self._stated("angle", column)
        scale = angle_degrees(unit) if unit else 1.0
        if scale is None:
            self.report.at(span, "E651", f"{quoted(unit)} is no unit of an angle", advice=_SAY_ANGLE)
            scale = 1.0
        elif not unit and not are_degrees:
            self.report.at(span, "E651", "nothing says whether this is in degrees or radians", advice=_SAY_ANGLE)
        angle = np.round(column.values * scale, _DIGITS)
        low, high = (-360, 360) if "azimuth" in column.name.role else (-90, 180)
        self._refuse(column, (angle < low) | (angle > high), f"write {low} to {high} degrees")
        return 90.0 - angle if column.name.role == "elevation" else angle

    def _sun(self, name: str, high: float) -> float | None:
        """An angle of the sun, of options or the head. [deg]"""
        if name in self.given or name not in self.head:
            return self.given.get(name)  # type: ignore[return-value]
        text, span = self.head[name]
        match = re.fullmatch(r"(-?[\d.]+)\s*(?:deg(?:rees)?|°)?,?\s*(.*)", text)
        convention = "" if match is None or name == "sun_zenith" else convention_of(match[2]) or "from_sun"
        if match is None or not -high <= (value := parse_real(match[1])) <= high or convention.startswith("from_sun"):
            advice = _SAY_SUN if name == "sun_azimuth" else "write '# sun zenith: 40', 0 to 90 degrees"
            self.report.at(span, "E651", f"{quoted(text)} does not say where the sun is", advice=advice)
            return 0.0
        return float(to_enu_azimuth_deg(value, AzimuthConvention[convention.upper()])) if convention else value

    def _converted(self, azimuth: np.ndarray, column: _Column, sun_azimuth: float | None) -> np.ndarray:
        """Azimuths from +x towards +y."""
        text, span = self.head.get("azimuth", ("", column.span))
        usual = "from_sun" if column.name.role == "relative azimuth" and not text else None
        convention = self.given.get("azimuth") or convention_of(text) or usual
        if convention is None:
            what = f"{quoted(text)} does not say" if text else "nothing says"
            self.report.at(span, "E651", f"{what} from where azimuths count", advice=_SAY_AZIMUTH)
        elif not str(convention).startswith("from_sun"):
            return to_enu_azimuth_deg(azimuth, AzimuthConvention[str(convention).upper()])
        elif sun_azimuth is None:
            self.report.at(span, "E651", "azimuths count from the sun, but nothing says where it is", advice=_SAY_SUN)
        else:
            return azimuth_from_sun_deg(azimuth, sun_azimuth, clockwise=convention == "from_sun_clockwise")
        return azimuth

    def _factor(self, light: list[_Column]) -> float:
        """What the unit is in W m-2 nm-1 sr-1; 0 of relative radiances."""
        unit, span = self._stated("radiance", light[0])
        factors = [radiance_factor(one.name.unit) if one.name.unit else -1.0 for one in light]
        other = next((one for one, of_it in zip(light, factors, strict=True) if of_it != factors[0]), None)
        if not unit and other is None:
            self.remarks.append("the file has no unit of radiance, so its light is relative (--radiance-unit says one)")
            return 0.0
        factor = radiance_factor(unit)
        if other is not None and "radiance" not in self.given:
            self.report.at(other.span, "E651", "columns of radiance have different units", advice=_SAY_UNIT)
        elif factor is None:
            self.report.at(span, "E651", f"{quoted(unit)} is no unit of spectral radiance", advice=_SAY_UNIT)
        return factor or 0.0

    def _wavelengths(self, light: list[_Column], column: _Column | None) -> np.ndarray | None:
        """Wavelength of each radiance, None where the file has none. [nm]"""
        own = [one.name.wavelength_nm is not None for one in light]
        if any(own) and (not all(own) or column is not None):
            span = light[own.index(False)].span if column is None else column.span
            advice = "keep one of the two, and give the other columns other names"
            self.report.at(span, "E651", "other columns have wavelengths in their names", advice=advice)
        if any(own):
            return np.repeat([float(one.name.wavelength_nm or 0.0) for one in light], light[0].values.size)
        if column is not None:
            scale = length_nm(column.name.unit or "nm")
            if scale is None:
                message = f"{quoted(column.name.unit)} is no unit of a wavelength"
                self.report.at(column.span, "E651", message, advice="write wavelength (nm) or wavelength (um)")
                return None
            nm = np.round(column.values * scale, _DIGITS)
            self._refuse(column, (nm < 20) | (nm > 1e5), "write 20 to 100000 nm, or name the column wavelength (um)")
            return nm
        if "wavelength" not in self.head:
            return None
        text, span = self.head["wavelength"]
        match = re.fullmatch(r"(\d[\d.]*)\s*(\S*)", text)
        scale = length_nm(match[2] or "nm") if match else None
        if match is None or scale is None or not 20 <= (value := parse_real(match[1]) * scale) <= 1e5:
            self.report.at(span, "E651", f"{quoted(text)} is no wavelength", advice="write '# wavelength: 550 nm'")
            return None
        return np.full(light[0].values.size, value)
