"""Numbers with units: a closed table of exact factors, because general unit libraries guess.

Such a library reads AU as another unit or as a product, and works for minutes on hostile exponents. A quantity here is
a plain decimal number and one of the units below. The factor is rational, and only the result is rounded.
"""

from __future__ import annotations

import re
from enum import Enum
from fractions import Fraction

from aomc_sky.formats.report import BadValueError, quoted

MAX_DIGITS = 100
"""Longest number that is read. [characters]"""

_PREFIXES = {"a": -18, "f": -15, "p": -12, "n": -9, "u": -6, "m": -3, "c": -2, "": 0, "k": 3, "M": 6, "G": 9}
_QUANTITY = re.compile(r"(-?[0-9.]+) *([a-zA-Z][a-zA-Z0-9^-]*)\Z", re.ASCII)
# possessive: otherwise a long number with an error at its end would be tried in n^2 ways
_NUMBER = re.compile(r"[+-]?(?:[0-9]++\.?[0-9]*+|\.[0-9]++)(?:[eE][+-]?[0-9]++)?\Z", re.ASCII)
_EXPONENT = re.compile(r"-?[0-9.]+[eE][+-]?[0-9]+", re.ASCII)


class Dimension(Enum):
    """Kind of a quantity."""

    LENGTH = "length"
    AREA = "area"


def _metres(names: str, power: int, suffix: str) -> dict[str, Fraction]:
    """Units by the prefixes of their names, in the order of the document."""
    return {f"{name}{suffix}": Fraction(10) ** (_PREFIXES[name[:-1]] * power) for name in names.split()}


AU_M = 149_597_870_700
"""Astronomical unit. [m, exact by the resolution B2 of the International Astronomical Union, 2012]"""

UNITS: dict[Dimension, dict[str, Fraction]] = {
    Dimension.LENGTH: {**_metres("nm um mm m km Mm Gm", 1, ""), "AU": Fraction(AU_M)},
    Dimension.AREA: _metres("am fm pm nm um mm cm m km Mm Gm", 2, "^2"),
}
"""Units of every dimension and what they are in metres or square metres."""

_EXAMPLES = {Dimension.LENGTH: "120 km", Dimension.AREA: "0.04 fm^2"}


def parse_quantity(text: str, dimension: Dimension) -> Fraction:
    """Read ``120 km``, a decimal number without exponent and a unit of `UNITS`: exact value in m or m2."""
    if len(text) > 2 * MAX_DIGITS:
        raise BadValueError("E401", f"the value has {len(text)} characters; at most {2 * MAX_DIGITS} are read")
    match, units, example = _QUANTITY.match(text), UNITS[dimension], _EXAMPLES[dimension]
    if match is not None and match[2] in units:
        return parse_decimal(match[1]) * units[match[2]]
    named = f"{'an' if dimension is Dimension.AREA else 'a'} {dimension.value}"
    if _EXPONENT.match(text):
        message, advice = f"{quoted(text)} has an exponent", f"write all digits, such as {example}"
    elif match is not None:
        owner = next((other.value for other in Dimension if match[2] in UNITS[other]), None)
        reason = f"is a unit of {owner}" if owner else "is not a unit"
        message, advice = f"{quoted(match[2])} {reason}; expected {named}", f"write one of {', '.join(units)}"
        raise BadValueError("E401", message, advice=advice, offset=match.start(2), width=len(match[2]))
    elif _NUMBER.match(text):
        message, advice = f"{quoted(text)} has no unit", f"add one of {', '.join(units)}"
    else:
        message = f"{quoted(text)} is not {named}" if text else "the value is missing"
        advice = "write a decimal point" if "," in text else f"write a number and a unit, such as {example}"
    raise BadValueError("E401", message, advice=advice)


def parse_decimal(text: str) -> Fraction:
    """Read digits with at most one point, exactly."""
    if len(text) > MAX_DIGITS:
        message = f"the number has {len(text)} digits; at most {MAX_DIGITS} are read"
        raise BadValueError("E401", message, width=len(text))
    try:
        return Fraction(text)
    except ValueError:
        message, advice = f"{quoted(text)} is not a number", "write digits and one point"
        raise BadValueError("E401", message, advice=advice, width=len(text)) from None


def parse_real(text: str, *, offset: int = 0) -> float:
    """Read a number without unit, with or without exponent; infinity where it is beyond float64, no nan and no inf."""
    if len(text) > MAX_DIGITS:
        message = f"the number has {len(text)} characters; at most {MAX_DIGITS} are read"
        raise BadValueError("E401", message, offset=offset, width=len(text))
    if not _NUMBER.match(text):
        message = f"{quoted(text)} is not a number" if text else "a number is missing"
        advice = "write a decimal point" if "," in text else "write a number such as 0.25 or 2.5e-1"
        raise BadValueError("E401", message, advice=advice, offset=offset, width=max(len(text), 1))
    return float(text)
