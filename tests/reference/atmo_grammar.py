"""Which descriptions of an atmosphere CalcMySky takes: a plain twin of its grammar, for files that name no table.

Written from the observed behaviour of the tool (tests/unit/formats/atmo/test_behaviour.py), not from its code; no
places, no messages, no recovery.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from decimal import Decimal

LENGTHS = {
    "nm": "1e-9",
    "um": "1e-6",
    "mm": "1e-3",
    "m": "1",
    "km": "1e3",
    "Mm": "1e6",
    "Gm": "1e9",
    "AU": "149597870700",
}
AREAS = {"am^2": -36, "fm^2": -30, "pm^2": -24, "nm^2": -18, "um^2": -12, "mm^2": -6, "cm^2": -4, "m^2": 0}
AREAS |= {"km^2": 6, "Mm^2": 12, "Gm^2": 18}
AU = Decimal("149597870700")
BOUNDS = {
    "atmosphere height": (Decimal(1), Decimal("1e6")),
    "earth radius": (Decimal("1e-3"), Decimal("1e10")),
    "earth-sun distance": (AU / 2, AU * 10**20),
    "earth-moon distance": (AU / 10**4, AU * 10**20),
}
SPECTRA = {"solar irradiance at toa": 1000.0, "ground albedo": 1.0, "light pollution relative radiance": 1000.0}
COUNTED = ("texture size", "pairs to sample", "integration points")
DIRECTIVES = ("all textures are radiances", "no eclipsed double scattering textures")
FENCE = re.compile(r"\s*```\s*\Z")


class RefusedError(Exception):
    """The tool would stop here."""


def demand(condition: object) -> None:
    """Stop unless."""
    if not condition:
        raise RefusedError


def accepts(text: str) -> bool:
    """Whether the tool takes a description that names no table."""
    try:
        _file(iter(text.removeprefix("\ufeff").replace("\r\n", "\n").removesuffix("\r").split("\n")))
    except RefusedError:
        return False
    return True


def _content(line: str) -> str:
    return line.split("#")[0]


def _key_value(content: str) -> tuple[str, str]:
    parts = content.split(":")
    demand(len(parts) == 2)
    return " ".join(parts[0].split()).lower(), parts[1].strip()


def _file(lines: Iterator[str]) -> None:
    state: dict[str, object] = {"n": None, "names": set(), "scatterers": 0, "first": True, "sun": False}
    for line in lines:
        content = _content(line)
        if not content.strip():
            continue
        if content not in DIRECTIVES or state["first"]:
            key, value = _key_value(content)
            demand(not state["first"] or key == "version")
            _top(key, value, lines, state)
        state["first"] = False
    demand(state["n"] is not None and state["sun"] and state["scatterers"])


def _top(key: str, value: str, lines: Iterator[str], state: dict) -> None:
    section = re.fullmatch(r'(scatterer|absorber) "([^"]+)"', key)
    if section:
        # names are checked by the compiler of the shaders
        demand(re.fullmatch(r"[a-z0-9_]+", section[2], re.ASCII) and section[2] not in state["names"])
        state["names"].add(section[2])
        state["scatterers"] += section[1] == "scatterer"
        (_scatterer if section[1] == "scatterer" else _absorber)(lines, state["n"])
    elif key == "version":
        demand(value.isdigit() and int(value) == 6)
    elif key in BOUNDS:
        low, high = BOUNDS[key]
        demand(low <= _quantity(value, {unit: Decimal(scale) for unit, scale in LENGTHS.items()}) <= high)
    elif key == "wavelengths":
        n = _wavelengths(value)
        state["n"] = n if state["n"] is None else state["n"]
    elif key in SPECTRA:
        _list(value, state["n"], SPECTRA[key])
        state["sun"] |= key.startswith("solar")
    elif key == "scattering orders":
        demand(1 <= _real(value) <= 2**31)
    elif any(word in key for word in COUNTED) and _is_known_count(key):
        demand(re.fullmatch(r"\+?[0-9]+", value, re.ASCII) and 1 <= int(value) <= 2**31 - 1)
        demand(key != "scattering texture size for vza" or int(value) % 2 == 0)


def _is_known_count(key: str) -> bool:
    return key in KNOWN_COUNTS


KNOWN_COUNTS = {
    *(f"transmittance texture size for {x}" for x in ("vza", "altitude")),
    *(f"irradiance texture size for {x}" for x in ("sza", "altitude")),
    *(f"scattering texture size for {x}" for x in ("vza", "dot(view,sun)", "sza", "altitude")),
    *(f"eclipsed scattering texture size for {x}" for x in ("relative azimuth", "vza")),
    *(f"eclipsed double scattering texture size for {x}" for x in ("relative azimuth", "vza", "sza")),
    *(f"eclipsed double scattering number of {x} pairs to sample" for x in ("azimuth", "elevation")),
    *(f"light pollution texture size for {x}" for x in ("vza", "altitude")),
    *(f"{x} integration points" for x in ("light pollution angular", "transmittance", "radial", "angular")),
    "angular integration points for eclipse",
}


def _section(lines: Iterator[str], *, loose_end: bool) -> Iterator[tuple[str, str]]:
    """Keys and values between the braces; a directive has an empty key."""
    begun = False
    for line in lines:
        content = _content(line)
        if not content.strip():
            continue
        if not begun:
            demand(content == "{")
            begun = True
            continue
        if content == "}" or (loose_end and content.rstrip() == "}"):
            return
        if loose_end and content.strip().lower() == "needs interpolation guides":
            continue
        yield _key_value(content)


def _code(lines: Iterator[str]) -> None:
    demand(FENCE.match(next(lines, "")))
    for line in lines:
        if FENCE.match(line):
            return


def _scatterer(lines: Iterator[str], n: int | None) -> None:
    seen = set()
    for key, value in _section(lines, loose_end=True):
        seen.add(key)
        if key in ("number density", "phase function"):
            _code(lines)
        elif key == "cross section at 1 um":
            area = _quantity(value, {unit: Decimal(10) ** power for unit, power in AREAS.items()})
            demand(Decimal("1e-35") <= area <= 1)
        elif key == "angstrom exponent":
            demand(-10 <= _real(value) <= 10)
        elif key == "phase function type":
            demand(value in ("general", "achromatic", "smooth"))
        elif key == "single scattering albedo":
            _list(value, n, 1.0)
    demand({"number density", "phase function", "cross section at 1 um", "angstrom exponent"} <= seen)


def _absorber(lines: Iterator[str], n: int | None) -> None:
    seen = set()
    for key, value in _section(lines, loose_end=False):
        seen.add(key)
        if key == "number density":
            _code(lines)
        elif key == "cross section":
            _list(value, n, 10.0)
    demand({"number density", "cross section"} <= seen)


def _quantity(text: str, units: dict[str, Decimal]) -> Decimal:
    match = re.fullmatch(r"(-?[0-9.]+) *([a-zA-Z][a-zA-Z0-9^-]*)", text)
    demand(match)
    assert match is not None
    demand(re.fullmatch(r"-?([0-9]+\.?[0-9]*|\.[0-9]+)", match[1]) and match[2] in units)
    return Decimal(match[1]) * units[match[2]]


def _real(text: str) -> float:
    demand(re.fullmatch(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?", text, re.ASCII))
    return float(text)


def _list(text: str, n: int | None, high: float) -> None:
    demand(n is not None)
    values = [_real(item.strip()) for item in text.split(",")]
    demand(len(values) == n and all(0 <= value <= high for value in values))


def _wavelengths(text: str) -> int:
    units = {unit: Decimal(scale) for unit, scale in LENGTHS.items()}
    found: dict[str, str] = {}
    for item in text.split(","):
        match = re.fullmatch(r"\s*(min|max)\s*=\s*(.+)|\s*(count)\s*=\s*([0-9]+)\s*", item)
        if match:
            key, value = (match[1], match[2]) if match[1] else (match[3], match[4])
            demand(key not in found)
            found[key] = value
    demand(len(found) == 3)
    for key in ("min", "max"):
        demand(Decimal("1e-7") <= _quantity(found[key], units) <= Decimal("1e-4"))
    demand(int(found["count"]) > 0)  # and a multiple of 4, which we do not ask for
    return int(found["count"])
