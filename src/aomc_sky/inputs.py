"""Inputs of sky and sun: options, keys of sky.toml and checks of arguments are made from these rows."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Input:
    """One input: its names, its description and its allowed values."""

    name: str  #: Key of sky.toml, and argument in Python
    option: str  #: On the command line
    text: str  #: Description for --help
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    words: tuple[str, ...] = ()  #: Values of a choice, the default first
    is_switch: bool = False  #: Whether it is true or false


def in_nm(wavelength: float, shown: str) -> str:
    """What to write for a wavelength that is in micrometres, as a person gave it; else empty."""
    is_small = 0.1 <= wavelength < 20.0
    return f"wavelengths are in nm, got {shown} (micrometres?); write {1000 * wavelength:g}" if is_small else ""


def _by_name(*rows: Input) -> dict[str, Input]:
    return {row.name: row for row in rows}


PEREZ = _by_name(
    Input("dni", "--dni", "direct normal irradiance; two of --dni, --dhi, --ghi", "W m-2", 0, 10_000),
    Input("dhi", "--dhi", "diffuse horizontal irradiance", "W m-2", 0, 10_000),
    Input("ghi", "--ghi", "global horizontal irradiance", "W m-2", 0, 10_000),
    Input("epsilon", "--epsilon", "sky clearness, with --delta", low=1),
    Input("delta", "--delta", "sky brightness", low=0),
    Input("coefficients", "--coefficients", "of the sky, eq. (1)", low=-1000, high=1000),
    Input("spectrum", "--spectrum", "how beam and sky share each waveband without difcol.inp: all alike (flat), or by "
          "clear-sky spectra scaled to dni and dhi (spectrl2, which needs the extra 'weather')",
          words=("flat", "spectrl2")),
)  # fmt: skip
"""Keys of [perez]; the coefficients are its keys a to e."""

SUN = _by_name(
    Input("zenith_deg", "--sun-zenith", "zenith angle of the sun, below 90 without an atmosphere", "deg", 0, 180),
    Input("azimuth_deg", "--sun-azimuth", "azimuth of the sun, from +x (east) to +y (north)", "deg", -360, 360),
    Input("disc", "--disc", "the beam has the extent of the solar disc", is_switch=True),
)
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
