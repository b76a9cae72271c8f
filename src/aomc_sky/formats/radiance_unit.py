"""Units of spectral radiance in W m-2 nm-1 sr-1: a number, a power, an area, a wavelength and a solid angle."""

from __future__ import annotations

import re
from fractions import Fraction

RELATIVE = ("relative", "sr-1", "1")
"""Units of relative light: the second is that of our own exports, the third CF's for numbers without a unit."""
SAY_UNIT = "write --radiance-unit (radiance_unit=) 'mW m-2 nm-1 sr-1', '10^-3 W/(m2 nm sr)' or the like, or relative"

_DECADES = {
    "power": {("W", 1): 0, ("kW", 1): 3, ("mW", 1): -3, ("uW", 1): -6, ("nW", 1): -9},
    "area": {("m", -2): 0, ("cm", -2): 4, ("mm", -2): 6},
    "wavelength": {("nm", -1): 0, ("um", -1): -3, ("m", -1): -9, ("angstrom", -1): 1},
    "solid angle": {("sr", -1): 0},
}
"""Units with their exponents, and the decade of each in W m-2 nm-1 sr-1."""
_SIGNS = str.maketrans("µμ⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹\N{MINUS SIGN}·_", "uu+-0123456789-*/")
_NUMBER = r"10(?:\^[-+]?|[-+])\d{1,2}|\d{1,9}(?:\.\d{1,9})?(?:[eE][-+]?\d{1,2})?"
_TOKEN = re.compile(
    rf"[ *]*(?P<below>/|\bper\b)? *(?P<number>(?:{_NUMBER})(?![\d.^]))?[ *]*"
    r"(?P<unit>[kmun]?W|angstrom|nm|um|cm|mm|m|sr)?(?P<exponent>\^?[-+]?\d)?(?:(?![A-Za-z\d^])|(?<=W)(?=[cm]?m))"
)
_BRACKETS = re.compile(r"/ *\(([^()]*)\)\Z")
_MOST_CHARACTERS = 60


def radiance_factor(unit: str) -> float | None:
    """One unit in W m-2 nm-1 sr-1; 0 for relative light, None for any other text.

    A slash divides by the one part behind it, or by all in brackets.
    """
    text = unit.strip().translate(_SIGNS).replace("**", "^")[: _MOST_CHARACTERS + 1]
    if unit.strip().lower() in RELATIVE:
        return 0.0
    text = _BRACKETS.sub(lambda match: "/" + "/".join(re.split("[ *]+", match[1].strip())), text)
    place, number = 0, None  # type: int, Fraction | None
    found: list[tuple[str, int]] = []
    while place < len(text):
        token = _TOKEN.match(text, place)
        if token is None or not token["unit"]:
            return None
        below = -1 if token["below"] else 1
        if token["number"]:
            base, _, power = re.sub(r"^10\^?(?=[-+])", "10^", token["number"]).partition("^")
            is_between = place > 0 and not token["below"]  # W m-2 100nm-1 sr-1
            if number is not None or is_between or not float(base):
                return None
            number = (Fraction(base) ** int(power or 1)) ** below
        found.append((token["unit"], below * int((token["exponent"] or "1").lstrip("^"))))
        place = token.end()
    decade = 0
    for units in _DECADES.values():
        of_kind = [units[part] for part in found if part in units]
        if len(of_kind) != 1:
            return None
        decade += of_kind[0]
    is_plain = len(found) == len(_DECADES) and len(text) <= _MOST_CHARACTERS
    return float((number or 1) * Fraction(10) ** decade) if is_plain else None
