"""Types of options: the value of a text, or what is wrong with it."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable
from decimal import Decimal, InvalidOperation
from typing import Any

from aomc_sky.options import Kind, in_nm

_SUFFIXES = {"": 1, "k": 2**10, "m": 2**20, "g": 2**30, "t": 2**40}


def whole_number(text: str) -> int:
    """A whole number, also as 1e6."""
    try:
        value = Decimal(text)
        if value == value.to_integral_value() and abs(value) < Decimal(10) ** 30:
            return int(value)
    except InvalidOperation:
        pass
    raise argparse.ArgumentTypeError(f"expected a whole number, for example 1000000 or 1e6, got {text!r}")


def finite_number(text: str) -> float:
    """A finite number."""
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
        if "," in text:
            raise argparse.ArgumentTypeError(
                f"expected a finite number, got {text!r}; write several with blanks between them, decimals with a point"
            ) from None
    if not abs(value) < float("inf"):
        raise argparse.ArgumentTypeError(f"expected a finite number, got {text!r}")
    return value


def whole_number_in(low: float, high: float) -> Callable[[str], int]:
    """Type of an option that is a whole number from `low` to `high`."""

    def number(text: str) -> int:
        value = whole_number(text)
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"expected {_plain(low)} to {_plain(high)}, got {text}")
        return value

    return number


def _plain(limit: float) -> str:
    return f"{limit:g}" if math.isinf(limit) else str(int(limit))


def photon_total(text: str) -> int:
    """Iterations, 1 or more; for more than 2^62 the scene reports that it cannot be sampled."""
    value = whole_number(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"expected 1 to 2^62 iterations, got {text}")
    return value


def memory(text: str) -> int:
    """A memory size such as 500M or 2G. [bytes]"""
    number = text.strip().lower().removesuffix("b").removesuffix("i")
    suffix = number[-1:] if number[-1:].isalpha() else ""
    try:
        value = int(float(number.removesuffix(suffix)) * _SUFFIXES[suffix])
    except (ValueError, KeyError, OverflowError):
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"expected a size such as 500M or 2G, got {text!r}")
    return value


def degrees(positive: str, negative: str) -> Callable[[str], float]:
    """Type of a latitude or longitude, also as 43.4N."""

    def angle(text: str) -> float:
        side = text.strip()[-1:].upper()
        number = text.strip()[:-1] if side in (positive, negative) else text
        if re.fullmatch(r"[+-]?\d+,\d+", number):
            raise argparse.ArgumentTypeError(f"decimals follow a point: write {number.replace(',', '.')}")
        value = finite_number(number)
        if side not in (positive, negative):
            return value
        if value < 0:
            raise argparse.ArgumentTypeError(f"{text!r} has a sign and a letter; write one of them")
        return -value if side == negative else value

    return angle


_MOST_STEPS = 10_000


def stepped(text: str, read: Callable[[str], float] = finite_number) -> list[float]:
    """The numbers of START:END:STEP; END is one of them if a step reaches it. `read` is the type of its ends."""
    parts = text.split(":")
    if len(parts) == 2:
        raise argparse.ArgumentTypeError(f"{text!r} has no step; write {text}:10 for steps of 10")
    if len(parts) != 3 or not finite_number(parts[2]) > 0 or read(parts[1]) < read(parts[0]):
        raise argparse.ArgumentTypeError(f"expected START:END:STEP, END not below START and STEP above 0, got {text!r}")
    start, end, step = read(parts[0]), read(parts[1]), finite_number(parts[2])
    count = int((end - start) / step * (1 + 1e-12)) + 1
    if count > _MOST_STEPS:
        raise argparse.ArgumentTypeError(f"{count} numbers in {text!r}; at most {_MOST_STEPS}")
    return [round(start + k * step, 10) for k in range(count)]


def wavelength(text: str) -> float:
    """A number in nm; one in micrometres is refused."""
    try:
        number = finite_number(text)
    except argparse.ArgumentTypeError as error:
        raise argparse.ArgumentTypeError(f"{error}; write 412 443 555, or 400:700:10") from None
    if advice := in_nm(number, repr(text)):
        raise argparse.ArgumentTypeError(advice)
    return number


def wavelengths(text: str) -> list[float]:
    """Wavelengths in the one word that `Parser` makes of a list, also as 400:700:10. [nm]"""
    if re.search(r"(^|,)\s*,", text) and text.strip(", "):
        raise argparse.ArgumentTypeError(f"no wavelength stands before a comma of {text!r}; write 440,550")
    parts = text.replace(",", " ").split()
    if any(re.fullmatch(r"\d\d?", part) for part in parts[1:]):
        raise argparse.ArgumentTypeError(f"expected wavelengths in nm, got {text!r}; decimals follow a point: 412.5")
    numbers = [
        number for part in parts for number in (stepped(part, wavelength) if ":" in part else [wavelength(part)])
    ]
    if not numbers or min(numbers) <= 0:
        raise argparse.ArgumentTypeError(f"expected positive wavelengths in nm, got {text!r}")
    return numbers


def number_in(low: float, high: float) -> Callable[[str], float]:
    """Type of an option that is a number in a range."""

    def number(text: str) -> float:
        from aomc_sky.formats.report import BadValueError
        from aomc_sky.formats.sky_toml import keys

        try:
            return float(keys.number(low, high)(float(text)))
        except ValueError:
            raise argparse.ArgumentTypeError(f"expected a number, got {text!r}") from None
        except BadValueError as problem:
            raise argparse.ArgumentTypeError(problem.message) from None

    return number


def moment(text: str) -> float:
    """A time with its zone, or seconds since 1970."""
    from aomc_sky.formats.report import BadValueError
    from aomc_sky.formats.sky_toml import keys

    is_number = text.lstrip("+-").replace(".", "", 1).isdecimal()
    try:
        return keys.time(float(text) if is_number else text)
    except BadValueError as problem:
        raise argparse.ArgumentTypeError(f"{problem.message}; {problem.advice}") from None


_MOST_SUNS = 1000


def suns(text: str) -> tuple[float, ...] | None:
    """Zenith angles with commas or START:END:STEP; None for all of the description. [deg]"""
    if text == "all":
        return None
    found = tuple(stepped(text)) if ":" in text else tuple(sorted(map(finite_number, text.split(","))))
    if any(not 0 <= sun <= 180 for sun in found):
        raise argparse.ArgumentTypeError(f"expected zenith angles from 0 to 180 degrees, got {text!r}")
    if len(found) > _MOST_SUNS:
        raise argparse.ArgumentTypeError(f"{len(found)} suns in {text!r}; at most {_MOST_SUNS}")
    if len(set(found)) < len(found):
        raise argparse.ArgumentTypeError(f"a sun is given twice in {text!r}")
    return found


def column(text: str) -> tuple[str, str]:
    """What a coordinate is, and its name, of ROLE=NAME."""
    role, _, name = text.partition("=")
    if role not in ("zenith", "elevation", "azimuth", "wavelength") or not name:
        message = f"expected ROLE=NAME with zenith, elevation, azimuth or wavelength, as zenith=vza, got {text!r}"
        raise argparse.ArgumentTypeError(message)
    return role, name


def dimension_index(text: str) -> tuple[str, int]:
    """Name and index of DIM=INDEX."""
    name, _, index = text.partition("=")
    if not name or not index.isdecimal():
        raise argparse.ArgumentTypeError(f"expected DIM=INDEX, for example stokes=0, got {text!r}")
    return name, int(index)


def sky_name(text: str) -> str:
    """The name of a sky of ours or of an installed package."""
    from aomc_sky.formats.sky_toml.keys import value_problem

    if problem := value_problem("sky", "model", text):
        raise argparse.ArgumentTypeError(problem.sentence)
    return text


def sky_option(text: str) -> tuple[str, Any]:
    """Name and value of KEY=VALUE; the value is read as TOML, or is the text itself if it is not TOML."""
    import tomllib

    name, is_pair, value = text.partition("=")
    if not is_pair or not name.isidentifier():
        raise argparse.ArgumentTypeError(f"expected KEY=VALUE, for example type=12, got {text!r}")
    try:
        found = tomllib.loads(f"value = {value}")
    except ValueError:
        return name, value
    return name, found["value"] if len(found) == 1 else value


def share(text: str) -> tuple[str, float]:
    """Name and number of NAME=SHARE."""
    name, is_pair, number = text.rpartition("=")
    if not is_pair or not name.strip() or "," in name:
        message = f"expected NAME=SHARE, for example direct=0.2, got {text!r}; write the option once for each component"
        raise argparse.ArgumentTypeError(message)
    return name.strip(), finite_number(number)


TYPES: dict[Kind, Callable[[str], Any] | None] = {
    **dict.fromkeys((Kind.WORD, Kind.FORMAT, Kind.TEXT, Kind.NAMES, Kind.AZIMUTHS, Kind.RADIANCE_UNIT)),
    Kind.SIGNS: whole_number,
    Kind.SKY: sky_name,
    Kind.SKY_OPTION: sky_option,
    Kind.COLUMN: column,
    Kind.INDEX: dimension_index,
    Kind.WAVELENGTH: wavelength,
    Kind.WAVELENGTHS: wavelengths,
    Kind.SUNS: suns,
    Kind.SHARES: share,
    Kind.LATITUDE: degrees("N", "S"),
    Kind.LONGITUDE: degrees("E", "W"),
    Kind.MOMENT: moment,
    Kind.PHOTONS: photon_total,
    Kind.MEMORY: memory,
}
"""Kind of a row with an option -> the type of its value; None takes the word as it is."""
LIMITED: dict[Kind, Callable[[float, float], Callable[[str], Any]]] = {
    Kind.NUMBER: number_in,
    Kind.COUNT: whole_number_in,
}
"""Kinds whose type has the limits of the row."""
