"""What a plan may be: one table of its members, one of its options, and what ties them together.

Whoever makes photons from a plan has passed it through `check_plan`: `Plan.load`, `PhotonSource` and so the hosts,
shards, exports and workers. The kernels check no index; `docs/decisions/0022-a-plan-has-one-schema.md` lists each of
their look-ups with the rule that keeps it inside its array. `laws` has the rules of cells and of the laws' tables.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.component import N_CELL_PARAMETERS, Law
from aomc_sky.sampling.allocation import MAX_PHOTONS, AllocationMethod
from aomc_sky.sampling.streams import MAX_SEED, ORDER, PLACEMENT, POSITION, SHIFT, STREAM_VERSION, stream_keys
from aomc_sky.source.photons import FootprintShape
from aomc_sky.source.plan.counts import replicate_band_photons
from aomc_sky.source.plan.laws import Arrays, PlanRuleError, check_components, naming, refuse_value, shown
from aomc_sky.source.plan.options import (
    MAX_REPLICATES,
    WITHDRAWN,
    WITHDRAWN_METHOD,
    Method,
    Order,
    Placement,
    Precision,
    method_of,
)

# an array: its type, its lengths, its range

LARGE = 1.7976931348623157e308
"""As an end of a range: finite."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Member:
    """One array of a plan."""

    dtype: str  #: exactly this type, little-endian
    shape: tuple[str | int, ...]  #: a text is the name of a length, the same wherever it stands
    low: float | None = None  #: range of all values, both ends allowed; None where another rule looks at them
    high: float | None = None
    may_be_nan: bool = False  #: whether NaN stands for "not known"
    is_optional: bool = False


def check_shape(name: str, array: Any, member: Member, lengths: dict[str, int]) -> None:
    """Compare one array; lengths that are not known yet are those of the array."""
    if not isinstance(array, np.ndarray):
        raise PlanRuleError("E953", name, f"found {type(array).__name__}, wanted an array of {member.dtype}")
    expected: list[int] = []
    for axis, length in enumerate(member.shape):
        found = array.shape[axis] if axis < array.ndim else -1
        expected.append(length if isinstance(length, int) else _length(length, found, lengths))
    little = array.dtype.newbyteorder("<").str
    if little != member.dtype or not array.dtype.isnative or array.shape != tuple(expected):
        named = ", ".join(
            str(length) if isinstance(length, int) else f"{length} = {value}"
            for length, value in zip(member.shape, expected, strict=True)
        )
        allowed = f"{np.dtype(member.dtype).name} of shape ({named})"
        raise PlanRuleError("E953", name, f"found {array.dtype.name} of shape {array.shape}, wanted {allowed}")


def _length(text: str, length: int, lengths: dict[str, int]) -> int:
    """Value of a length such as ``n_cell + 1``; that of the array where it stands for the first time."""
    name, _, added = text.partition(" + ")
    extra = int(added or 0)
    if name not in lengths:
        least = 0 if name.startswith("n_weight") else 1
        if length - extra < least:
            return least + extra  # the length of the array cannot be
        lengths[name] = length - extra
    return lengths[name] + extra


def check_range(name: str, array: np.ndarray, member: Member) -> None:
    """Raise E954 where a value lies outside the range of its member, or is not a number."""
    if member.low is None or member.high is None or not array.size:
        return
    values = array[~np.isnan(array)] if member.may_be_nan else array
    for value in (values.min(), values.max()) if values.size else ():
        if not member.low <= value <= member.high:  # NaN is neither
            raise refuse_value(name, value, f"values {_range(member.low, member.high)}")


def _range(low: float, high: float) -> str:
    if high == LARGE:
        return "that are finite" if low == -LARGE else f"from {low:g}, finite"
    return f"from {low:g} to {high:g}"


# the options: every key, what it may say, and what ties keys together

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


_VERSIONS = {"aomc-sky/1": "aomc-sky 0.1", "aomc-sky/2": "aomc-sky 0.2"}
"""Which version has the streams of an old plan."""

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
            f"photons; verify old runs with {_VERSIONS.get(str(stream), 'the version that made them')}, or run the "
            "scene again",
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
            raise PlanRuleError("E955", "options", f"found {shown(name)}, which is not an option of a plan")
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


# the keys of the random streams: a pure function of the options, so that they can be made again

STREAMS = (ORDER, SHIFT, PLACEMENT, POSITION)
"""Streams whose keys stand in the plan, in this order; allocation has done its work by then."""


def plan_keys(options: Mapping[str, Any]) -> np.ndarray:
    """Member `keys` of a plan with these options, uint64 (4,)."""
    return stream_keys(options["seed"], STREAMS, options["method"])


# the whole plan

MAX_PLAN_BYTES = 2**34
"""Largest plan that is written or read: what the machines that run it hold."""

MAX_CELLS = 2**31 - 1
"""Cells have numbers of type int32 in batches and tables."""

MASS_TOLERANCE = 1e-9
"""Of the sum of a row of masses: far above the rounding of 2^31 summands, far below what a photon shows."""

_BLOCK = 1 << 20  # values that are compared at a time: temporary arrays stay small


MEMBERS: dict[str, Member] = {
    "wavelength_nm": Member(dtype="<f8", shape=("n_band",), low=0.0, high=LARGE),
    "sky_wavelength_nm": Member(dtype="<f8", shape=("n_band",), low=0.0, high=LARGE, may_be_nan=True),
    "requested": Member(dtype="<i8", shape=("n_band",), low=0, high=MAX_PHOTONS),
    "cumulative": Member(dtype="<i8", shape=("n_replicate_band", "n_cell + 1"), low=0, high=MAX_PHOTONS),
    "row_of_band": Member(dtype="<i8", shape=("n_band",)),
    "mass": Member(dtype="<f8", shape=("n_row", "n_cell"), low=0.0, high=1.0 + MASS_TOLERANCE),
    "weight": Member(dtype="<f8", shape=("n_weight_row", "n_weight_cell"), low=0.0, high=LARGE),
    "law": Member(dtype="|i1", shape=("n_cell",), low=min(Law), high=max(Law)),
    "cell": Member(dtype="<f8", shape=("n_cell", N_CELL_PARAMETERS), low=-1e30, high=1e30),
    "component_start": Member(dtype="<i8", shape=("n_component + 1",), low=0, high=MAX_CELLS),
    "keys": Member(dtype="<u8", shape=(4,)),
    "irradiance_W_m2_nm": Member(dtype="<f8", shape=("n_band", "n_component"), low=0.0, high=LARGE, is_optional=True),
    "horizon_loss": Member(dtype="<f8", shape=("n_band",), low=0.0, high=1.0, is_optional=True),
}
"""All arrays of a plan but those of single components."""

COMPONENT_MEMBERS = {
    "zenith_bounds_deg": Member(dtype="<f8", shape=("n_ring", 2), low=0.0, high=90.0),
    "azimuth_bounds_deg": Member(dtype="<f8", shape=("n_column", 2), low=-1e9, high=1e9),
    "shared": Member(dtype="<f8", shape=("n_shared",), low=-1e300, high=1e300),
    "bounds": Member(dtype="<f8", shape=("n_bound", "n_bound_column"), low=-1e300, high=1e300),
}
"""Arrays of component k, whose names end in _k."""

_OF_COMPONENT = re.compile(rf"({'|'.join(COMPONENT_MEMBERS)})_(0|[1-9]\d{{0,5}})")


def check_plan(arrays: Arrays, options: Mapping[str, Any], path: str = "plan") -> None:
    """Raise unless photons can be made from a plan as it is; `path` is what the message calls it.

    E952 (a member is missing or not known), E953 (type or shape), E954 (values), E955 (options). Only the first problem
    is reported: the others follow from it. A few passes over the arrays: less than reading them.
    """
    with naming(path), np.errstate(all="ignore"):  # squares of what is refused for its size
        check_options(options)
        _check_names(arrays, options)
        lengths = _check_shapes(arrays, options)
        _check_ranges(arrays)
        _check_cells(arrays, options)
        _check_rows(arrays)
        check_components(arrays, options)
        _check_counts(arrays, options, lengths)


def _check_names(arrays: Arrays, options: Mapping[str, Any]) -> None:
    """Raise E952 where an array is missing, or there is one that no plan has."""
    for name, member in MEMBERS.items():
        if name not in arrays and not member.is_optional:
            raise PlanRuleError("E952", name, "this array is missing")
    n_component = len(options["components"])
    for name in arrays:
        of_component = _OF_COMPONENT.fullmatch(str(name))
        if name not in MEMBERS and not (of_component and int(of_component[2]) < n_component):
            raise PlanRuleError(
                "E952", shown(name), f"is not an array of a plan of {n_component} components with these options"
            )
    if ("irradiance_W_m2_nm" in arrays) != ("horizon_loss" in arrays):
        raise PlanRuleError(
            "E952", "irradiance_W_m2_nm", "belongs together with horizon_loss, and one of them is missing"
        )


def _check_shapes(arrays: Arrays, options: Mapping[str, Any]) -> dict[str, int]:
    """Raise E953 where an array has another type or length than its member in the tables; return the lengths."""
    lengths = {"n_component": len(options["components"])}
    of_component: dict[str, dict[str, int]] = {}
    total = 0
    for name, member in MEMBERS.items():
        if name in arrays:
            check_shape(name, arrays[name], member, lengths)
            total += arrays[name].nbytes
        if name == "requested":
            lengths["n_replicate_band"] = options["replicates"] * lengths["n_band"]
    for name in arrays:
        if name not in MEMBERS:
            kind, _, k = name.rpartition("_")
            check_shape(name, arrays[name], COMPONENT_MEMBERS[kind], of_component.setdefault(k, {}))
            total += arrays[name].nbytes
    if total > MAX_PLAN_BYTES:
        raise PlanRuleError("E953", "", f"the arrays have {total} bytes, at most {MAX_PLAN_BYTES} are allowed")
    return lengths


def _check_ranges(arrays: Arrays) -> None:
    for name, array in arrays.items():
        check_range(name, array, MEMBERS.get(name) or COMPONENT_MEMBERS[name.rpartition("_")[0]])


# values that depend on each other


def _check_cells(arrays: Arrays, options: Mapping[str, Any]) -> None:
    n_cell, start = arrays["law"].size, arrays["component_start"]
    if n_cell > MAX_CELLS:
        raise refuse_value("law", n_cell, f"at most {MAX_CELLS} cells")
    if start[0] != 0 or start[-1] != n_cell or np.any(start[1:] <= start[:-1]):
        raise refuse_value("component_start", start.tolist(), f"increasing cell numbers from 0 to n_cell = {n_cell}")
    law = arrays["law"]
    mixed = sorted({*(np.flatnonzero(law[1:] != law[:-1]) + 1).tolist()} - {*start.tolist()})
    if mixed:
        k = int(np.searchsorted(start, mixed[0], side="right")) - 1
        raise refuse_value(
            "law", np.unique(law[start[k] : start[k + 1]]).tolist(), f"one law for all cells of component {k}"
        )
    if not np.array_equal(arrays["keys"], plan_keys(options)):
        raise refuse_value("keys", "others", f"the keys that follow from seed {options['seed']}")


def _check_rows(arrays: Arrays) -> None:
    rows, mass, weight = arrays["row_of_band"], arrays["mass"], arrays["weight"]
    if rows.min() < 0 or rows.max() >= len(mass):
        raise refuse_value("row_of_band", rows.tolist(), f"rows of mass from 0 to {len(mass) - 1}")
    total = mass.sum(axis=1)
    is_right = (np.abs(total - 1.0) <= MASS_TOLERANCE) | (total == 0.0)
    if not is_right.all():
        raise refuse_value("mass", f"sum {total[~is_right][0]}", "rows with sum 1, or rows of zeros")
    if weight.shape not in ((0, 0), mass.shape):
        raise PlanRuleError("E953", "weight", f"found shape {weight.shape}, wanted {mass.shape}, or (0, 0) for none")


def _check_counts(arrays: Arrays, options: Mapping[str, Any], lengths: Mapping[str, int]) -> None:
    """Cumulative counts rise from 0, and end with the photons that each replicate of a band was asked for."""
    cumulative, mass, n_band = arrays["cumulative"], arrays["mass"], lengths["n_band"]
    if arrays["weight"].size and not options["weights"]:
        raise refuse_value("weight", f"shape {arrays['weight'].shape}", "none, for options.weights is false")
    rows = np.tile(arrays["row_of_band"], options["replicates"])
    dark = np.asarray(mass == 0.0)
    for start in range(0, len(rows), step := max(1, _BLOCK // cumulative.shape[1])):
        part = cumulative[start : start + step]
        grows = part[:, 1:] > part[:, :-1]
        falls = (part[:, 0] != 0) | np.any(part[:, 1:] < part[:, :-1], axis=1)
        if falls.any():
            replicate_band = start + int(falls.argmax())
            raise refuse_value(
                "cumulative", f"a decrease in row {replicate_band}", "photons before each cell, from 0 and increasing"
            )
        astray = np.any(grows & dark.take(rows[start : start + step], axis=0), axis=1)
        if astray.any():
            replicate_band = start + int(astray.argmax())
            raise refuse_value("cumulative", f"photons of row {replicate_band} in a cell of mass 0", "none there")
    expected = replicate_band_photons(arrays["requested"], options["replicates"])
    launched, is_lit = cumulative[:, -1], np.any(mass, axis=1).take(rows)
    if options["allocation"] == AllocationMethod.AOMC.value:
        slack = lengths["n_cell"] + expected // 100_000  # every cell is rounded, in the program's own units
        is_right = np.where(is_lit, np.abs(launched - expected) <= slack, launched == 0)
    else:
        is_right = (launched == expected) & (is_lit | (expected == 0))
    if not is_right.all():
        replicate_band = int(is_right.argmin())
        what = f"{launched[replicate_band]} photons in row {replicate_band}, waveband {replicate_band % n_band + 1}"
        raise refuse_value("cumulative", what, f"the {expected[replicate_band]} requested, and light for them")
