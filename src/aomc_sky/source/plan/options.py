"""The options of a plan: every key, what it may say, and what ties keys together."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from typing import Any

from aomc_sky.footprint import FootprintShape
from aomc_sky.sampling.allocation import AllocationMethod
from aomc_sky.sampling.streams import MAX_SEED, STREAM_VERSION
from aomc_sky.source.options import (
    MAX_REPLICATES,
    WITHDRAWN,
    WITHDRAWN_METHOD,
    Method,
    Order,
    Placement,
    Precision,
    method_of,
)
from aomc_sky.source.plan.problem import PlanRuleError, shown

_MAX_COMPONENTS = 10**6
_PLAIN_NAME = re.compile(r"[!-+\--~]([ -+\--~]{0,198}[!-+\--~])?")


def is_whole(low: int, high: int) -> Callable[[Any], bool]:
    """Whether a value is a whole number of this range, and no true or false."""
    return lambda value: type(value) is int and low <= value <= high


def one_of(kind: Any) -> Callable[[Any], bool]:
    """Whether a value is one of the texts of an enumeration."""
    allowed = {member.value for member in kind}
    return lambda value: isinstance(value, str) and value in allowed


def _is_size(value: Any) -> bool:
    return type(value) in (int, float) and 0 <= value < math.inf


def _is_footprint(value: Any) -> bool:
    if not isinstance(value, list) or len(value) != 3 or not one_of(FootprintShape)(value[0]):
        return False
    shape, size_x, size_y = value
    is_flat = shape != FootprintShape.POINT.value or size_x == size_y == 0
    return _is_size(size_x) and _is_size(size_y) and is_flat and (shape != "circle" or size_x == size_y)


def _are_names(value: Any) -> bool:
    is_list = isinstance(value, list) and 0 < len(value) <= _MAX_COMPONENTS
    return is_list and all(isinstance(name, str) and _PLAIN_NAME.fullmatch(name) for name in value)


def _are_first_indices(value: Any) -> bool:
    return isinstance(value, list) and all(map(is_whole(-(2**31), 2**31), value))


def _names_of(kind: Any) -> str:
    return f"one of {', '.join(member.value for member in kind)}"


Rules = dict[str, tuple[Callable[[Any], bool], str]]
"""What each option must satisfy, and that in words."""

OPTIONS: Rules = {
    "stream": (lambda value: value == STREAM_VERSION, STREAM_VERSION),
    "seed": (is_whole(0, MAX_SEED), "a whole number from 0 to 2^64 - 1"),
    "method": (one_of(Method), _names_of(Method)),
    "allocation": (one_of(AllocationMethod), _names_of(AllocationMethod)),
    "placement": (one_of(Placement), _names_of(Placement)),
    "order": (one_of(Order), _names_of(Order)),
    "precision": (one_of(Precision), _names_of(Precision)),
    "weights": (lambda value: type(value) is bool, "true or false"),
    "replicates": (is_whole(1, MAX_REPLICATES), f"a whole number from 1 to {MAX_REPLICATES}"),
    "footprint": (_is_footprint, "a shape (point, circle, rectangle) and its two sizes in metres"),
    "components": (_are_names, "plain names of at most 200 characters, without a comma"),
    "azimuth_first_index": (_are_first_indices, "a whole number for each component"),
}
"""Every option of a plan."""


def check_options(options: Any) -> None:
    """Raise E955 where an option is missing, not known, of another kind, or contradicts another one."""
    if not isinstance(options, Mapping):
        raise PlanRuleError("E955", "options", f"found {shown(options)}, wanted an object")
    check_stream(options)
    _refuse_withdrawn(options)
    check_each(options, OPTIONS)
    names, first = options["components"], options["azimuth_first_index"]
    if len(set(names)) != len(names) or len(first) != len(names):
        what = f"found {len(names)} names ({len(set(names))} different) and {len(first)} first indices"
        raise PlanRuleError("E955", "options.components", f"{what}, wanted one different name and one index for each")
    _check_method(options)


def check_stream(options: Mapping[str, Any]) -> None:
    """Raise E955 unless the photons of the options are those of this version."""
    stream = options.get("stream")
    if stream != STREAM_VERSION:
        raise PlanRuleError(
            "E955",
            "options.stream",
            f"made with the random streams {shown(stream)}; this version has {STREAM_VERSION!r}, which give other "
            "photons; read it with the version of aomc-sky that made it, or run the scene again",
        )


def _refuse_withdrawn(options: Mapping[str, Any]) -> None:
    """Raise E955 where the photons are those of a method that this version does not have any more."""
    if WITHDRAWN_METHOD in (options.get("method"), options.get("placement")):
        message = f"{WITHDRAWN} and read its plans; run the scene again with --method stratified"
        raise PlanRuleError("E955", "options.method", message)


def check_each(options: Mapping[str, Any], rules: Rules) -> None:
    """Raise E955 where an option is missing, not known, or of another kind."""
    for name in [*rules, *options]:
        if name not in options:
            raise PlanRuleError("E955", f"options.{name}", f"is missing, wanted {rules[name][1]}")
        if name not in rules:
            raise PlanRuleError("E955", "options", f"found {shown(name)}, which is no option of a plan")
        is_right, expected = rules[name]
        if not is_right(options[name]):
            raise PlanRuleError("E955", f"options.{name}", f"found {shown(options[name])}, wanted {expected}")


def _check_method(options: Mapping[str, Any]) -> None:
    allocation, placement = AllocationMethod(options["allocation"]), Placement(options["placement"])
    expected = method_of(allocation, placement)
    chosen = f"allocation {allocation.value} and placement {placement.value}"
    if Method(options["method"]) is not expected:
        message = f"found {options['method']}, wanted {expected.value}, which is what {chosen} mean"
        raise PlanRuleError("E955", "options.method", message)
    if allocation is AllocationMethod.AOMC and options["replicates"] != 1:
        message = f"found {options['replicates']} under allocation aomc, which has no randomness, wanted 1"
        raise PlanRuleError("E955", "options.replicates", message)
