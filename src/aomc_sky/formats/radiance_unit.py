"""Units of spectral radiance as people write them, in W m-2 nm-1 sr-1."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fractions import Fraction
from itertools import islice
from typing import NamedTuple

SAY_UNIT = "write --radiance-unit (radiance_unit=) '10^-3 W m-2 nm-1 sr-1', 'uW/(cm^2 nm sr)' or the like, or relative"
_RELATIVE = (
    "relative", "rel", "arbitrary", "arb", "a.u.", "au", "counts", "dn", "1", "dimensionless", "unitless", "sr-1",
    "1/sr", "relative units", "rel. units", "arbitrary units", "arb. units", "normalized", "normalised", "%", "percent",
)  # fmt: skip
_MOST_CHARACTERS = 100
_LARGEST_EXPONENT = 40

_PREFIXES = {"": 0, "k": 3, "K": 3, "M": 6, "m": -3, "u": -6, "n": -9}
_LONG_PREFIXES = {"": 0, "kilo": 3, "mega": 6, "centi": -2, "milli": -3, "micro": -6, "nano": -9}
_POWER = {
    **{f"{prefix}{w}": decade for prefix, decade in _PREFIXES.items() for w in "Ww" if prefix + w != "Mw"},
    **{f"{prefix}watt{s}": decade for prefix, decade in _LONG_PREFIXES.items() for s in ("", "s")},
}
"""Units of power, and their decades in W."""
_LENGTH = {
    "nm": -9,
    "um": -6,
    "mm": -3,
    "cm": -2,
    "m": 0,
    "micron": -6,
    "microns": -6,
    **dict.fromkeys(("A", "angstrom", "angstroms"), -10),
    **{
        f"{prefix}{name}": decade
        for prefix, decade in _LONG_PREFIXES.items()
        for name in ("meter", "meters", "metre", "metres")
    },
}
"""Units of length, and their decades in m."""
_SOLID_ANGLE = ("sr", "str", "ster", "steradian", "steradians")
_WAVENUMBER = ("cm", "centimeter", "centimetre")  #: 1/cm is never per wavelength

_SIGNS = str.maketrans(
    "µμ⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹\N{MINUS SIGN}\N{EN DASH}\N{MULTIPLICATION SIGN}·\N{DOT OPERATOR}Å{}[]$",
    "uu+-0123456789--***A     ",
)
_ON_RADIANCES = re.compile(r"\b(?:radiances?|l|values|data|units?)\b", re.I)
_NOT_ON_RADIANCES = re.compile(
    r"\b(?:uncertaint|error|noise|std|deviation|calibrat|threshold|min|max|detect|mean of)", re.I
)
_BEFORE_UNIT = re.compile(r"\b(?:in|are|is|of|as|units?)\b|[:=(\[,]", re.I)
_AFTER_UNIT = re.compile(r"[,;)\]]| \(|\Z")
_MOST_UNIT, _MOST_STARTS = 100, 12  #: Characters of a unit, and places of a sentence where one is looked for.
_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)(?:\s*\^\s*(?P<power>[+-]?\d+))?(?![\d.])"
    r"|(?P<per>/|\bper\b)|(?P<open>\()|(?P<close>\))|(?P<unit>[A-Za-z]+)(?:\s*\^?\s*(?P<exponent>[+-]?\d+))?(?![\d.]))\s*"
)


class _Part(NamedTuple):
    """A number or a unit with its exponent, as it stands."""

    text: str
    exponent: int
    is_below: bool  #: Whether it stands below a slash
    is_signed: bool  #: Whether its exponent is negative as it stands


def radiance_factor(unit: str) -> float | None:
    """One unit in W m-2 nm-1 sr-1; 0 for relative radiances, None for any other text.

    A unit is numbers, a power, an area, a wavelength and a solid angle, with prefixes and exponents. A slash, or "per",
    is for the next part or brackets, and for all that follow where only this gives a radiance. Without any sign
    (``W_m2_nm_sr``, as in names) all parts after the power are divided by.
    """
    plain = unit.strip().translate(_SIGNS)
    if plain.lower() in _RELATIVE:
        return 0.0
    parts = _parts(plain)
    is_unclear = (plain == plain.upper() and "MW" in plain) or re.search(r"\b10\*[-+]?\d", plain)  # mega; UCUM's 10^3
    if parts is None or is_unclear:
        return None
    factor = _factor(parts)
    if factor is not None:
        return factor
    starts = [k for k, part in enumerate(parts) if part.is_below]
    if not starts and not any(part.is_signed for part in parts):
        starts = [k + 1 for k, part in enumerate(parts) if part.text in _POWER]
    is_below = [starts != [] and k >= starts[0] and not part.is_signed for k, part in enumerate(parts)]
    return _factor(
        [
            part._replace(exponent=-abs(part.exponent)) if below else part
            for part, below in zip(parts, is_below, strict=True)
        ]
    )


def _parts(plain: str) -> list[_Part] | None:
    """Numbers and units from left to right; None where something else stands."""
    text = re.sub(r"(?<!\d)\.|\.(?!\d)|-(?=[A-Za-z])", " ", plain.replace("**", "^").replace("_", " "))
    text = re.sub(r"\^ ?\(([-+]?\d+)\)", r"^\1", text)
    text = re.sub(r"(?<![A-Za-z])([kMmun]?W)(?=[munc]?m\b|[munc]?m[-^\d])", r"\1 ", text)  # Wm-2
    text = re.sub(r"\(([^()]*)\) ?\^? ?-1\b", r"/(\1)", text).replace("*", " ")
    text = re.sub(r"\b10(?=[+-]\d)", "10^", re.sub(r"(?<=[\d ])x(?= ?10)", " ", text)).strip()
    parts: list[_Part] = []
    groups, is_divided, at = [False], False, 0  # whether each open bracket, and the next part, is divided by
    while at < len(text):
        token = _TOKEN.match(text, at)
        if token is None or len(text) > _MOST_CHARACTERS:
            return None
        at = token.end()
        if token["per"]:
            is_divided = True
        elif token["close"]:
            groups.pop()
            if not groups:
                return None
        else:
            below, is_divided = groups[-1] != is_divided, False
            if token["open"]:
                groups.append(below)
                continue
            exponent = int(token["power"] or token["exponent"] or 1)
            has_unit = any(part.text[-1].isalpha() for part in parts)
            if abs(exponent) > _LARGEST_EXPONENT or (token["number"] and not below and has_unit):
                return None  # a number after the units is no factor that a reader is sure of
            parts.append(_Part(token["number"] or token["unit"], -exponent if below else exponent, below, exponent < 0))
    if parts and parts[-1].is_below and not parts[-1].text[-1].isalpha():
        return None  # W m-2 nm-1 sr-1 / 1000: of the unit, or of the values?
    return parts if len(groups) == 1 and not is_divided else None


def _factor(parts: Sequence[_Part]) -> float | None:
    """The value of parts that are a spectral radiance, rounded once; None for another quantity."""
    decade, number = -9, Fraction(1)  # of one per m of wavelength
    powers, angles, lengths = [], [], []
    for text, exponent, *_ in parts:
        name = text if text in _LENGTH or text in _POWER else text.lower()
        if name in _POWER:
            if name != text and not text.isupper() and "watt" not in name:  # Mw
                return None
            powers.append(exponent)
            decade += _POWER[name] * exponent
        elif name in _LENGTH:
            lengths.append(exponent)
            decade += _LENGTH[name] * exponent
            if exponent == -1 and name.removesuffix("s") in _WAVENUMBER:
                return None
        elif name in _SOLID_ANGLE:
            angles.append(exponent)
        elif name[-1].isdigit() or name[-1] == ".":
            number *= Fraction(text) ** exponent if number and float(text) else 0
        else:
            return None
    if powers != [1] or angles != [-1] or sorted(lengths) not in ([-2, -1], [-3]):
        return None
    try:
        factor = float(number * Fraction(10) ** decade)
    except OverflowError:
        return None
    return factor or None


def unit_in(text: str) -> tuple[int, str] | None:
    """Start and text of the unit of radiances in a sentence: "All radiances are in mW/(m2 nm sr)"."""
    if not re.search("sr|ste?r", text) or not _ON_RADIANCES.search(text) or _NOT_ON_RADIANCES.search(text):
        return None
    for before in islice(_BEFORE_UNIT.finditer(text), _MOST_STARTS):
        start = before.end() + len(text[before.end() :]) - len(text[before.end() :].lstrip())
        ends = [one.start() for one in _AFTER_UNIT.finditer(text, start, start + _MOST_UNIT)]
        for end in reversed(ends):
            unit = text[start:end].rstrip(" .]")
            if re.match(r"[^\W\d]|10 ?[\^*+-]|1e", unit) and radiance_factor(unit):
                return start, unit
    return None
