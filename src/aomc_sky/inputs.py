"""Inputs of sky and sun: options, keys of sky.toml and checks of arguments are made from these rows."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Input:
    """One input: its names, its description and its allowed values."""

    name: str  #: Key of sky.toml and of the arguments of `read_scene`
    option: str  #: On the command line
    text: str  #: Description for --help; empty: it is not shown there
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    words: tuple[str, ...] = ()  #: Values of a choice, the default first
    is_switch: bool = False  #: Whether it is true or false
    keyword: str = ""  #: Argument of `weather_scene`, the name by default
    value: str = ""  #: What stands for the value in --help, by default the unit


SURE_NM = 2800.0
"""Longer wavelengths without a unit may be angstroms."""


def in_nm(wavelength: float, shown: str) -> str:
    """What to write for a wavelength that is in micrometres or metres, as a person gave it; else empty."""
    is_small, is_tiny = 0.1 <= wavelength < 20.0, 0.0 < wavelength < 1e-4
    if not is_small and not is_tiny:
        return ""
    unit, factor = ("micrometres", 1000) if is_small else ("metres", 1e9)
    return f"wavelengths are in nm, got {shown} ({unit}?); write {factor * wavelength:g}"


def _by_name(*rows: Input) -> dict[str, Input]:
    return {row.name: row for row in rows}


PEREZ = _by_name(
    Input("dni", "--dni", "direct normal irradiance; two of --dni, --dhi, --ghi", "W m-2", 0, 10_000),
    Input("dhi", "--dhi", "diffuse horizontal irradiance", "W m-2", 0, 10_000),
    Input("ghi", "--ghi", "global horizontal irradiance", "W m-2", 0, 10_000),
    Input("epsilon", "--epsilon", "sky clearness, with --delta", low=1),
    Input("delta", "--delta", "sky brightness", low=0),
    Input("coefficients", "--coefficients", "of the sky, eq. (1)", low=-1000, high=1000),
    Input("spectrum", "--spectrum", "how beam and sky of these amounts share each waveband: all alike (flat), or by "
          "clear-sky spectra scaled to dni and dhi (spectrl2, which needs the extra 'weather'; without amounts the "
          "light of a cloudless sky)", words=("flat", "spectrl2")),
)  # fmt: skip
"""Keys of [perez]; the coefficients are its keys a to e."""

SUN = _by_name(
    Input("zenith_deg", "--sun-zenith", "zenith angle of the sun, below 90 without an atmosphere", "deg", 0, 180,
          keyword="sun_zenith_deg"),
    Input("azimuth_deg", "--sun-azimuth", "azimuth of the sun, from +x (east) to +y (north)", "deg", -360, 360,
          keyword="sun_azimuth_deg"),
    Input("disc", "--disc", "the beam has the extent of the solar disc", is_switch=True, keyword="sun_disc"),
)  # fmt: skip
"""Keys of [sun]."""

MODEL = _by_name(
    Input("limits", "--limits", "limits of clearness and brightness: published practice (radiance, the default), or "
          "none (paper)", words=("radiance", "paper")),
    Input("within", "--within", "law of the Perez sky inside a patch: its own (exact, the default), or constant",
          words=("exact", "uniform")),
    Input("air_mass", "--air-mass", "formula of the air mass in Delta (default kasten-young-1989)",
          words=("kasten-young-1989", "kasten-1966")),
    Input("extraterrestrial_normal", "--extraterrestrial", "extraterrestrial normal irradiance at the sun's mean "
          "distance (default 1361.1); with a date, times the factor of the distance", "W m-2", 1, 1e6),
)  # fmt: skip
"""Further arguments of `PerezSky`, which are not keys of sky.toml."""

LIGHTS = _by_name(
    Input("moon_zenith_deg", "--moon-zenith", "zenith angle of the Moon before the sun", "deg", 0, 180),
    Input("moon_zenith_offset_deg", "--moon-zenith-offset", "that minus the sun's zenith angle", "deg", -180, 180),
    Input("moon_azimuth_deg", "--moon-azimuth", "azimuth of the Moon (default: the sun's)", "deg", -360, 360),
    Input("moon_azimuth_offset_deg", "--moon-azimuth-offset", "that minus the sun's azimuth", "deg", -360, 360),
    Input("moon_distance_km", "--moon-distance", "of the Moon's centre (default: the description's)", "km", 2000, 1e12),
    Input("ground_luminance_cd_m2", "--ground-luminance", "of a ground that glows (default 0)", "cd m-2", 0, 1e6),
)
"""Keys of [atmosphere] for the Moon and the glow of the ground."""

CLEAR_SKY = _by_name(
    Input("aod_500nm", "--aod", "optical depth of the aerosol at 500 nm (default 0.1)", low=0, high=5,
          keyword="clear_sky"),
    Input("aerosol", "--aerosol", "the aerosol of the land (rural, the default) or of the sea (maritime)",
          words=("rural", "maritime"), keyword="clear_sky"),
    Input("water_cm", "--water-cm", "precipitable water (default 1.4)", "cm", 0, 20, keyword="clear_sky"),
    Input("ozone_cm", "--ozone-cm", "column of ozone (default 0.3)", "atm cm", 0, 2, keyword="clear_sky"),
    Input("pressure_hPa", "--pressure-hpa", "pressure at the surface (default: that of the altitude)", "hPa", 100,
          1200, keyword="clear_sky"),
)  # fmt: skip
"""Keys of [clear_sky]: the air of a cloudless sky, for --spectrum spectrl2 without irradiances."""

MOMENT = _by_name(
    Input("time", "--time", "date and time with Z or an offset", value="ISO8601"),
    Input("latitude_deg", "--latitude", "north positive, also as 43.4N, with --time", "deg", -90, 90),
    Input("longitude_deg", "--longitude", "east positive, also as 7.9E, with --time", "deg", -180, 180),
    Input(
        "altitude_m",
        "--altitude",
        "height above the sea, of the refraction and of the pressure of a cloudless sky (default 0)",
        "m",
        -500,
        9000,
    ),
    Input("row", "--row", "the hour of the file to take, from 1", value="N"),
    Input("weather", "--weather", "an EPW, TMY2 or TMY3 file of hours, which its head tells apart", value="FILE"),
    Input("epw", "--epw", "", value="FILE"),
    Input("tmy2", "--tmy2", "", value="FILE"),
    Input("tmy3", "--tmy3", "", value="FILE"),
)
"""When and where, or an hour of a weather file."""

AMOUNTS = ("dni", "dhi", "ghi", "epsilon", "delta")
"""Inputs that say how bright sun and sky are."""
WEATHER_FILES = ("weather", "epw", "tmy2", "tmy3")
"""Inputs that name a weather file."""

_OTHERS = _by_name(
    Input("sky", "--sky", "the diffuse sky"),
    Input("sky_options", "--sky-option", "an option of a named sky"),
    Input("diffuse_only", "--diffuse-only", "the sky without the sun's beam", is_switch=True),
    Input("polarisation", "--polarisation", "Rayleigh's pattern on the light of the sky: its largest degree of linear "
          "polarisation; 0.75 is that of a clean sky (default: photons carry none)", low=0, high=1, value="DEGREE"),
)  # fmt: skip
READING = _by_name(
    Input("bins", "--bins", "meaning of the indices of skydist.inp"),
    Input("azimuth_bins", "--azimuth-bins", "range of its azimuth indices"),
    Input("weighting", "--weighting", "meaning of its values, or the launch law of a sky"),
)
"""How a sky is read."""
INPUTS = PEREZ | SUN | MODEL | LIGHTS | CLEAR_SKY | MOMENT | READING | _OTHERS
"""All inputs of the light of a scene, by name."""


_NAMED = re.compile(r"\{(\w+)(?::([^{}]*))?\}")


def say(text: str) -> str:
    """A text with inputs by both names: "{dhi}" is "--dhi (dhi=)", "{spectrum:flat}" has the value in both."""
    return _NAMED.sub(lambda found: _word(found[1], found[2] or "") if found[1] in INPUTS else found[0], text)


def listed(names: Iterable[str]) -> str:
    """Inputs by both names, as a list for people; "disc:False" has a value."""
    *others, last = dict.fromkeys(say(f"{{{name}}}") for name in names)
    return f"{', '.join(others)} and {last}" if others else last


_OBJECTS = ("coefficients", "polarisation")
"""Inputs whose values are no text in Python."""


def _word(name: str, value: str) -> str:
    """An input by both names, with a value."""
    row = INPUTS[name]
    option, shown = f"{row.option} {value}".rstrip(), value
    if row.is_switch:
        option = f"--no-{row.option[2:]}" if value == "False" else row.option
        shown = value or "True"
    elif value and (row.words or name == "sky"):
        shown = f'"{value}"'
    return f"{option} ({row.keyword or name}={'' if name in _OBJECTS else shown})"
