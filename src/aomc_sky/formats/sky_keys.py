"""What may be said about the weather and the sun: keys, their ranges, and which of them go together."""

from __future__ import annotations

import math
import sys
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from difflib import SequenceMatcher

COEFFICIENT_NAMES = ("a", "b", "c", "d", "e")
SETS = (("dni", "dhi"), ("ghi", "dni"), ("epsilon", "delta"), COEFFICIENT_NAMES)
"""What describes a Perez sky: exactly one of these."""

_GROUPS = (("dni", "dhi", "ghi"), ("epsilon", "delta"), COEFFICIENT_NAMES)
_SETS_TEXT = "dni + dhi, ghi + dni, epsilon + delta, or a, b, c, d, e"
_GOOD = ("", "", "")


@dataclass(frozen=True, kw_only=True, slots=True)
class Range:
    """Allowed values of a key: low <= value <= high, or below high where `is_open`."""

    low: float = -math.inf
    high: float = math.inf
    is_open: bool = False

    def holds(self, value: float) -> bool:
        """Whether a value lies inside."""
        return self.low <= value < self.high if self.is_open else self.low <= value <= self.high

    def __str__(self) -> str:
        if self.high == math.inf:
            return f"{self.low:g} or more"
        return f"{self.low:g} to {'below ' if self.is_open else ''}{self.high:g}"


_IRRADIANCE = Range(low=0, high=10_000)
_COEFFICIENT = Range(low=-1000, high=1000)
KEYS: dict[str, dict[str, Range | None]] = {
    "perez": {
        "dni": _IRRADIANCE,
        "dhi": _IRRADIANCE,
        "ghi": _IRRADIANCE,
        "epsilon": Range(low=1),
        "delta": Range(low=0),
        **dict.fromkeys(COEFFICIENT_NAMES, _COEFFICIENT),
    },
    "sun": {
        "zenith_deg": Range(low=0, high=90, is_open=True),
        "azimuth_deg": Range(low=-360, high=360),
        "disc": None,
    },
}


@dataclass(frozen=True, kw_only=True, slots=True)
class PerezSection:
    """[perez]: one of the `SETS`, or nothing.

    Parameters
    ----------
    dni, dhi, ghi : float or None
        Direct normal, diffuse horizontal, global horizontal irradiance. [W m-2, 0 to 10 000]
    epsilon : float or None
        Sky clearness. [1 or more]
    delta : float or None
        Sky brightness. [0 or more]
    coefficients : tuple of 5 float, or None
        a, b, c, d, e of eq. (1). [-1000 to 1000]
    """

    dni: float | None = None
    dhi: float | None = None
    ghi: float | None = None
    epsilon: float | None = None
    delta: float | None = None
    coefficients: tuple[float, float, float, float, float] | None = None

    @property
    def is_empty(self) -> bool:
        """Whether nothing is given."""
        return self == PerezSection()


@dataclass(frozen=True, kw_only=True, slots=True)
class SunSection:
    """[sun]: what is finer than amc.inp.

    Parameters
    ----------
    zenith_deg : float or None
        Zenith angle of the sun. [deg, 0 to below 90]
    azimuth_deg : float or None
        Azimuth of the sun, from +x towards +y as in amc.inp. [deg, -360 to 360]
    disc : bool or None
        Whether the beam has the extent of the solar disc.
    """

    zenith_deg: float | None = None
    azimuth_deg: float | None = None
    disc: bool | None = None

    @property
    def is_empty(self) -> bool:
        """Whether nothing is given."""
        return self == SunSection()


def perez_section(values: Mapping[str, float]) -> PerezSection:
    """Put the coefficients a to e together, if they are there."""
    whole = all(name in values for name in COEFFICIENT_NAMES)
    a, b, c, d, e = (values.get(name, 0.0) for name in COEFFICIENT_NAMES)
    return PerezSection(
        dni=values.get("dni"),
        dhi=values.get("dhi"),
        ghi=values.get("ghi"),
        epsilon=values.get("epsilon"),
        delta=values.get("delta"),
        coefficients=(a, b, c, d, e) if whole else None,
    )


def set_problem(names: Collection[str]) -> tuple[str, str]:
    """Say what is wrong with a choice of keys.

    Parameters
    ----------
    names : collection of str
        Keys of [perez] that are given.

    Returns
    -------
    message, advice : str
        Empty where the keys are one of the `SETS`, or none at all.
    """
    if not names or any(set(names) == set(complete) for complete in SETS):
        return "", ""
    groups = [[name for name in group if name in names] for group in _GROUPS]
    touched = [group for group in groups if group]
    if len(touched) > 1:
        shown = " and ".join("/".join(group) for group in touched)
        return f"{shown} describe the same sky twice", f"keep one of {_SETS_TEXT}"
    given = touched[0]
    if given == ["dni", "dhi", "ghi"]:
        return "dni, dhi and ghi are one too many: ghi = dni cos Z + dhi", "remove ghi"
    if given == ["dhi", "ghi"]:
        return "dhi and ghi without dni", "give dni, and dhi or ghi"
    wanted = next(complete for complete in SETS if set(given) <= set(complete))
    missing = [name for name in wanted if name not in given]
    alternative = " (or ghi)" if given == ["dni"] else ""
    return f"{', '.join(given)} without {', '.join(missing)}", f"add {', '.join(missing)}{alternative}"


def value_problem(section: str, name: str, value: object) -> tuple[str, str, str]:
    """Say what is wrong with a value.

    Parameters
    ----------
    section : {"perez", "sun"}
        Section of sky.toml.
    name : str
        A key of the section.
    value : object
        What is given for it.

    Returns
    -------
    code, message, advice : str
        Empty where the value is good.
    """
    rule = KEYS[section][name]
    if rule is None:
        good = isinstance(value, bool)
        return _GOOD if good else ("E703", f"{shown_value(value)} is neither true nor false", "write true or false")
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return "E703", f"{shown_value(value)} is not a number", f"write a number, {rule}"
    if not abs(value) <= sys.float_info.max:  # whole numbers of TOML have no limit
        return "E704", f"{shown_value(value)} is not finite", f"write {rule}"
    if not rule.holds(value):
        return "E704", f"{shown_value(value)} is outside the range {rule}", f"write {rule}"
    return _GOOD


def nearest(name: str, known: Collection[str]) -> str:
    """The known name that is most like `name`."""
    return max(known, key=lambda candidate: SequenceMatcher(None, name[:40].lower(), candidate).ratio())


def shown_value(value: object) -> str:
    """A value as a message shows it: short, and as TOML has it."""
    if isinstance(value, (bool, dict, list)):
        return {bool: str(value).lower(), dict: "a table", list: "an array"}[type(value)]
    text = repr(value) if isinstance(value, str) else str(value)
    return text if len(text) <= 40 else f"{text[:37]}..."
