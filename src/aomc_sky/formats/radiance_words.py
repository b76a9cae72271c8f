"""What a table or a field of radiances may state: names, keys, units and gaps. Everything else in it is text."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any, Literal, get_args

import numpy as np

from aomc_sky.directions import AzimuthConvention
from aomc_sky.errors import UsageError
from aomc_sky.formats.azimuth import convention_of, given_convention, words_of
from aomc_sky.formats.radiance_unit import SAY_UNIT, radiance_factor
from aomc_sky.formats.report import quoted

SunAngles = tuple[float | None, float | None]
"""Zenith angle of the sun, and azimuth from +x towards +y, where they are known. [deg]"""
DIRECTIONS = ("zenith", "elevation", "azimuth")
COORDINATES = (*DIRECTIONS, "wavelength")
NAMES = {
    **{f"{role}{unit}": (role, unit[1:]) for role in DIRECTIONS for unit in ("", "_deg", "_rad")},
    **{f"wavelength{unit}": ("wavelength", unit[1:]) for unit in ("", "_nm", "_um")},
}
"""Names of columns and coordinates: what each is, and the unit that it states."""
RADIANCE, RADIANCE_Q, RADIANCE_U = "radiance", "radiance_q", "radiance_u"
AT_WAVELENGTH = re.compile(r"(?:radiance|l)_(\d+(?:\.\d+)?)", re.I)
"""A column of radiances at one wavelength [nm]: L_412."""
KEYS = {
    "azimuth": "azimuth",
    "azimuth convention": "azimuth",
    "angle unit": "angle_unit",
    "radiance unit": "radiance_unit",
    "wavelength": "wavelength",
    "wavelength unit": "wavelength_unit",
    "sun zenith": "sun_zenith_deg",
    "sun azimuth": "sun_azimuth_deg",
    "decimal": "decimal",
}
"""Keys of lines '# key: value' of a table, and what each states."""
AngleUnitWord = Literal["deg", "rad"]
WavelengthUnitWord = Literal["nm", "um", "m", "angstrom"]
DecimalWord = Literal["point", "comma"]
DECIMALS = get_args(DecimalWord)

ANGLE_DEGREES = {
    **dict.fromkeys(("deg", "degree", "degrees", "degree_true", "degrees_true"), 1.0),
    **dict.fromkeys(("rad", "radian", "radians"), 180 / np.pi),
}
"""Units of an angle, in degrees."""
TRUE_NORTH = ("degree_true", "degrees_true")
"""Units of CF for angles clockwise from north."""
CF_CLOCKWISE = ("sensor_azimuth_angle", "platform_azimuth_angle")
"""CF standard names of azimuths clockwise from north."""
_METRES = [f"met{end}" for end in ("er", "ers", "re", "res")]
LENGTH_NM = {
    **dict.fromkeys(("nm", *(f"nano{one}" for one in _METRES)), 1.0),
    **dict.fromkeys(("um", "micron", "microns", *(f"micro{one}" for one in _METRES)), 1e3),
    **dict.fromkeys(("angstrom", "angstroms"), 0.1),
    **dict.fromkeys(("m", *_METRES), 1e9),
}
"""Units of a wavelength, in nm."""
LEAST_NM, MOST_NM = 20.0, 1e5
"""Wavelengths outside of these, in nm as they are read, have another unit."""

SAY_ANGLE = "write --angle-unit deg or rad (angle_unit=)"
SAY_LENGTH = "write --wavelength-unit nm, um, m or angstrom (wavelength_unit=)"
SAY_SUN = "write --sun-azimuth DEG, from east towards north (sun_azimuth_deg=)"
SAY_COMES_FROM = "write where light comes from: 180 degrees minus the zenith angle, the azimuth plus 180 degrees"


def say_coordinate(role: str, names: Sequence[str] = ()) -> str:
    """How to say which name is a coordinate, or the radiance, with the nearest one of a file."""
    name = next(iter(get_close_matches(role, names, 1, 0.4)), "NAME")
    if role == RADIANCE:
        return f"write --variable {quoted(name) if ' ' in name else name} (variable=)"
    option = f"{role}={name}"
    return f"write --coordinate {quoted(option) if ' ' in option else option} ({role}=)"


def quantity_of(role: str) -> str:
    """What a coordinate gives in the end: an elevation is a zenith angle."""
    return "zenith" if role == "elevation" else role


def plain_unit(unit: str) -> str:
    """A unit in small letters, with u for micro."""
    return unit.strip().lower().replace("µ", "u").replace("μ", "u")


@dataclass(frozen=True, kw_only=True, slots=True)
class Stated:
    """What a caller states about a table or a field: it comes before what the file states, None leaves it to that."""

    zenith: str | None = None  #: Names of columns or coordinates
    elevation: str | None = None
    azimuth: str | None = None
    wavelength: str | None = None
    variable: str | None = None  #: Name of the radiances
    variable_q: str | None = None
    variable_u: str | None = None
    stokes_signs: tuple[float, float] | None = None  #: Factors of Q and U, 1 or -1
    isel: tuple[tuple[str, int], ...] = ()  #: The index to take of dimensions that are neither angles nor wavelengths
    angle_unit: str | None = None  #: "deg" or "rad"
    azimuth_convention: AzimuthConvention | str | None = None
    wavelength_unit: str | None = None  #: One of `LENGTH_NM`
    radiance_unit: str | None = None  #: Such as "mW m-2 nm-1 sr-1", or "relative"
    decimal: str | None = None  #: One of `DECIMALS`

    def check(self) -> None:
        """UsageError for a word that none of the tables has."""
        _ = self.convention
        if self.angle_unit not in (None, "deg", "rad"):
            raise UsageError(f"angle_unit must be 'deg' or 'rad', got {self.angle_unit!r}")
        if self.wavelength_unit is not None and plain_unit(str(self.wavelength_unit)) not in LENGTH_NM:
            raise UsageError(f"wavelength unit {self.wavelength_unit!r} is not known; {SAY_LENGTH}")
        if self.radiance_unit is not None and radiance_factor(str(self.radiance_unit)) is None:
            raise UsageError(f"radiance unit {self.radiance_unit!r} is not known; {SAY_UNIT}")
        if self.decimal not in (None, *DECIMALS):
            raise UsageError(f"decimal must be 'point' or 'comma', got {self.decimal!r}")
        if self.zenith is not None and self.elevation is not None:
            raise UsageError("zenith and elevation name the same angle: give one of them")
        if (self.variable_q is None) != (self.variable_u is None):
            raise UsageError("variable_q and variable_u belong together: give both, or none")
        if self.stokes_signs is not None and (
            len(self.stokes_signs) != 2 or any(sign not in (-1, 1) for sign in self.stokes_signs)
        ):
            raise UsageError(f"stokes_signs are two of 1 and -1, for Q and for U, got {self.stokes_signs!r}")

    @property
    def convention(self) -> AzimuthConvention | None:
        """The convention as a member."""
        return None if self.azimuth_convention is None else given_convention(self.azimuth_convention)


_MEANINGS: dict[str, Callable[[str], object]] = {
    "angle_unit": lambda text: ANGLE_DEGREES.get(plain_unit(text)),
    "wavelength_unit": lambda text: LENGTH_NM.get(plain_unit(text)),
    "radiance_unit": radiance_factor,
    "azimuth": convention_of,
    "decimal": lambda text: text.lower() if text.lower() in DECIMALS else None,
}
"""What a word of a file means, by what it states."""


def meaning_of(what: str, word: object) -> Any:
    """What a word means, None for one that is not known."""
    return word if isinstance(word, AzimuthConvention) else _MEANINGS[what](str(word))


def instead(what: str, given: object, said: str) -> list[str]:
    """The note of a caller's word that comes before another one of the file, a list of one; empty where they agree."""
    word = words_of(given) if isinstance(given, AzimuthConvention) else str(given)
    meaning = _MEANINGS.get(what, str)
    is_same = word == said or (meaning(word) is not None and meaning(word) == meaning(said))
    name = what.removesuffix("_deg").replace("_", " ")
    return [] if is_same else [f"{name} {word} in place of {quoted(said)} of the file"]


def may_be_radians(values: np.ndarray, *, is_azimuth: bool) -> bool:
    """Whether angles of a whole sky, in degrees as it is stated, are within a turn in radians."""
    known = np.unique(values[np.isfinite(values)])
    reach, turn = (np.ptp(known), 2 * np.pi) if is_azimuth and known.size else (np.abs(known).max(initial=0), np.pi / 2)
    return known.size >= _FEW and bool(_MOST_OF_IT * turn < reach < 1.001 * turn)


_FEW, _MOST_OF_IT = 4, 0.75  #: So many angles, over so much of the sky, are judged by their range.
GAPS = ("", "nan")
GAP_NUMBERS = (-999.0, -9999.0)
"""Words and numbers of a table that stand for a gap."""
MAX_RADIANCE = 1e30
"""Larger numbers are fill values, in any unit."""
_NINES = re.compile(r"9{3,7}|9{2,5}\.9{1,3}")  #: Numbers of nines alone, from 99.9 on.
_LARGEST = (32767.0, 65535.0)  #: The largest whole numbers of two bytes.
_FILL, _FILL_BEYOND = 1e10, 1e6  #: Numbers from here on, so many times the next radiance, are likely fill values.
_FAR_BEYOND = 2.0  #: So many times the next radiance is a number of nines a gap rather than a radiance.
_FAR_BEYOND_DECIMAL = 5.0  #: The same of nines with decimals: a rounded radiance next to the sun may have them.


def doubt_of_gaps(values: Iterable[np.ndarray]) -> tuple[str, str] | None:
    """What to ask, and what to write, where the largest radiances of a row are nines or huge, and far beyond others."""
    for known in (row[np.isfinite(row)] for row in values):
        largest = known.max(initial=0.0)
        others = known[known < largest]
        shown = f"{largest:.7g}"
        is_code = _NINES.fullmatch(shown) is not None or any(np.isclose(largest, _LARGEST, rtol=1e-6, atol=0.0))
        is_huge = largest >= _FILL and others.size > 0 and 0 < others.max() * _FILL_BEYOND <= largest
        far = _FAR_BEYOND_DECIMAL if "." in shown else _FAR_BEYOND
        if is_huge or (is_code and others.size and others.max() * far <= largest):
            n = known.size - others.size
            message = f"{n} radiance{'s are' if n > 1 else ' is'} {shown}, and the next one is {others.max():g}"
            less = f", or {largest - 1:.7g} for a radiance" if is_code else ""
            return f"{message}; is {shown} a gap?", f"write NaN for a gap{less}"
    return None


def by_wavelength(nm: np.ndarray) -> list[np.ndarray]:
    """Indices of the points of each wavelength."""
    order = np.argsort(nm, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(nm[order]) != 0) + 1)
