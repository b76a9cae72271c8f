"""Checks of a plan before a kernel uses its numbers as indices.

Kernels check no index. Therefore every number of a plan that serves as one is checked here: types, lengths, laws,
counts, and the bins of lobes. Decision 22 lists each look-up of the kernels with its rule. These checks do not compare
the plan with a scene: `verify --scene` does.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from aomc_sky.component import MAX_SLOPE, N_CELL_PARAMETERS, Law
from aomc_sky.errors import AomcSkyError
from aomc_sky.formats.text_file import refuse
from aomc_sky.grid import PatchGrid
from aomc_sky.plan.counts import Arrays
from aomc_sky.plan.footprint import Footprint
from aomc_sky.plan.laws import law_of
from aomc_sky.plan.options import (
    MAX_REPLICATES,
    Method,
    Order,
    Placement,
    Precision,
    method_of,
)
from aomc_sky.plan.sampling.allocation import MAX_PHOTONS, AllocationMethod
from aomc_sky.plan.sampling.streams import MAX_SEED, ORDER, PLACEMENT, POSITION, SHIFT, STREAM_VERSION, stream_key
from aomc_sky.whole_number import as_index_within

MAX_CELLS = 2**31 - 1
"""Cells have numbers of type int32 in batches and tables."""

STREAMS = (ORDER, SHIFT, PLACEMENT, POSITION)
"""Streams whose keys are in the plan, in this order; the key of allocation is not needed any more."""

MEMBERS: dict[str, tuple[str, tuple[str | int, ...]]] = {
    "wavelength_nm": ("<f8", ("n_band",)),
    "sky_wavelength_nm": ("<f8", ("n_band",)),
    "requested": ("<i8", ("n_band",)),
    "cumulative": ("<i8", ("n_replicate_band", "n_cell + 1")),
    "row_of_band": ("<i8", ("n_band",)),
    "mass": ("<f8", ("n_row", "n_cell")),
    "weight": ("<f8", ("n_weight_row", "n_weight_cell")),
    "law": ("|i1", ("n_cell",)),
    "cell": ("<f8", ("n_cell", N_CELL_PARAMETERS)),
    "component_start": ("<i8", ("n_component + 1",)),
    "keys": ("<u8", (len(STREAMS),)),
}
"""Type and lengths of the arrays that every plan has; equal names are equal lengths."""

OPTIONAL = {
    "irradiance_W_m2_nm": ("<f8", ("n_band", "n_component")),
    "horizon_loss": ("<f8", ("n_band",)),
}
"""Arrays of plans whose absolute units are known."""

OF_COMPONENT = {
    "zenith_bounds_deg": ("<f8", ("n_ring", 2)),
    "azimuth_bounds_deg": ("<f8", ("n_column", 2)),
    "shared": ("<f8", ("n_shared",)),
    "bounds": ("<f8", ("n_bound", "n_bound_column")),
    "slope": ("<f8", ("n_slope_row", "n_slope", 2)),
}
"""Arrays of component k, whose names end in _k."""

OPTIONS = {
    *("stream", "seed", "method", "allocation", "placement", "order", "precision", "weights", "replicates"),
    *("footprint", "components", "azimuth_first_index"),
}

_VERSIONS = {f"aomc-sky/{k}": f"aomc-sky 0.{k}" for k in (1, 2, 3)}
_NAME = re.compile(r"[!-+\--~]([ -+\--~]{0,198}[!-+\--~])?")
_LARGEST = 1e300


class _RefusedError(Exception):
    """Code, member, and its fault."""


def plan_keys(options: Mapping[str, Any]) -> np.ndarray:
    """Member `keys` of a plan with these options, uint64 (4,)."""
    keys = [stream_key(options["seed"], stream, options["method"]) for stream in STREAMS]
    return np.array(keys, dtype=np.uint64)


def check_plan(arrays: Arrays, options: Mapping[str, Any], path: str = "plan") -> None:
    """Raise unless photons can be made from a plan; messages call it `path`.

    E952 (a member is missing or not known), E953 (type or shape), E954 (values), E955 (options). Only the first problem
    is reported: the others follow from it.
    """
    with _naming(path):
        _check_options(options)
        lengths = _check_arrays(arrays, options)
        _check_values(arrays, options, lengths)
        for k in range(lengths["n_component"]):
            _check_component(arrays, k)


def check_stream(options: Any, path: str) -> None:
    """Raise E955 unless the photons of the options are those of this version."""
    with _naming(path):
        _check_stream(options)


@contextmanager
def _naming(path: str) -> Iterator[None]:
    try:
        yield
    except _RefusedError as refused:
        code, member, message = refused.args
        advice = "make the run again, or take the plan.npz that it wrote"
        raise refuse(path, message, code=code, name=member, advice=advice) from None


def _require(holds: object, code: str, member: str, message: str) -> None:
    if not holds:
        raise _RefusedError(code, member, message)


def _check_stream(options: Any) -> None:
    _require(isinstance(options, Mapping), "E955", "options", "is no object")
    stream = options.get("stream")
    made_with = _VERSIONS.get(str(stream), "the version that made them")
    _require(
        stream == STREAM_VERSION,
        "E955",
        "options.stream",
        f"made with the random streams {ascii(stream)[:40]}; this version has {STREAM_VERSION!r}, which give other "
        f"photons; verify old runs with {made_with}, or run the scene again",
    )


def _check_options(options: Any) -> None:
    _check_stream(options)
    odd = sorted(map(str, OPTIONS ^ set(options)))
    _require(not odd, "E955", "options", f"options that are missing or not known: {ascii(odd)[:200]}")
    try:
        as_index_within(options["seed"], "seed", 0, MAX_SEED)
        as_index_within(options["replicates"], "replicates", 1, MAX_REPLICATES)
        allocation, placement = AllocationMethod(options["allocation"]), Placement(options["placement"])
        method, _, _ = Method(options["method"]), Order(options["order"]), Precision(options["precision"])
        shape, size_x, size_y = options["footprint"]
        Footprint(shape=shape, size_x_m=size_x, size_y_m=size_y)
        names, first = options["components"], options["azimuth_first_index"]
        are_names = all(isinstance(name, str) and _NAME.fullmatch(name) for name in names)
        first = [as_index_within(index, "azimuth_first_index", -(2**31), 2**31) for index in first]
    except (AomcSkyError, TypeError, ValueError) as error:
        raise _RefusedError("E955", "options", str(error)[:300]) from None
    expected = method_of(allocation, placement)
    _require(method is expected, "E955", "options.method", f"found {method.value}, wanted {expected.value}")
    _require(type(options["weights"]) is bool, "E955", "options.weights", "is neither true nor false")
    are_names = are_names and isinstance(names, list) and 0 < len(names) == len(set(names)) == len(first)
    message = "wanted different plain names of at most 200 characters, and a first index for each"
    _require(are_names, "E955", "options.components", message)


def _check_arrays(arrays: Arrays, options: Mapping[str, Any]) -> dict[str, int]:
    """Every array has its type and shape; returns the lengths."""
    lengths = {"n_component": len(options["components"])}
    of_component = re.compile(rf"({'|'.join(OF_COMPONENT)})_(0|[1-9]\d{{0,5}})")
    for name, (dtype, shape) in MEMBERS.items():
        _require(name in arrays, "E952", name, "this array is missing")
        _check_shape(name, arrays[name], dtype, shape, lengths)
        if name == "requested":
            lengths["n_replicate_band"] = options["replicates"] * lengths["n_band"]
    _require(
        ("irradiance_W_m2_nm" in arrays) == ("horizon_loss" in arrays),
        "E952",
        "horizon_loss",
        "irradiance_W_m2_nm and horizon_loss belong together",
    )
    for name in arrays:
        if name in OPTIONAL:
            _check_shape(name, arrays[name], *OPTIONAL[name], lengths)
        elif name not in MEMBERS:
            found = of_component.fullmatch(name)
            is_known = found is not None and int(found[2]) < lengths["n_component"]
            _require(is_known, "E952", ascii(name)[:100], "is not an array of a plan with these options")
            assert found is not None
            _check_shape(name, arrays[name], *OF_COMPONENT[found[1]], {})
    return lengths


def _check_shape(name: str, array: Any, dtype: str, shape: tuple[str | int, ...], lengths: dict[str, int]) -> None:
    is_array = isinstance(array, np.ndarray) and array.ndim == len(shape)
    fits = is_array and array.dtype.newbyteorder("<").str == dtype and array.dtype.isnative
    for axis, length in enumerate(shape if fits else ()):
        text, _, more = str(length).partition(" + ")
        size = array.shape[axis] - int(more or 0)
        expected = length if isinstance(length, int) else lengths.setdefault(text, size)
        fits = fits and size == expected and (size > 0 or text.startswith("n_weight"))
    found = f"{array.dtype} of shape {array.shape}" if isinstance(array, np.ndarray) else type(array).__name__
    _require(fits, "E953", name, f"found {found}, wanted {dtype} of shape {shape} with {lengths}")


def _check_values(arrays: Arrays, options: Mapping[str, Any], lengths: Mapping[str, int]) -> None:
    for name, array in arrays.items():
        if array.dtype.kind == "f" and name != "sky_wavelength_nm":
            _require(
                np.all(np.abs(array) <= _LARGEST),
                "E954",
                name,
                f"found numbers that are not finite or above {_LARGEST:g}",
            )
    n_cell, start, law = lengths["n_cell"], arrays["component_start"], arrays["law"]
    _require(n_cell <= MAX_CELLS, "E954", "law", f"found {n_cell} cells, at most {MAX_CELLS} are allowed")
    rises = start[0] == 0 and start[-1] == n_cell and np.all(start[1:] > start[:-1])
    _require(rises, "E954", "component_start", f"wanted increasing cell numbers from 0 to {n_cell}")
    _require(
        law.min() >= min(Law) and law.max() <= max(Law), "E954", "law", f"wanted laws from {min(Law)} to {max(Law)}"
    )
    changes = np.flatnonzero(law[1:] != law[:-1]) + 1
    _require(np.isin(changes, start).all(), "E954", "law", "wanted one law for all cells of a component")
    rows, cumulative = arrays["row_of_band"], arrays["cumulative"]
    _require(rows.min() >= 0 and rows.max() < lengths["n_row"], "E954", "row_of_band", "wanted rows of mass")
    _require(arrays["mass"].min() >= 0, "E954", "mass", "wanted masses from 0")
    shape = arrays["weight"].shape
    fits = shape in ((0, 0), arrays["mass"].shape) and (options["weights"] or shape == (0, 0))
    _require(fits, "E953", "weight", f"found shape {shape}, wanted that of mass, or (0, 0) for none")
    for name, values in (("cumulative", cumulative), ("requested", arrays["requested"])):
        in_range = values.min() >= 0 and values.max() <= MAX_PHOTONS
        _require(in_range, "E954", name, f"wanted numbers of photons from 0 to {MAX_PHOTONS}")
    rises = not cumulative[:, 0].any() and all(np.all(row[1:] >= row[:-1]) for row in cumulative)
    _require(rises, "E954", "cumulative", "wanted photons before each cell, from 0 and increasing")
    same = np.array_equal(arrays["keys"], plan_keys(options))
    _require(same, "E954", "keys", f"wanted the keys that follow from seed {options['seed']}")
    for number, n in zip(*np.unique(law[start[:-1]], return_counts=True), strict=True):
        one = Law(int(number))
        message = f"found {n} components of law {one.name}, at most one is allowed"
        _require(n == 1 or not law_of(one).instead, "E954", "law", message)
    is_table = lengths["n_component"] == 1 and "zenith_bounds_deg_0" in arrays
    of_aomc = options["allocation"] == AllocationMethod.AOMC.value
    _require(
        not of_aomc or (is_table and options["replicates"] == 1),
        "E955",
        "options.allocation",
        "found aomc, which wants one table and no replicates",
    )


def _check_component(arrays: Arrays, k: int) -> None:
    """Check the arrays of a component, and the numbers in them that kernels use as indices or limits."""
    start = arrays["component_start"]
    n_cell, number = int(start[k + 1] - start[k]), Law(int(arrays["law"][start[k]]))
    law = law_of(number)
    names = [f"{name}_{k}" for name in OF_COMPONENT]
    has_zenith, has_azimuth, has_shared, has_bounds, has_slope = (name in arrays for name in names)
    has_tables = law.tables is not None
    fits = has_zenith == has_azimuth and has_shared == has_bounds == has_tables and has_zenith >= law.needs_patches
    fits = fits and has_slope == law.has_slopes
    _require(fits, "E952", names[0], f"the arrays of component {k} are not those of law {number.name}")
    if has_zenith:
        zenith, azimuth = arrays[names[0]], arrays[names[1]]
        _require(len(zenith) * len(azimuth) == n_cell, "E954", names[0], f"wanted as many patches as cells, {n_cell}")
        _require(
            zenith.min() >= 0 and zenith.max() <= 90, "E954", names[0], "wanted zenith angles from 0 to 90 degrees"
        )
        try:
            PatchGrid(zenith_bounds_deg=zenith, azimuth_bounds_deg=azimuth)
        except ValueError as error:
            raise _RefusedError("E954", names[0], str(error)) from None
    if law.tables is not None:
        shapes, expected = (arrays[names[2]].shape, arrays[names[3]].shape), law.tables(n_cell, len(arrays[names[3]]))
        message = f"found shapes {shapes}, wanted {expected} for law {number.name}"
        _require(shapes == expected, "E953", names[3], message)
    if has_slope:
        slope = arrays[names[4]]
        fits = slope.shape[1] == n_cell and len(slope) in (1, len(arrays["mass"]))
        _require(fits, "E953", names[4], f"found shape {slope.shape}, wanted a row for all masses or one for each")
        _require(np.all(np.abs(slope) <= MAX_SLOPE), "E954", names[4], f"wanted slopes up to {MAX_SLOPE} in size")
    refused = law.refused(arrays["cell"][start[k] : start[k + 1]], arrays.get(names[3]))
    if refused is not None:
        member, found, wanted = refused
        message = f"found {found} of component {k}, wanted {wanted}" if found else f"wanted {wanted}"
        raise _RefusedError("E954", f"{member}_{k}" if member in OF_COMPONENT else member, message)
