"""Checks of a plan before a kernel uses its numbers as indices.

Kernels check no index. Therefore every number of a plan that serves as one is checked here: types and lengths of the
members of a file, then laws, counts and bins of lobes in the records of a plan. Decision 22 lists each look-up of the
kernels with its rule. These checks do not compare the plan with a scene: `verify --scene` does.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from aomc_sky.component import MOST_WEIGHT, N_CELL_PARAMETERS, Component, Law, is_polarisation
from aomc_sky.errors import AomcSkyError, InputFileError
from aomc_sky.formats.text_file import refuse
from aomc_sky.plan.allocation import MAX_PHOTONS, AllocationMethod, PlanBand
from aomc_sky.plan.bias import checked_bias
from aomc_sky.plan.laws import law_of
from aomc_sky.plan.options import (
    MAX_REPLICATES,
    Footprint,
    Method,
    Order,
    Placement,
    Precision,
    method_of,
)
from aomc_sky.plan.streams import MAX_SEED, PHOTON_STREAMS, STREAM_VERSION, photon_keys
from aomc_sky.whole_number import as_index_within

MAX_CELLS = 2**31 - 1
"""Cells have numbers of type int32 in batches and tables."""

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
    "keys": ("<u8", (len(PHOTON_STREAMS),)),
}
"""Type and lengths of the arrays that every plan has; equal names are equal lengths."""

OPTIONAL = {
    "bias": ("<f8", ("n_row", "n_cell")),
    "irradiance_W_m2_nm": ("<f8", ("n_band", "n_component")),
    "horizon_loss": ("<f8", ("n_band",)),
}
"""Arrays of plans whose photons are shared out otherwise than light, and of those whose absolute units are known."""

COMPONENT_MEMBERS = {
    "zenith_bounds_deg": ("<f8", ("n_ring", 2)),
    "azimuth_bounds_deg": ("<f8", ("n_column", 2)),
    "shared": ("<f8", ("n_shared",)),
    "bounds": ("<f8", ("n_bound", "n_bound_column")),
    "slope": ("<f8", ("n_slope_row", "n_slope", 2)),
    "stokes": ("<f8", ("n_stokes_row", "n_stokes", 2)),
}
"""Arrays of component k, whose names end in _k."""

OPTIONS = {
    *("stream", "seed", "method", "allocation", "placement", "order", "precision", "weights", "replicates"),
    *("footprint", "components", "azimuth_first_index"),
}
_OF_BIAS = {"bias", "importance"}
"""Options of plans with a bias: shares of the photons by name, and the components of an importance."""

_VERSIONS = {f"aomc-sky/{k}": f"aomc-sky 0.{k}" for k in (1, 2, 3)}
_NAME = re.compile(r"[!-+\--~]([ -+\--~]{0,198}[!-+\--~])?")
_LARGEST = 1e300
_MOST_MASS = 1.0 + 2.0**-30  # a sum of normalised masses is 1 within a few ulp


def refused(code: str, member: str, message: str, path: str = "plan") -> InputFileError:
    """The error for a member of a plan, or an option, that does not fit."""
    advice = "make the run again, or take the plan.npz that it wrote"
    return refuse(path, message, code=code, name=member, advice=advice)


def _require(holds: object, code: str, member: str, message: str) -> None:
    if not holds:
        raise refused(code, member, message)


def check_stream(options: Any, path: str = "plan") -> None:
    """Raise E955 unless the photons of the options are those of this version."""
    if not isinstance(options, Mapping):
        raise refused("E955", "options", "is no object", path)
    if (stream := options.get("stream")) != STREAM_VERSION:
        made_with = _VERSIONS.get(str(stream), "the version that made them")
        message = (
            f"made with the random streams {ascii(stream)[:40]}; this version has {STREAM_VERSION!r}, which give other "
            f"photons; verify old runs with {made_with}, or run the scene again"
        )
        raise refused("E955", "options.stream", message, path)


def _check_options(options: Any) -> None:
    check_stream(options)
    odd = sorted(map(str, (OPTIONS | (_OF_BIAS if "bias" in options else set())) ^ set(options)))
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
        raise refused("E955", "options", str(error)[:300]) from None
    expected = method_of(allocation, placement)
    _require(method is expected, "E955", "options.method", f"found {method.value}, expected {expected.value}")
    _require(type(options["weights"]) is bool, "E955", "options.weights", "is neither true nor false")
    are_names = are_names and isinstance(names, list) and 0 < len(names) == len(set(names)) == len(first)
    message = "expected different plain names of at most 200 characters, and a first index for each"
    _require(are_names, "E955", "options.components", message)


def check_members(members: Mapping[str, Any], options: Any) -> None:
    """Raise unless components can be made: E952 (a member is missing or not known), E953 (type or shape), E954, E955.

    Only the first problem is reported, here and in `check_plan`: the others follow from it.
    """
    _check_options(options)
    lengths = {"n_component": len(options["components"])}
    component_member = re.compile(rf"({'|'.join(COMPONENT_MEMBERS)})_(0|[1-9]\d{{0,5}})")
    for name, (dtype, shape) in MEMBERS.items():
        _require(name in members, "E952", name, "this array is missing")
        _check_shape(name, members[name], dtype, shape, lengths)
        if name == "requested":
            lengths["n_replicate_band"] = options["replicates"] * lengths["n_band"]
    both = ("irradiance_W_m2_nm" in members) == ("horizon_loss" in members)
    _require(both, "E952", "horizon_loss", "irradiance_W_m2_nm and horizon_loss belong together")
    for name in members:
        if name in OPTIONAL:
            _check_shape(name, members[name], *OPTIONAL[name], lengths)
        elif name not in MEMBERS:
            found = component_member.fullmatch(name)
            is_known = found is not None and int(found[2]) < lengths["n_component"]
            _require(is_known, "E952", ascii(name)[:100], "is not an array of a plan with these options")
            assert found is not None
            _check_shape(name, members[name], *COMPONENT_MEMBERS[found[1]], {})
    shape = members["weight"].shape
    fits = shape in ((0, 0), members["mass"].shape)
    _require(fits, "E953", "weight", f"found shape {shape}, expected that of mass, or (0, 0) for none")
    same = np.array_equal(members["keys"], photon_keys(options["seed"], options["method"]))
    _require(same, "E954", "keys", f"expected the keys that follow from seed {options['seed']}")
    mass = members["mass"]
    _require(np.all((mass >= 0) & (mass <= _MOST_MASS)), "E954", "mass", "expected masses from 0 to 1")
    weight = members["weight"]
    _require(
        np.all((weight >= 0) & (weight <= MOST_WEIGHT)), "E954", "weight", f"expected weights from 0 to {MOST_WEIGHT:g}"
    )
    n_cell, start, law = lengths["n_cell"], members["component_start"], members["law"]
    rises = start[0] == 0 and start[-1] == n_cell and np.all(start[1:] > start[:-1])
    _require(rises, "E954", "component_start", f"expected increasing cell numbers from 0 to {n_cell}")
    _require(np.isin(law, list(Law)).all(), "E954", "law", f"expected laws from {min(Law)} to {max(Law)}")
    changes = np.flatnonzero(law[1:] != law[:-1]) + 1
    _require(np.isin(changes, start).all(), "E954", "law", "expected one law for all cells of a component")
    for k, number in enumerate(law[start[:-1]].tolist()):
        _check_kinds(k, Law(number), {name for name in COMPONENT_MEMBERS if f"{name}_{k}" in members})
        for name in (f"slope_{k}", f"stokes_{k}"):
            rows = members.get(name)
            fits = rows is None or (rows.shape[1] == start[k + 1] - start[k] and len(rows) in (1, len(mass)))
            _require(fits, "E953", name, "expected a row for all masses or one for each, of all cells")
        fits = f"stokes_{k}" not in members or is_polarisation(members[f"stokes_{k}"])
        _require(fits, "E954", f"stokes_{k}", "expected Q/I and U/I of a degree from 0 to 1")


def _check_kinds(k: int, law: Law, found: set[str]) -> None:
    """Component k has the arrays of its law."""
    rules = law_of(law)
    expected = {"shared", "bounds"} if rules.tables else {"slope"} if rules.has_slopes else set()
    grid = {"zenith_bounds_deg", "azimuth_bounds_deg"}
    fits = found - grid - {"stokes"} == expected and found & grid in ((grid,) if rules.needs_patches else (grid, set()))
    _require(fits, "E952", f"zenith_bounds_deg_{k}", f"the arrays of component {k} are not those of law {law.name}")


def _check_shape(name: str, array: Any, dtype: str, shape: tuple[str | int, ...], lengths: dict[str, int]) -> None:
    is_array = isinstance(array, np.ndarray) and array.ndim == len(shape)
    fits = is_array and array.dtype.newbyteorder("<").str == dtype and array.dtype.isnative
    for axis, length in enumerate(shape if fits else ()):
        text, _, more = str(length).partition(" + ")
        size = array.shape[axis] - int(more or 0)
        expected = length if isinstance(length, int) else lengths.setdefault(text, size)
        fits = fits and size == expected and (size > 0 or text.startswith("n_weight"))
    found = f"{array.dtype} of shape {array.shape}" if isinstance(array, np.ndarray) else type(array).__name__
    _require(fits, "E953", name, f"found {found}, expected {dtype} of shape {shape} with {lengths}")


def check_plan(
    bands: Sequence[PlanBand],
    components: Sequence[Component],
    cumulative: np.ndarray,
    options: Mapping[str, Any],
    bias: np.ndarray | None = None,
) -> None:
    """Raise unless photons can be made from the records of a plan: E953 (shape), E954 (values), E955 (options)."""
    _check_options(options)
    names = [component.name for component in components]
    _require(names == options["components"], "E955", "options.components", f"found components {names}")
    n_cell, n_row = sum(component.n_cells for component in components), len(components[0].mass)
    _require(n_cell <= MAX_CELLS, "E954", "law", f"found {n_cell} cells, at most {MAX_CELLS} are allowed")
    _check_bands(bands, len(components), n_row)
    shape = (options["replicates"] * len(bands), n_cell + 1)
    _check_shape("cumulative", cumulative, "<i8", shape, {})
    in_range = cumulative.min() >= 0 and cumulative.max() <= MAX_PHOTONS
    _require(in_range, "E954", "cumulative", f"expected numbers of photons from 0 to {MAX_PHOTONS}")
    rises = not cumulative[:, 0].any() and all(np.all(row[1:] >= row[:-1]) for row in cumulative)
    _require(rises, "E954", "cumulative", "expected photons before each cell, from 0 and increasing")
    for law in {component.law for component in components}:
        n = sum(component.law is law for component in components)
        message = f"found {n} components of law {law.name}, at most one is allowed"
        _require(n == 1 or not law_of(law).instead, "E954", "law", message)
    is_table = len(components) == 1 and components[0].grid is not None and options["replicates"] == 1
    is_aomc = options["allocation"] == AllocationMethod.AOMC.value
    message = "found aomc, which wants one table and no replicates"
    _require(is_table or not is_aomc, "E955", "options.allocation", message)
    is_plain = components[0].weight is None
    _require(is_plain or options["weights"], "E953", "weight", "found weights, which the options do not ask for")
    for k, component in enumerate(components):
        _require(len(component.mass) == n_row, "E953", "mass", f"expected {n_row} rows in component {k}")
        _require((component.weight is None) == is_plain, "E953", "weight", "expected weights of all components or none")
        _check_component(component, k)
    _check_bias(components, options, bias)


def _check_bias(components: Sequence[Component], options: Mapping[str, Any], bias: np.ndarray | None) -> None:
    has_options = "bias" in options
    _require(has_options == (bias is not None), "E952", "bias", "the array and the option bias go together")
    if bias is None:
        return
    is_random = options["allocation"] in (AllocationMethod.SYSTEMATIC.value, AllocationMethod.MULTINOMIAL.value)
    message = "a bias needs systematic or multinomial allocation, and no weights of photons"
    _require(is_random and components[0].weight is None, "E955", "options.bias", message)
    names, mass = options["components"], np.concatenate([component.mass for component in components], axis=1)
    shares, of_importance = options["bias"], options["importance"]
    fits = isinstance(shares, Mapping) and isinstance(of_importance, list)
    fits = fits and all(name in names for name in [*shares, *of_importance])
    fits = fits and all(type(share) in (int, float) and 0 < share <= 1 for share in shares.values())
    _require(fits, "E955", "options.bias", "expected shares of components, and components with an importance")
    fault = checked_bias(bias, mass)
    _require(not fault, "E954", "bias", fault)


def _check_bands(bands: Sequence[PlanBand], n_component: int, n_row: int) -> None:
    _require(len(bands) > 0, "E953", "wavelength_nm", "expected at least one waveband")
    n_absolute = 0 if bands[0].irradiance_W_m2_nm is None else n_component
    for band in bands:
        irradiance = band.irradiance_W_m2_nm or ()
        fits = len(irradiance) == n_absolute
        _require(fits, "E953", "irradiance_W_m2_nm", f"expected {n_absolute} values in each waveband")
        _require_finite("irradiance_W_m2_nm", np.array(irradiance))
        _require_finite("horizon_loss", band.horizon_loss)
        _require_finite("wavelength_nm", band.wavelength_nm)
        _require(0 <= band.row < n_row, "E954", "row_of_band", "expected rows of mass")
        in_range = 0 <= band.requested <= MAX_PHOTONS
        _require(in_range, "E954", "requested", f"expected numbers of photons from 0 to {MAX_PHOTONS}")


def _check_component(component: Component, k: int) -> None:
    """Check the arrays of a component, and the numbers in them that kernels use as indices or limits."""
    law, grid, n_cell = law_of(component.law), component.grid, component.n_cells
    arrays = {name: getattr(component, name) for name in ("shared", "bounds", "slope")}
    kinds = {name for name, array in arrays.items() if array is not None}
    _check_kinds(k, component.law, kinds if grid is None else kinds | {"zenith_bounds_deg", "azimuth_bounds_deg"})
    for name, array in (("mass", component.mass), ("cell", component.cell), ("weight", component.weight)):
        _require_finite(name, array)
    for name, array in arrays.items():
        _require_finite(f"{name}_{k}", array)
    if grid is not None:
        member = f"zenith_bounds_deg_{k}"
        _require(grid.n_patches == n_cell, "E954", member, f"expected as many patches as cells, {n_cell}")
        _require_finite(f"azimuth_bounds_deg_{k}", grid.azimuth_bounds_deg)
    if law.tables is not None:
        assert component.shared is not None
        assert component.bounds is not None
        shapes = component.shared.shape, component.bounds.shape
        expected = law.tables(n_cell, len(component.bounds))
        message = f"found shapes {shapes}, expected {expected} for law {component.law.name}"
        _require(shapes == expected, "E953", f"bounds_{k}", message)
    fault = law.refused(component.cell, component.bounds)
    if fault is not None:
        member, found, allowed = fault
        message = f"found {found} of component {k}, expected {allowed}" if found else f"expected {allowed}"
        raise refused("E954", f"{member}_{k}" if member in COMPONENT_MEMBERS else member, message)


def _require_finite(member: str, values: Any) -> None:
    holds = values is None or np.all(np.abs(values) <= _LARGEST)
    _require(holds, "E954", member, f"found numbers that are not finite or above {_LARGEST:g}")
