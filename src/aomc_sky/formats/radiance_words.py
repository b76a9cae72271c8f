"""Words for radiances of the sky that tables and fields share: names, units of angles and wavelengths, gaps."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from aomc_sky.formats.azimuth_words import speaks_of_azimuths

_ROLES = {
    name: role
    for role, names in {
        "zenith": "zenith zenith_angle za zen vza theta θ polar_angle sky_zenith sky_zenith_angle view_zenith "
        "viewing_zenith view_zenith_angle viewing_zenith_angle",
        "elevation": "elevation elevation_angle elev el altitude altitude_angle alt sky_elevation view_elevation "
        "elev_angle",
        "azimuth": "azimuth azimuth_angle az azi phi φ ϕ vaa sky_azimuth sky_azimuth_angle view_azimuth "
        "viewing_azimuth view_azimuth_angle viewing_azimuth_angle",
        "relative azimuth": "relative_azimuth relative_azimuth_angle raa azimuth_from_sun rel_azimuth",
        "wavelength": "wavelength wavelengths wave_length wl wvl lambda lam λ nm",
        "radiance": "radiance sky_radiance spectral_radiance l lsky l_sky",
    }.items()
    for name in names.split()
}
_OF_THE_SKY = (
    "sky", "mean", "average", "avg", "median", "measured", "value", "values", "total", "down", "downwelling", "angle",
    "deg", "degree", "degrees", "rad", "radian", "radians",
)  # fmt: skip
"""What names may add before a unit in brackets: radiance_mean (W m-2 nm-1 sr-1)."""
_WIDE = re.compile(r"(?:(?:(?:sky|spectral)[_ ]?)?radiance|l(?:_?sky)?)?[_ ]*(\d{3,4}(?:\.\d+)?)[_ ]*(?:nm)?", re.I)
KEYS = {
    key: name
    for name, keys in {
        "azimuth": "azimuth azimuths azimuth_convention",
        "angle": "angle_unit angle_units angles",
        "radiance": "radiance_unit radiance_units radiance unit units",
        "sun_zenith": "sun_zenith solar_zenith sun_zenith_angle solar_zenith_angle sza",
        "sun_azimuth": "sun_azimuth solar_azimuth sun_azimuth_angle solar_azimuth_angle saa",
        "wavelength": "wavelength wave_length wl lambda",
    }.items()
    for key in keys.split()
}
"""Keys of lines '# key: value', and their subjects."""

GAPS = ("", "nan", "na", "n/a", "null", "none", "-", "--")
GAP_NUMBERS = (-999.0, -9999.0, 1e20, float(np.float32(1e20)))  #: The last two are those of climate models.
MAX_RADIANCE = 1e30
"""Larger numbers are fill values, in any unit."""
_NINES = re.compile(r"9{3,7}|9{2,5}\.9{1,3}")  #: Numbers of nines alone, from 99.9 on.
_LARGEST = (32767.0, 65535.0)  #: The largest whole numbers of two bytes.
_FILL, _FILL_BEYOND = 1e10, 1e6  #: Numbers from here on, so many times the next radiance, are likely fill values.
_FAR_BEYOND = 2.0  #: So many times the next radiance is a number of nines a gap rather than a radiance.
_FAR_BEYOND_DECIMAL = 5.0  #: The same of nines with decimals: a rounded radiance next to the sun may have them.

TRUE_NORTH = ("degree_true", "degrees_true", "deg_true")
"""Units of CF for angles clockwise from north."""
ANGLE_DEGREES = {
    **dict.fromkeys(("deg", "degree", "degrees", "°", *TRUE_NORTH), 1.0),
    **dict.fromkeys(("rad", "radian", "radians"), 180 / np.pi),
}
"""Units of an angle, in degrees, by their `plain_unit`."""
SAY_ANGLE = "write --angle-unit deg or rad (angle_unit=)"
SAY_SUN = "write --sun-azimuth DEG, from east towards north (sun_azimuth_deg=)"

_METRES = [f"met{end}" for end in ("er", "ers", "re", "res")]
LENGTH_NM = {
    **dict.fromkeys(("nm", *(f"nano{one}" for one in _METRES)), 1.0),
    **dict.fromkeys(("um", "micron", "microns", *(f"micro{one}" for one in _METRES)), 1e3),
    **dict.fromkeys(("angstrom", "angstroms", "a", "å"), 0.1),
    **dict.fromkeys(("m", *_METRES), 1e9),
}
"""Units of a wavelength, in nm, by their `plain_unit`."""
LEAST_NM, MOST_NM = 20.0, 1e5
"""Wavelengths outside of these, in nm as they are read, have another unit."""
ON_ZENITHS = re.compile(r"\b(?:zeniths?|theta|view(?:ing)? angles?)\b", re.I)
"""Names of zenith angles in a text."""
FROM_HORIZON = re.compile(
    r"(?<!sun )(?<!solar )(?<!site )(?<!station )(?<!sun's )\b(?:elevation|altitude)s?\b(?!\W*\d)(?! of (?:the )?s)"
    r"|(?<!sun )\b(?:from|above|over) (?:the )?horizon\b(?! to)|(?<![=:] )(?<!180 )(?<! is )(?<! at )(?<! to )\bnadir\b"
    r"|(?<![\d.])0 ?(?:deg\w*|°)? ?(?:=|is|at|:)? ?(?:the )?(?:horizon|nadir)\b"
    r"|\b90 ?(?:deg\w*|°)? ?(?:=|is|at|:) ?(?:the )?(?:zenith|overhead|vertical)\b",
    re.I,
)
"""Words of a text on angles that are no zenith angles; those of the sun or a site are on something else."""
COSINES = re.compile(r"\b(?:cos|cosines?)\b", re.I)
STATED_FACTOR = re.compile(
    r"\b(?:multiply(?![ -]scatter)|multiplied|divided?|scaled?|scaling|factor)\b|\bunits? of (?:1e|10 ?\^?)[-+]?\d"
    r"|\b(?:radiances?|values)\b[^.;:]{0,40}?(?<!\d)(?<!\d )(?:\b(?:x|times)|[*\N{MULTIPLICATION SIGN}])"
    r" ?1(?:0{2,}|0 ?\^|e[-+]?\d)"  # no 1000 x 1000 pixels
    r"|\bradiances? per (?!1 ?nm)\d+(?:\.\d+)? ?nm\b"
    r"|\b(?:sun|solar)[- ]normali[sz]ed\b|\bnormali[sz]ed (?:to|by|with)\b",
    re.I,
)
"""Words of a text on radiances that are in another unit than the one stated."""
_WEIGHTED = re.compile(
    r"\b(?:cosine|cos|solid[ -]angle)[ -]weight(?:ed|ing)\b"
    r"|\b(?:weighted (?:by|with)|radiances? ?(?:x|times|multiplied by|[*\N{MULTIPLICATION SIGN}])) ?(?:the )?"
    r"(?:cos\w*|mu|sin\w*|solid angles?)\b",
    re.I,
)
"""Words of a text on numbers that are radiances times something of their direction."""
SAY_WEIGHTED = "write radiances: divide the numbers by it, and clear this text"
LOGARITHM = re.compile(
    r"\b(?:log10|logarithms?|logarithmic|ln)\b(?=.*radiance)|\bvalues are log(?:10|arithm)"
    r"|\blog[ (]+(?:of )?(?:the )?radiance|(?<=radiance)s?\W+log10\b",
    re.I,
)
"""Words of a text on radiances that are no radiances."""
MOST_SAID = 1000
"""Characters of a sentence that are looked at: patterns that look ahead are quadratic in its length."""
_FACTORS = {"scale", "scales", "scaling", "scalefactor", "factor", "factors", "multiplier", "slope", "gain"}
_FACTORS |= {"intercept", "offset", "offsets"}
_OF_THE_PAST = {"calibration", "correction", "time", "immersion"}
SAY_FACTOR = (
    "write the factor as a part of the unit: --radiance-unit '10^-3 W m-2 nm-1 sr-1' (radiance_unit=), or relative"
)

_TRAVEL = re.compile(
    r"(?<!error )(?<!errors )(?<!uncertainty )\b(?:propagat\w+|travel\w*)\b"
    r"(?! of (?:the |a |our )?(?:ship|vessel|boat|aircraft|errors?|uncertaint\w+)\b)",
    re.I,
)
_OF_LIGHT = re.compile(r"\b(?:directions?|angles?|zeniths?|azimuths?|vectors?)\b", re.I)
SAY_COMES_FROM = (
    "write the directions that light comes from: 180 degrees minus the zenith angle, the azimuth plus 180 degrees, and "
    "clear this text"
)


_BESIDE_UNITS = re.compile(r"[,;:=()\[\]]|\b(?:in|are|is|of|as)\b")
_FILLS = ("fillvalue", "missingvalue", "missingvalues", "nodata", "nodatavalue", "fill", "missing")
"""Attributes of numbers that stand for a gap, in small letters and without signs."""


def names_fill(name: str) -> bool:
    """Whether an attribute is of numbers that stand for a gap."""
    return re.sub(r"[\W_]+", "", name.lower()) in _FILLS


def is_factor(name: str) -> bool:
    """Whether an attribute is a factor or an offset by a name that CF does not know; a calibration is past."""
    words = set(re.split(r"[\W_]+", name.lower()))
    return name not in ("scale_factor", "add_offset") and bool(words & _FACTORS) and not words & _OF_THE_PAST


def parts_of(text: str) -> list[str]:
    """The parts of a sentence, one of which may be a unit."""
    return [part.strip() for part in _BESIDE_UNITS.split(text)]


def weight_of(text: str) -> str:
    """The words of a text that its radiances are multiplied by a cosine or a solid angle; a weighted mean is none."""
    found = None if re.search(r"\b(?:mean|averag)", text, re.I) else _WEIGHTED.search(text)
    return found[0] if found else ""


def travel_of(text: str) -> str:
    """The word of a text that says that its directions are those that light goes to, or an empty text."""
    for sentence in re.split(r"[.;](?:\s|\Z)", text.replace("_", " ")):
        if (found := _TRAVEL.search(sentence)) and _OF_LIGHT.search(sentence):
            return found[0]
    return ""


def by_wavelength(nm: np.ndarray) -> list[np.ndarray]:
    """Indices of the points of each wavelength."""
    order = np.argsort(nm, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(nm[order]) != 0) + 1)


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


_FEW, _MOST_OF_IT = 4, 0.75  #: So many angles, over so much of the sky, are judged by their range.


def plain_unit(unit: str) -> str:
    """A unit in small letters, with u for micro."""
    return unit.strip().lower().replace("µ", "u").replace("μ", "u")


def have_look_of_degrees(values: np.ndarray) -> bool:
    """Whether numbers are beyond all radians of a turn."""
    return bool(np.any(np.abs(values) > 2 * np.pi))


def may_be_radians(values: np.ndarray, *, is_azimuth: bool) -> bool:
    """Whether angles of a whole sky, in degrees as the file says, are within a turn in radians."""
    known = np.unique(values[np.isfinite(values)])
    if known.size < _FEW:
        return False
    reach, turn = (np.ptp(known), 2 * np.pi) if is_azimuth else (np.abs(known).max(), np.pi / 2)
    return bool(_MOST_OF_IT * turn < reach < 1.001 * turn)


def unit_and_counts(text: str) -> tuple[str, str]:
    """The unit of an azimuth, and the words on where it counts from, such as "deg" and "e of n"."""
    if plain_unit(text) in TRUE_NORTH:
        return "deg", "clockwise from north"
    if not speaks_of_azimuths(text):
        return text, ""
    words = re.split(r"[\s,()]+", plain_unit(text))
    rest = " ".join(word for word in words if word not in ANGLE_DEGREES)
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
    text = re.sub(r"\((\d{3,4}(?:\.\d+)?) ?(?:nm)?\)(?=\s*[(\[])", r"_\1", text)  # Lsky(550) [mW m-2 nm-1 sr-1]
    text = re.sub(r"^([^(\[]*?)[ _]in[ _](?=\S)(.*)", r"\1 (\2)", text)  # radiance in mW/(m2 nm sr)
    match = re.fullmatch(r"([^(\[]*?)\s*[(\[](?:in )?(.*?)[)\]]?", text)
    name, unit = (match[1], match[2].strip()) if match else (text, "")
    if re.fullmatch(r"\d+(\.\d+)?\s*nm|\d{3,4}", unit):  # L (412 nm)
        name, unit = f"{name}_{unit}", ""
    wide = _WIDE.fullmatch(name.strip())
    if wide:
        return Name("radiance", unit, float(wide[1]))
    parts = re.sub(r"[\W_]+", "_", name).strip("_").split("_")
    for k in range(len(parts), 0, -1):  # zenith_deg, radiance_W_m2_nm_sr
        role = _ROLES.get("_".join(parts[:k]).lower())
        if role:
            rest = " ".join(parts[k:])
            if role == "radiance" and re.match(r"\d", rest):
                return None  # L_412_std
            is_more = role.endswith("azimuth") and speaks_of_azimuths(rest)  # azimuth from north (deg)
            is_other = role == "radiance" and rest.lower() not in (*_OF_THE_SKY, plain_unit(unit))
            is_other |= role in ("zenith", "elevation", "azimuth") and re.search(r"\b(?:sun|solar)\b", rest) is not None
            if unit and rest and not is_more and is_other:
                return None  # L_w (mW m-2 nm-1 sr-1), radiance_std (...)
            return Name(role, f"{unit} {rest}".strip() if is_more else unit or rest)
    return None
