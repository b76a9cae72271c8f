"""Every key of a description file, and what it accepts."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np

from aomc_sky.formats.report import BadValueError, Gathered, nearest, outside, quoted
from aomc_sky.formats.units import AU_M, Dimension, parse_quantity, parse_real
from aomc_sky.skies.atmosphere.description.data import PhaseFunctionType

FORMAT_VERSION = 6
MAX_INTEGER = 2**31 - 1
"""Largest size of a texture and largest number of points that the tool accepts."""
MAX_WAVELENGTHS = 4096
"""More would say nothing new of spectra that are means over bins, and cost memory in every table."""

LOWEST_NM, HIGHEST_NM = 100, 100_000
_WHOLE = re.compile(r"\+?[0-9]+\Z", re.ASCII)
_RANGE_PART = re.compile(r"(\s*(min|max|count)\s*=\s*)(.*)\Z", re.DOTALL)


@dataclass(frozen=True, kw_only=True, slots=True)
class Spectral:
    """A spectrum; every value of it on the wavelengths lies in 0 to high; `is_glow` where its luminance counts."""

    high: float
    unit: str
    is_glow: bool = False


@dataclass(frozen=True, kw_only=True, slots=True)
class Code:
    """A code block; or a table in another file, where `or_table`."""

    or_table: bool = False


Rule = Spectral | Code | Callable[[str], Any]
"""What a key takes; a function reads its value."""


def parse_integer(text: str) -> int:
    """Read a whole number without sign; longer ones than 20 digits count as 10^20."""
    if not _WHOLE.match(text):
        message = f"{quoted(text)} is not a whole number" if text else "the value is missing"
        raise BadValueError("E401", message, advice="write digits alone")
    digits = text.lstrip("+0")
    return int(digits or "0") if len(digits) <= 20 else 10**20


def size_value(text: str, *, is_even: bool = False) -> int:
    """Read the size of a texture or a number of points."""
    value = parse_integer(text)
    if not 1 <= value <= MAX_INTEGER:
        raise BadValueError("E404", f"{quoted(text)} is outside 1 to {MAX_INTEGER}", advice="write 1 or more")
    if is_even and value % 2:
        raise BadValueError("E404", f"{value} is odd", advice=f"write an even number, such as {value + 1}")
    return value


def real_value(text: str, *, low: float, high: float) -> float:
    """Read a number without unit."""
    value = parse_real(text)
    if not low <= value <= high:
        raise outside(quoted(text), f"{low:.10g} to {high:.10g}")
    return value


def _quantity(dimension: Dimension, low: Fraction, high: int, shown: str) -> Callable[[str], float]:
    """Reader of a length or an area within limits. [m or m2]"""

    def read(text: str) -> float:
        value = parse_quantity(text, dimension)
        if not low <= value <= high:
            raise outside(quoted(text), shown)
        return float(value)

    return read


def phase_type_value(text: str) -> PhaseFunctionType:
    """Read what a file says of a phase function."""
    words = [one.value for one in PhaseFunctionType]
    if text not in words:
        message = f"{quoted(text)} is not known; the nearest is {nearest(text, words)}"
        raise BadValueError("E404", message, advice=f"write one of {', '.join(words)}")
    return PhaseFunctionType(text)


def version_value(text: str) -> int:
    """Read the version of the format; there is one."""
    value = parse_integer(text)
    if value != FORMAT_VERSION:
        message = f"{quoted(text)} is another version; this program reads {FORMAT_VERSION}"
        advice = f"write version: {FORMAT_VERSION}, if the rest of the file is of that version"
        raise BadValueError("E406", message, advice=advice)
    return value


def wavelength_values(text: str) -> np.ndarray:
    """Read ``min=400nm,max=700nm,count=16``: an even grid; a single wavelength has equal min and max. [nm]"""
    parts: dict[str, tuple[str, int]] = {}
    offset = 0
    for item in text.split(","):
        match = _RANGE_PART.match(item)
        shown = item.strip()
        if match is None or match[2] in parts:
            message = f"{quoted(shown)} is not min=, max= or count=" if match is None else f"{match[2]}= is given twice"
            advice = "write min=400nm,max=700nm,count=16"
            raise BadValueError("E401", message, advice=advice, offset=offset, width=len(item))
        parts[match[2]] = (match[3], offset + len(match[1]))
        offset += len(item) + 1
    missing = [name for name in ("min", "max", "count") if name not in parts]
    if missing:
        raise BadValueError("E401", f"no {' and no '.join(missing)}", advice="write min=400nm,max=700nm,count=16")
    gathered = Gathered()
    low, high = (gathered.attempt(partial(_limit_nm, name, *parts[name])) for name in ("min", "max"))
    count = gathered.attempt(partial(_count, *parts["count"]))
    gathered.close()
    assert low is not None and high is not None and count is not None, "no problems"  # noqa: PT018
    if low > high or (low == high) != (count == 1):
        advice = "write equal min and max, or a larger count" if count == 1 else "write min below max"
        raise BadValueError("E404", f"min {low:g} nm, max {high:g} nm, count {count}", advice=advice)
    grid = np.linspace(low, high, count)
    grid.flags.writeable = False
    return grid


def _limit_nm(name: str, text: str, offset: int) -> float:
    if text != text.rstrip():
        message = f"a blank after the value of {name}"
        raise BadValueError("E401", message, advice="remove the blank", offset=offset + len(text.rstrip()), width=1)
    try:
        value = parse_quantity(text, Dimension.LENGTH) * 10**9
    except BadValueError as problem:
        problem.message = f"{name}: {problem.message}"
        problem.offset, problem.width = offset + problem.offset, problem.width or max(len(text), 1)
        raise
    if not LOWEST_NM <= value <= HIGHEST_NM:
        limits = f"{LOWEST_NM} nm to {HIGHEST_NM} nm"
        raise outside(f"{name}: {quoted(text)}", limits, offset=offset, width=len(text))
    return float(value)


def _count(text: str, offset: int) -> int:
    shown = text.strip()
    if not (shown.isascii() and shown.isdigit()):
        message, width = f"count: {quoted(shown)} is not a whole number", max(len(shown), 1)
        raise BadValueError("E401", message, advice="write digits alone", offset=offset, width=width)
    count = parse_integer(shown)
    if not 1 <= count <= MAX_WAVELENGTHS:
        raise outside(f"count: {quoted(shown)}", f"1 to {MAX_WAVELENGTHS}", offset=offset, width=len(shown))
    return count


SIZES = (
    "transmittance texture size for vza",
    "transmittance texture size for altitude",
    "irradiance texture size for sza",
    "irradiance texture size for altitude",
    "scattering texture size for vza",
    "scattering texture size for dot(view,sun)",
    "scattering texture size for sza",
    "scattering texture size for altitude",
    "eclipsed scattering texture size for relative azimuth",
    "eclipsed scattering texture size for vza",
    "eclipsed double scattering texture size for relative azimuth",
    "eclipsed double scattering texture size for vza",
    "eclipsed double scattering texture size for sza",
    "eclipsed double scattering number of azimuth pairs to sample",
    "eclipsed double scattering number of elevation pairs to sample",
    "light pollution texture size for vza",
    "light pollution texture size for altitude",
    "light pollution angular integration points",
    "transmittance integration points",
    "radial integration points",
    "angular integration points",
    "angular integration points for eclipse",
)
"""Keys of whole numbers, in lower case as all keys here."""

WAVELENGTHS = "wavelengths"
SOLAR = "solar irradiance at toa"
ALBEDO = "ground albedo"
GLOW = "light pollution relative radiance"

TOP_KEYS: dict[str, Rule] = {
    "version": version_value,
    **dict.fromkeys(SIZES, size_value),
    "scattering texture size for vza": partial(size_value, is_even=True),
    "scattering orders": partial(real_value, low=1, high=2**31),
    "atmosphere height": _quantity(Dimension.LENGTH, Fraction(1), 10**6, "1 m to 1 Mm"),
    "earth radius": _quantity(Dimension.LENGTH, Fraction(1, 1000), 10**10, "1 mm to 10 Gm"),
    "earth-sun distance": _quantity(Dimension.LENGTH, Fraction(AU_M, 2), 10**20 * AU_M, "0.5 AU to 1e20 AU"),
    "earth-moon distance": _quantity(Dimension.LENGTH, Fraction(AU_M, 10**4), 10**20 * AU_M, "1e-4 AU to 1e20 AU"),
    WAVELENGTHS: wavelength_values,
    SOLAR: Spectral(high=1000.0, unit="W m-2 nm-1"),
    ALBEDO: Spectral(high=1.0, unit=""),
    GLOW: Spectral(high=1000.0, unit="W m-2 sr-1 nm-1 per cd m-2", is_glow=True),
}

SCATTERER_KEYS: dict[str, Rule] = {
    "number density": Code(),
    "phase function": Code(or_table=True),
    "phase function type": phase_type_value,
    "cross section at 1 um": _quantity(Dimension.AREA, Fraction(1, 10**35), 1, "1e-35 m^2 to 1 m^2"),
    "angstrom exponent": partial(real_value, low=-10, high=10),
    "single scattering albedo": Spectral(high=1.0, unit=""),
}

ABSORBER_KEYS: dict[str, Rule] = {
    "number density": Code(),
    "cross section": Spectral(high=10.0, unit="m2"),
}

SECTION_KEYS = {"scatterer": SCATTERER_KEYS, "absorber": ABSORBER_KEYS}

EXAMPLES = {
    WAVELENGTHS: "wavelengths: min=400nm,max=700nm,count=16",
    SOLAR: "solar irradiance at TOA: file solar.csv",
    "atmosphere height": "atmosphere height: 120 km",
    "earth radius": "Earth radius: 6371 km",
    "scattering orders": "scattering orders: 4",
    "number density": "number density: and a code block below",
    "phase function": "phase function: file aerosol.csv, or a code block below",
    "cross section at 1 um": "cross section at 1 um: 0.03914 fm^2",
    "angstrom exponent": "angstrom exponent: 4.095",
    "cross section": "cross section: file ozone.csv",
}
"""What to write for a required key that is missing; without one, a description or a section of it says too little."""

DIRECTIVES = ("all textures are radiances", "no eclipsed double scattering textures")
SCATTERER_DIRECTIVE = "needs interpolation guides"
