"""Sections and keys of sky.toml, their ranges, and the sets that belong together."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from numbers import Real
from typing import Any

from aomc_sky.errors import Span
from aomc_sky.formats.report import BadValueError
from aomc_sky.formats.sky_toml.rules import (
    Rule,
    azimuth_words,
    choice,
    count,
    indices,
    number,
    rules_of,
    several,
    signs,
    sky_name,
    text,
    time,
    unit_of_radiance,
)
from aomc_sky.inputs import CLEAR_SKY, INPUTS, LIGHTS, MODEL, PEREZ, SUN

COEFFICIENT_NAMES = ("a", "b", "c", "d", "e")
SETS = (("dni", "dhi"), ("ghi", "dni"), ("ghi", "dhi"), ("ghi", "dni", "dhi"), ("epsilon", "delta"), COEFFICIENT_NAMES)
"""A Perez sky needs exactly one of these sets. With three irradiances, ghi is only checked."""

SKY_TOML = "sky.toml"
"""The name under which the file is the origin of something."""

SPECTRL2 = "spectrl2"
"""The spectrum that divides each waveband between beam and sky."""

_GROUPS = (("dni", "dhi", "ghi"), ("epsilon", "delta"), COEFFICIENT_NAMES)
_SETS_TEXT = "dni + dhi, ghi + dni, ghi + dhi, epsilon + delta, or a, b, c, d, e"

_SPECTRUM = several(number(0, 10_000))
DIFFUSE_MODELS = ("perez", "uniform", "none")
"""Our laws of the diffuse sky; "none": neither sun nor sky, the backgrounds alone shine."""
INTERPOLATIONS = ("crossfade", "slerp")
SOLVERS = ("auto", "order1", "sos", "mc")
"""Ways to solve an atmosphere."""

GLOW_KEY = "ground_luminance_cd_m2"
"""Key of [atmosphere]: how bright the ground is without the sun."""

FIELD_KEYS: dict[str, Rule] = {
    "variable": text("the name of a variable"),
    "variable_q": text("the name of a variable"),
    "variable_u": text("the name of a variable"),
    "stokes_signs": signs,
    "isel": indices,
    "zenith": text("the name of a coordinate"),
    "azimuth": text("the name of a coordinate"),
    "wavelength": text("the name of a coordinate"),
    "angle_unit": choice(("deg", "rad")),
    "azimuth_convention": azimuth_words,
    "radiance_unit": unit_of_radiance,
}
"""Keys of [sky] beside table: what the file does not say, as `TabulatedSky.from_xarray` has it."""

POLARISATION = "polarisation"
"""Key of [sky]: largest degree of Rayleigh's pattern on the light of any sky with a sun."""

PREFIX = "moon_"


MOON_KEYS = tuple(name for name in LIGHTS if name != GLOW_KEY)
"""Keys of [atmosphere] that place the Moon."""

_TWICE = (("moon_zenith_deg", "moon_zenith_offset_deg"), ("moon_azimuth_deg", "moon_azimuth_offset_deg"))

KEYS: dict[str, dict[str, Rule]] = {
    "perez": {
        key: rule
        for name, rule in rules_of(PEREZ).items()
        for key in (COEFFICIENT_NAMES if name == "coefficients" else (name,))
    },
    "sun": rules_of(SUN),
    "clear_sky": rules_of(CLEAR_SKY),
    "sky": {
        "model": sky_name(DIFFUSE_MODELS),
        "table": text("the path of a netCDF file or a table of text"),
        **FIELD_KEYS,
        "diffuse_irradiance": _SPECTRUM,
        "direct_irradiance": _SPECTRUM,
        **rules_of({POLARISATION: INPUTS[POLARISATION]}),
    },
    "background": {
        "file": text("the path of a background-sky file"),
        "time": time,
        "animation": several(text("the name of an animation"), or_one=True),
        "utc_offset": number(-24, 24),
        "interpolation": choice(INTERPOLATIONS),
    },
    "atmosphere": {
        "file": text("the path of an atmosphere description"),
        "method": choice(SOLVERS),
        "orders": count(1, 400),
        "paths": count(8, 1_000_000_000),
        "zenith_bins": count(1, 3600),
        "azimuth_bins": count(1, 3600),
        **rules_of(LIGHTS),
    },
}
"""Sections of sky.toml and what each key of them accepts."""

RULES = {**KEYS, "model": rules_of(MODEL)}
"""The same with the arguments of `PerezSky` that are not keys of sky.toml."""

REPEATED = ("background",)
"""Sections that may stand any number of times, as [[section]]."""
REQUIRED = {"background": ("file", "time"), "atmosphere": ("file",)}
"""Keys without which a section says nothing."""
PER_WAVEBAND = {"sky": ("diffuse_irradiance", "direct_irradiance")}
"""Arrays with a value for each waveband."""
PATHS = {"sky": ("table",), "background": ("file",), "atmosphere": ("file",)}
"""Keys that name a file, relative to the folder of sky.toml."""


class Section:
    """A section, all of which may be left out."""

    __slots__ = ()

    @property
    def is_empty(self) -> bool:
        """Whether nothing is given."""
        return self == type(self)()


@dataclass(frozen=True, kw_only=True, slots=True)
class PerezSection(Section):
    """[perez]: one of the `SETS`, or nothing, and the spectrum; of sky.toml or of a caller."""

    #: Direct normal, diffuse horizontal, global horizontal irradiance. [W m-2, 0 to 10 000]
    dni: float | None = None
    dhi: float | None = None
    ghi: float | None = None
    epsilon: float | None = None  #: Sky clearness. [1 or more]
    delta: float | None = None  #: Sky brightness. [0 or more]
    coefficients: tuple[float, float, float, float, float] | None = None  #: a, b, c, d, e of eq. (1). [-1000 to 1000]
    spectrum: str | None = None  #: "flat" or `SPECTRL2`
    origin: str = field(default=SKY_TOML, compare=False)  #: who says so
    words: str = field(default="", compare=False)  #: for a person, if the set was computed

    def __str__(self) -> str:
        """The set for a person, and who says it."""
        return f"{self.text} ({self.origin})"

    @property
    def text(self) -> str:
        """The set for a person."""
        if self.words:
            return self.words
        if self.coefficients is not None:
            return f"coefficients {', '.join(f'{c:g}' for c in self.coefficients)}"
        if self.epsilon is not None:
            return f"epsilon {self.epsilon:g} and Delta {self.delta:g}"
        named = (("ghi", self.ghi), ("dni", self.dni), ("dhi", self.dhi))
        *others, last = [f"{name} {value:g}" for name, value in named if value is not None]
        return f"{', '.join(others)} and {last} W m-2"

    @property
    def has_irradiances(self) -> bool:
        """Whether the set is one of irradiances."""
        return self.dni is not None or self.dhi is not None

    @property
    def has_set(self) -> bool:
        """Whether one of the `SETS` is given."""
        return any(value is not None for value in (self.dni, self.dhi, self.ghi, self.epsilon, self.coefficients))


@dataclass(frozen=True, kw_only=True, slots=True)
class SunSection(Section):
    """[sun]: what is finer than amc.inp; of sky.toml, of a caller or of amc.inp itself."""

    zenith_deg: float | None = None  #: Zenith angle of the sun. [deg, 0 to 180; below 90 without [atmosphere]]
    azimuth_deg: float | None = None  #: Azimuth of the sun, from +x towards +y as in amc.inp. [deg, -360 to 360]
    disc: bool | None = None  #: Whether the beam has the extent of the solar disc
    origin: str = field(default=SKY_TOML, compare=False)  #: who says so

    def over(self, below: SunSection) -> SunSection:
        """Each value of this, or else of the other."""
        values = {}
        origins: dict[str, None] = {}
        for name in ("zenith_deg", "azimuth_deg", "disc"):
            first = self if getattr(self, name) is not None else below
            values[name] = getattr(first, name)
            if name != "disc" and values[name] is not None:
                origins[first.origin] = None
        return SunSection(**values, origin=" and ".join(origins) or self.origin)


@dataclass(frozen=True, kw_only=True, slots=True)
class SkyOption:
    """An option of another package's sky model as sky.toml has it."""

    name: str
    value: Any
    key_span: Span
    value_span: Span


@dataclass(frozen=True, kw_only=True, slots=True)
class FieldSection:
    """The file of [sky], netCDF or a table of text, and what it does not say itself."""

    file: str  #: Path of the file, as it can be opened
    variable: str | None = None  #: Name of the radiances; by default the only variable, or the only radiance
    variable_q: str | None = None  #: Names of Q and U, where these do not say it
    variable_u: str | None = None
    stokes_signs: tuple[float, float] | None = None  #: Factors of Q and U, 1 or -1
    isel: tuple[tuple[str, int], ...] = ()  #: The index to take of dimensions that are neither angles nor wavelengths
    zenith: str | None = None  #: Names of coordinates
    azimuth: str | None = None
    wavelength: str | None = None
    angle_unit: str | None = None  #: "deg" or "rad"
    azimuth_convention: str | None = None  #: Words such as "clockwise from north"
    radiance_unit: str | None = None  #: Such as "mW m-2 nm-1 sr-1", or "relative"


@dataclass(frozen=True, kw_only=True, slots=True)
class SkySection(Section):
    """[sky]: which sky, and how bright it is."""

    model: str | None = None  #: One of `DIFFUSE_MODELS`, or the name of another package's model
    model_span: Span | None = field(default=None, compare=False)  #: Position of such a name
    options: tuple[SkyOption, ...] = ()  #: Keys that are not ours, beside such a name
    table: FieldSection | None = None  #: A radiance field instead of a model
    #: Irradiance of the diffuse sky on a horizontal plane, a value for each waveband. [W m-2 nm-1, 0 to 10 000]
    diffuse_irradiance: tuple[float, ...] | None = None
    #: The same of the direct beam; by default it follows from the direct fraction. [W m-2 nm-1, 0 to 10 000]
    direct_irradiance: tuple[float, ...] | None = None
    polarisation: float | None = None  #: Largest degree of Rayleigh's pattern on its light. [0 to 1]


@dataclass(frozen=True, kw_only=True, slots=True)
class BackgroundSection:
    """[[background]]: a background-sky file at one time."""

    file: str  #: Path of the file, as it can be opened
    time: float  #: Time. [s since 1970-01-01 UTC]
    animation: tuple[str, ...] | None = None  #: Names of the animations that shine, by default all
    utc_offset: float = 0.0  #: Local time less UTC, for the midnight of repeating animations. [h, -24 to 24]
    interpolation: str = "crossfade"  #: One of `INTERPOLATIONS`: what happens between two keys


@dataclass(frozen=True, kw_only=True, slots=True)
class MoonDirection(Section):
    """The centre of the Moon as the observer sees it."""

    zenith_deg: float | None = None  #: Zenith angle. [deg, 0 to 180]
    #: That minus the sun's zenith angle: positive is lower than the sun. [deg, -180 to 180]
    zenith_offset_deg: float | None = None
    azimuth_deg: float | None = None  #: Azimuth, from +x towards +y. [deg, -360 to 360]
    azimuth_offset_deg: float | None = None  #: That minus the sun's azimuth. [deg, -360 to 360]
    distance_km: float | None = None  #: From the observer, by default that of the description. [km, 2000 to 1e12]

    @property
    def has_angle(self) -> bool:
        """Whether more than a distance is given."""
        return not dataclasses.replace(self, distance_km=None).is_empty

    def angles(self, sun_zenith_deg: float, sun_azimuth_deg: float) -> tuple[float, float]:
        """Zenith angle, and azimuth from the sun's; the default angles are those of the sun. [deg]"""
        zenith = sun_zenith_deg + (self.zenith_offset_deg or 0.0) if self.zenith_deg is None else self.zenith_deg
        if self.azimuth_deg is None:
            return zenith, self.azimuth_offset_deg or 0.0
        return zenith, self.azimuth_deg - sun_azimuth_deg

    def under(self, first: MoonDirection) -> MoonDirection:
        """Angles and distance of `first`, completed by this direction; an angle and its offset count as one."""
        merged = {name: value for name, value in dataclasses.asdict(first).items() if value is not None}
        for pair in (("zenith_deg", "zenith_offset_deg"), ("azimuth_deg", "azimuth_offset_deg"), ("distance_km",)):
            if not any(name in merged for name in pair):
                merged |= {name: getattr(self, name) for name in pair}
        return MoonDirection(**merged)


@dataclass(frozen=True, kw_only=True, slots=True)
class AtmosphereSection:
    """[atmosphere]: sun and sky from an atmosphere description."""

    file: str  #: Path of the description, as it can be opened
    method: str = "auto"  #: One of `SOLVERS`
    #: Most interactions of light with air and ground, by default those of the description. [1 to 400]
    orders: int | None = None
    #: Backward paths of each direction and wavelength; the solver chooses by default. [8 to 1e9]
    paths: int | None = None
    #: Equal bins of the patches. [1 to 3600]
    zenith_bins: int = 45
    azimuth_bins: int = 180
    moon: MoonDirection = field(default_factory=MoonDirection)  #: The Moon that hides part of the sun; empty: no Moon
    ground_luminance_cd_m2: float = 0.0  #: Luminance of the ground's own light. [0 to 1e6]


def perez_section(values: Mapping[str, Any]) -> PerezSection:
    """Put the coefficients a to e together, if they are there."""
    others = {name: value for name, value in values.items() if name not in COEFFICIENT_NAMES}
    if any(name not in values for name in COEFFICIENT_NAMES):
        return PerezSection(**others)
    a, b, c, d, e = (values[name] for name in COEFFICIENT_NAMES)
    return PerezSection(**others, coefficients=(a, b, c, d, e))


def set_problem(names: Collection[str]) -> tuple[str, str]:
    """Message and advice for keys of [perez] that are not one of the `SETS`; empty for a good set and for no key."""
    names = [name for name in names if any(name in group for group in _GROUPS)]
    if not names or any(set(names) == set(complete) for complete in SETS):
        return "", ""
    groups = [[name for name in group if name in names] for group in _GROUPS]
    touched = [group for group in groups if group]
    if len(touched) > 1:
        shown = " and ".join("/".join(group) for group in touched)
        return f"{shown} describe the same sky twice", f"keep one of {_SETS_TEXT}"
    named = touched[0]
    expected = next(complete for complete in SETS if set(named) <= set(complete))
    missing = [name for name in expected if name not in named]
    alternative = {"dni": " (or ghi)", "dhi": " (or ghi)", "ghi": " (or dhi)"}.get(named[0], "")
    return f"{', '.join(named)} without {', '.join(missing)}", f"add {', '.join(missing)}{alternative}"


def _atmosphere_section(values: Mapping[str, Any]) -> AtmosphereSection:
    others = {name: value for name, value in values.items() if name not in MOON_KEYS}
    return AtmosphereSection(**others, moon=moon_direction(values))


def _sky_section(values: Mapping[str, Any]) -> SkySection:
    others = {name: value for name, value in values.items() if name not in FIELD_KEYS and name != "table"}
    field_values = {name: value for name, value in values.items() if name in FIELD_KEYS}
    return SkySection(**others, table=FieldSection(file=values["table"], **field_values) if "table" in values else None)


BUILDERS: dict[str, Callable[[Mapping[str, Any]], Any]] = {
    "perez": perez_section,
    "sun": lambda values: SunSection(**values),
    "clear_sky": dict,
    "sky": _sky_section,
    "background": lambda values: BackgroundSection(**values),
    "atmosphere": lambda values: _atmosphere_section(values) if values else None,
}
"""Functions that make a section from its good values."""


def value_problem(section: str, name: str, value: object) -> tuple[str, str, str]:
    """Code, message and advice of the first fault of a value; empty for a good one."""
    try:
        RULES[section][name](value)
    except BadValueError as problem:
        return problem.code, problem.message, problem.advice
    return "", "", ""


def moon_direction(values: Mapping[str, Any]) -> MoonDirection:
    """A direction from the good values of `MOON_KEYS`; other names are passed over."""
    return MoonDirection(**{name.removeprefix(PREFIX): value for name, value in values.items() if name in MOON_KEYS})


def moon_problem(names: Collection[str]) -> tuple[str, str]:
    """Message and advice for `MOON_KEYS` that are not one position; empty for a good position and for no key."""
    for pair in _TWICE:
        if all(name in names for name in pair):
            return f"{pair[0]} and {pair[1]} say the same thing twice", f"remove {pair[1]}"
    if names and not any(name in names for pair in _TWICE for name in pair):
        return "moon_distance_km without a direction of the Moon", "add moon_zenith_offset_deg = 0, or moon_zenith_deg"
    return "", ""


def plain_number(value: object) -> object:
    """A real number of any library as a float of Python; anything else as it is."""
    return float(value) if isinstance(value, Real) and not isinstance(value, bool) else value
