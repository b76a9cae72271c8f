"""What the plan of a year of skies may be."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from typing import Any

from aomc_sky.sampling.streams import MAX_SEED
from aomc_sky.source.plan.members import LARGE, Member, check_range, check_shape
from aomc_sky.source.plan.options import Rules, check_each, check_stream, is_whole
from aomc_sky.source.plan.problem import Arrays, PlanRuleError, shown

SCHEMA = "aomc-sky-year/1"

MAX_CELLS = 2**27
"""Patches of an hour: as many as a table may have."""


class HourState(enum.IntEnum):
    """What an hour holds; the number is part of a year's plan.npz and never changes."""

    SKY = 0
    NIGHT = 1
    NO_DIFFUSE = 2
    MISSING = 3


MEMBERS = {
    "line": Member(dtype="<i8", shape=("n_row",), low=1, high=2**31),
    "start_s": Member(dtype="<i8", shape=("n_row",), low=-(2**62), high=2**62),
    "sun_zenith_deg": Member(dtype="<f8", shape=("n_row",), low=0.0, high=180.0),
    "sun_azimuth_deg": Member(dtype="<f8", shape=("n_row",), low=-360.0, high=720.0),
    "extraterrestrial_normal": Member(dtype="<f8", shape=("n_row",), low=0.0, high=LARGE),
    "dni": Member(dtype="<f8", shape=("n_row",), low=0.0, high=LARGE, may_be_nan=True),
    "dhi": Member(dtype="<f8", shape=("n_row",), low=0.0, high=LARGE, may_be_nan=True),
    "state": Member(dtype="|i1", shape=("n_row",), low=min(HourState), high=max(HourState)),
}
"""All arrays of the plan of a year; NaN is a value that the weather file does not have."""


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and 0 < len(value) <= 80 and value.isprintable()


def _are_bins(value: Any) -> bool:
    is_pair = isinstance(value, list) and len(value) == 2 and all(map(is_whole(1, MAX_CELLS), value))
    return is_pair and value[0] * value[1] <= MAX_CELLS


def _is_site(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 3 and all(type(x) in (int, float) and abs(x) <= 360 for x in value)


OPTIONS: Rules = {
    "schema": (lambda value: value == SCHEMA, SCHEMA),
    "stream": (lambda value: isinstance(value, str), "the version of the random streams"),
    "seed": (is_whole(0, MAX_SEED), "a whole number from 0 to 2^64 - 1"),
    "iterations": (is_whole(1, 2**62), "a whole number from 1 to 2^62"),
    "bins": (_are_bins, f"two whole numbers of bins, at most {MAX_CELLS} patches"),
    "limits": (_is_text, "a name"),
    "air_mass": (_is_text, "a name"),
    "with_beam": (lambda value: type(value) is bool, "true or false"),
    "site": (_is_site, "latitude, longitude and hours from UTC"),
}


def check_year(arrays: Arrays, options: Mapping[str, Any]) -> None:
    """Raise E952 to E955 unless these are the arrays and options of a year."""
    for name in [*MEMBERS, *arrays]:
        if name not in arrays:
            raise PlanRuleError("E952", name, "this array is missing; it belongs to the plan of a year of skies")
        if name not in MEMBERS:
            raise PlanRuleError("E952", shown(name), "is no array of the plan of a year of skies")
    check_stream(options)
    check_each(options, OPTIONS)
    lengths: dict[str, int] = {}
    for name, member in MEMBERS.items():
        check_shape(name, arrays[name], member, lengths)
        check_range(name, arrays[name], member)
