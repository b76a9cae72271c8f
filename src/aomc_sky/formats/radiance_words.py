"""Words for measured radiances as people write them: names of columns, units, and where azimuths count from."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

_ROLES = {
    name: role
    for role, names in {
        "zenith": "zenith zenith_angle za zen vza theta polar_angle sky_zenith view_zenith viewing_zenith "
        "view_zenith_angle viewing_zenith_angle",
        "elevation": "elevation elevation_angle elev el altitude altitude_angle alt sky_elevation view_elevation",
        "azimuth": "azimuth azimuth_angle az azi phi vaa sky_azimuth view_azimuth viewing_azimuth view_azimuth_angle "
        "viewing_azimuth_angle",
        "relative azimuth": "relative_azimuth relative_azimuth_angle raa azimuth_from_sun rel_azimuth",
        "wavelength": "wavelength wavelengths wave_length wl wvl lambda lam nm",
        "radiance": "radiance sky_radiance spectral_radiance l lsky l_sky",
    }.items()
    for name in names.split()
}
_WIDE = re.compile(r"(?:(?:(?:sky|spectral)[_ ]?)?radiance|l(?:_?sky)?)?[_ ]*(\d{3,4}(?:\.\d+)?)[_ ]*(?:nm)?", re.I)
KEYS = {
    key: name
    for name, keys in {
        "azimuth": "azimuth azimuths azimuth_convention",
        "angle": "angle_unit angle_units angles",
        "radiance": "radiance_unit radiance_units radiance unit units",
        "sun_zenith": "sun_zenith solar_zenith sun_zenith_angle solar_zenith_angle sza",
        "sun_azimuth": "sun_azimuth solar_azimuth sun_azimuth_angle solar_azimuth_angle saa",
        "wavelength": "wavelength",
    }.items()
    for key in keys.split()
}
"""Keys of lines '# key: value', and their subjects."""

GAPS = ("", "nan", "na", "n/a", "null", "none", "-", "--")
GAP_NUMBERS = (-999.0, -9999.0)
CONVENTIONS = ("north_clockwise", "enu_from_east", "west_of_south", "from_sun", "from_sun_clockwise")
"""From where azimuths may count: members of `AzimuthConvention`, or the sun (counterclockwise by default)."""

ANGLE_DEGREES = {
    **dict.fromkeys(("deg", "degree", "degrees", "°"), 1.0),
    **dict.fromkeys(("rad", "radian", "radians"), 180 / np.pi),
}
"""Units of an angle, in degrees, by their `plain_unit`."""
LENGTH_NM = {
    **dict.fromkeys(("nm", "nanometer", "nanometers", "nanometre", "nanometres"), 1.0),
    **dict.fromkeys(("um", "micron", "micrometer", "micrometers", "micrometre", "micrometres"), 1e3),
    "m": 1e9,
}
"""Units of a wavelength, in nm, by their `plain_unit`."""
_RELATIVE = ("relative", "rel", "arbitrary", "arb", "a.u.", "au", "counts", "dn", "1", "dimensionless", "unitless")
_PARTS = (
    {"w": 1.0, "kw": 1e3, "mw": 1e-3, "uw": 1e-6, "nw": 1e-9},
    {"m2": 1.0, "cm2": 1e4, "mm2": 1e6},
    {"nm": 1.0, "um": 1e-3, "micron": 1e-3, "angstrom": 10.0},
    {"sr": 1.0, "str": 1.0, "ster": 1.0, "steradian": 1.0},
)
_PLAIN = str.maketrans("µμ⁻¹²·\u2212/*^_", "uu-12 -    ")


def plain_unit(unit: str) -> str:
    """A unit in small letters and plain signs."""
    return unit.strip().lower().translate(_PLAIN)


_SHORT = {"n": "north", "e": "east", "s": "south", "w": "west", "x": "east", "cw": "clockwise"}
_SHORT |= dict.fromkeys(("ccw", "acw"), "counterclockwise")
_OF = {("east", "north"): "north_clockwise", ("north", "east"): "enu_from_east", ("west", "south"): "west_of_south"}
_COUNTS = re.compile(r"\b(?:a?c?cw|(?:counter|anti)?clockwise|north|east|south|west|from|relative|[nesw] of)\b")


def radiance_factor(unit: str) -> float | None:
    """A unit in W m-2 nm-1 sr-1, 0 for relative radiances; any other word gives None.

    A unit has four parts: power, area, wavelength and solid angle. Signs, slashes and brackets add nothing.
    """
    if unit.strip().lower() in _RELATIVE:
        return 0.0
    words = re.findall(r"[a-z]+2?", re.sub(r"(?<=m)[ -]*(?=2)", "", plain_unit(unit).replace("per", " ")))
    found = [[part[word] for word in words if word in part] for part in _PARTS]
    is_whole = len(words) == 4 and all(len(one) == 1 for one in found)
    return float(np.prod(found)) if is_whole else None


def convention_of(text: str) -> str | None:
    """The convention in words such as "clockwise from north", or None."""
    plain = text.lower().replace("_", " ").replace("anti", "counter").replace("r-c", "rc")
    found = [_SHORT.get(word, word) for word in re.findall(r"[a-z]+", plain)]
    words = set(found)
    is_counter = "counterclockwise" in words or ("counter" in words and "clockwise" in words)
    is_clockwise = "clockwise" in words and not is_counter
    if words & {"sun", "solar"}:
        return "from_sun_clockwise" if is_clockwise else "from_sun"
    turn = re.search(r"(north|east|south|west) of (?:the )?(north|east|south|west)", " ".join(found))
    if turn:
        return _OF.get((turn[1], turn[2]))
    if {"west", "south"} <= words:
        return "west_of_south"
    start = next((word for word in found if word in ("north", "east")), None)
    if start == "north":
        return None if is_counter else "north_clockwise"
    return "enu_from_east" if start == "east" and not is_clockwise else None


def unit_and_counts(text: str) -> tuple[str, str]:
    """The unit of an azimuth, and the words on where it counts from, such as "deg" and "e of n"."""
    words = re.split(r"[\s,()]+", plain_unit(text))
    rest = " ".join(word for word in words if word not in ANGLE_DEGREES)
    if not _COUNTS.search(rest):
        return text, ""
    return next((word for word in words if word in ANGLE_DEGREES), ""), rest


class Name(NamedTuple):
    """Meaning of the name of a column."""

    role: str
    unit: str
    wavelength_nm: float | None = None  #: of a column for one wavelength

    @property
    def slot(self) -> str:
        """The quantity that the column gives in the end."""
        return {"elevation": "zenith", "relative azimuth": "azimuth"}.get(self.role, self.role)


def name_of_column(text: str) -> Name | None:
    """Read a name of a column; an unknown name gives None."""
    match = re.fullmatch(r"([^(\[]*?)\s*[(\[](.*?)[)\]]*", text)
    name, unit = (match[1], match[2].strip()) if match else (text, "")
    if re.fullmatch(r"\d+(\.\d+)?\s*nm", unit):  # L (412 nm)
        name, unit = f"{name}_{unit}", ""
    wide = _WIDE.fullmatch(name.strip())
    if wide:
        return Name("radiance", unit, float(wide[1]))
    parts = re.sub(r"[\W_]+", "_", name.lower()).strip("_").split("_")
    for k in range(len(parts), 0, -1):  # zenith_deg, radiance_W_m2_nm_sr
        role = _ROLES.get("_".join(parts[:k]))
        if role:
            rest = " ".join(parts[k:])
            is_more = role.endswith("azimuth") and _COUNTS.search(rest)  # azimuth from north (deg)
            return Name(role, f"{unit} {rest}".strip() if is_more else unit or rest)
    return None
