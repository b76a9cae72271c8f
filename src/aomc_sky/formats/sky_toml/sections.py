"""Sections of sky.toml as records, and how each is made from its good values."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from aomc_sky.errors import Span
from aomc_sky.formats.radiance_words import Stated, SunAngles
from aomc_sky.formats.sky_toml.keys import COEFFICIENT_NAMES, FIELD_KEYS, MOON_KEYS, PREFIX, SKY_TOML
from aomc_sky.options import MODEL


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
    model: Mapping[str, Any] = field(default_factory=dict)  #: Further arguments of `PerezSky`, by `MODEL`
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
    def has_amounts(self) -> bool:
        """Whether irradiances, or epsilon and delta, say how bright sun and sky are."""
        return self.has_irradiances or self.epsilon is not None

    @property
    def has_set(self) -> bool:
        """Whether one of the `SETS` is given."""
        return self.has_amounts or self.coefficients is not None


@dataclass(frozen=True, kw_only=True, slots=True)
class SunSection(Section):
    """[sun]: what is finer than amc.inp; of sky.toml, of a caller or of amc.inp itself."""

    zenith_deg: float | None = None  #: Zenith angle of the sun. [deg, 0 to 180; below 90 without [atmosphere]]
    azimuth_deg: float | None = None  #: Azimuth of the sun, from +x towards +y as in amc.inp. [deg, -360 to 360]
    disc: bool | None = None  #: Whether the beam has the extent of the solar disc
    origin: str = field(default=SKY_TOML, compare=False)  #: who says so

    @property
    def angles_deg(self) -> SunAngles:
        """Zenith angle and azimuth."""
        return self.zenith_deg, self.azimuth_deg

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
class FieldSection(Stated):
    """The file of [sky], netCDF or a table of text, and what is stated of it."""

    file: str  #: Path of the file, as it can be opened


@dataclass(frozen=True, kw_only=True, slots=True)
class SkySection(Section):
    """[sky]: which sky, and how bright it is."""

    model: str | None = None  #: One of `DIFFUSE_MODELS`, or the name of another package's model
    model_span: Span | None = field(default=None, compare=False)  #: Position of such a name
    options: tuple[SkyOption, ...] = ()  #: Keys that are not ours, beside such a name
    table: FieldSection | None = None  #: A radiance field instead of a model
    #: Irradiance of the diffuse sky on a horizontal plane, a value for each waveband. [W m-2 nm-1, 0 to 20]
    diffuse_irradiance: tuple[float, ...] | None = None
    #: The same of the direct beam; by default it follows from the direct fraction. [W m-2 nm-1, 0 to 20]
    direct_irradiance: tuple[float, ...] | None = None
    polarisation: float | None = None  #: Largest degree of Rayleigh's pattern on its light. [0 to 1]
    weighting: str | None = None  #: Meaning of the values of skydist.inp


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
    seed: int = 0  #: Of the random numbers of the paths. [0 to 2^64 - 1]
    #: Equal bins of the patches. [1 to 3600]
    zenith_bins: int = 45
    azimuth_bins: int = 180
    moon: MoonDirection = field(default_factory=MoonDirection)  #: The Moon that hides part of the sun; empty: no Moon
    ground_luminance_cd_m2: float = 0.0  #: Luminance of the ground's own light. [0 to 1e6]


@dataclass(frozen=True, kw_only=True, slots=True)
class SkyToml:
    """Contents of sky.toml; a missing section is empty."""

    perez: PerezSection = field(default_factory=PerezSection)
    sun: SunSection = field(default_factory=SunSection)
    clear_sky: Mapping[str, Any] = field(default_factory=dict)  #: The keys that are given
    sky: SkySection = field(default_factory=SkySection)
    photons: Mapping[str, Any] = field(default_factory=dict)  #: The keys that are given
    background: tuple[BackgroundSection, ...] = ()
    atmosphere: AtmosphereSection | None = None


def perez_section(values: Mapping[str, Any]) -> PerezSection:
    """Put the coefficients a to e together, if they are there."""
    others: dict[str, Any] = {name: value for name, value in values.items() if name not in (*COEFFICIENT_NAMES, *MODEL)}
    others["model"] = {name: value for name, value in values.items() if name in MODEL}
    if any(name not in values for name in COEFFICIENT_NAMES):
        return PerezSection(**others)
    a, b, c, d, e = (values[name] for name in COEFFICIENT_NAMES)
    return PerezSection(**others, coefficients=(a, b, c, d, e))


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
    "photons": dict,
    "sky": _sky_section,
    "background": lambda values: BackgroundSection(**values),
    "atmosphere": lambda values: _atmosphere_section(values) if values else None,
}
"""Functions that make a section from its good values."""


def moon_direction(values: Mapping[str, Any]) -> MoonDirection:
    """A direction from the good values of `MOON_KEYS`; other names are passed over."""
    return MoonDirection(**{name.removeprefix(PREFIX): value for name, value in values.items() if name in MOON_KEYS})
