"""Where the Moon stands before the sun: its keys in sky.toml, as options and as arguments."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from aomc_sky.formats.sky_toml.rules import Range, Rule

PREFIX = "moon_"
MOON_KEYS: dict[str, Rule] = {
    "moon_zenith_deg": Range(low=0, high=180),
    "moon_zenith_offset_deg": Range(low=-180, high=180),
    "moon_azimuth_deg": Range(low=-360, high=360),
    "moon_azimuth_offset_deg": Range(low=-360, high=360),
    "moon_distance_km": Range(low=2000, high=1e12),
}
"""Keys of [atmosphere] and what each accepts."""

_TWICE = (("moon_zenith_deg", "moon_zenith_offset_deg"), ("moon_azimuth_deg", "moon_azimuth_offset_deg"))


@dataclass(frozen=True, kw_only=True, slots=True)
class MoonDirection:
    """The centre of the Moon as the observer sees it."""

    zenith_deg: float | None = None  #: Zenith angle. [deg, 0 to 180]
    #: That minus the sun's zenith angle: positive is lower than the sun. [deg, -180 to 180]
    zenith_offset_deg: float | None = None
    azimuth_deg: float | None = None  #: Azimuth, from +x towards +y. [deg, -360 to 360]
    azimuth_offset_deg: float | None = None  #: That minus the sun's azimuth. [deg, -360 to 360]
    distance_km: float | None = None  #: From the observer; None is what the description says. [km, 2000 to 1e12]

    @property
    def is_empty(self) -> bool:
        """Whether nothing is given."""
        return self == MoonDirection()

    @property
    def has_angle(self) -> bool:
        """Whether more than a distance is given."""
        return not dataclasses.replace(self, distance_km=None).is_empty

    def angles(self, sun_zenith_deg: float, sun_azimuth_deg: float) -> tuple[float, float]:
        """Zenith angle and azimuth from the sun's; an angle that nobody gives is the sun's. [deg]"""
        zenith = sun_zenith_deg + (self.zenith_offset_deg or 0.0) if self.zenith_deg is None else self.zenith_deg
        if self.azimuth_deg is None:
            return zenith, self.azimuth_offset_deg or 0.0
        return zenith, self.azimuth_deg - sun_azimuth_deg

    def under(self, first: MoonDirection) -> MoonDirection:
        """What `first` says, and this direction where it is silent; an angle and its offset are one thing."""
        merged = {name: value for name, value in dataclasses.asdict(first).items() if value is not None}
        for pair in (("zenith_deg", "zenith_offset_deg"), ("azimuth_deg", "azimuth_offset_deg"), ("distance_km",)):
            if not any(name in merged for name in pair):
                merged |= {name: getattr(self, name) for name in pair}
        return MoonDirection(**merged)


def moon_direction(values: Mapping[str, Any]) -> MoonDirection:
    """A direction from the good values of `MOON_KEYS`; other names are passed over."""
    return MoonDirection(**{name.removeprefix(PREFIX): value for name, value in values.items() if name in MOON_KEYS})


def moon_problem(names: Collection[str]) -> tuple[str, str]:
    """Message and advice where the `MOON_KEYS` that are given are not one position; empty where they are, or none."""
    for pair in _TWICE:
        if all(name in names for name in pair):
            return f"{pair[0]} and {pair[1]} say the same thing twice", f"remove {pair[1]}"
    if names and not any(name in names for pair in _TWICE for name in pair):
        return "moon_distance_km without a place of the Moon", "add moon_zenith_offset_deg = 0, or moon_zenith_deg"
    return "", ""
