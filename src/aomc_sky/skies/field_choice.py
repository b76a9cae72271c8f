"""The radiance of a field with coordinates: which variable it is, and what stands beside it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from aomc_sky.directions import AzimuthConvention, to_enu_azimuth_deg
from aomc_sky.errors import FieldError
from aomc_sky.formats.azimuth import convention_of
from aomc_sky.formats.radiance_words import (
    ANGLE_DEGREES,
    COORDINATES,
    RADIANCE,
    RADIANCE_Q,
    RADIANCE_U,
    SAY_SUN,
    Stated,
    SunAngles,
    plain_unit,
)
from aomc_sky.formats.report import printable
from aomc_sky.skies.field_axes import bounds_name, named_role

MAX_NAMES = 40
SUN_NAMES = ("sun_zenith_deg", "sun_azimuth_deg")
_SAY_ANGLE_OF_SUN = {SUN_NAMES[0]: "write --sun-zenith DEG (sun_zenith_deg=)", SUN_NAMES[1]: SAY_SUN}
_SAME_DEG = 1e-3  #: Suns that are nearer are one: float32 has less.


@dataclass(frozen=True, kw_only=True, slots=True)
class Chosen:
    """The radiance of a field, and what stands beside it."""

    radiance: Any  #: xarray.DataArray with its coordinates of numbers
    stokes: tuple[Any, Any] | None  #: Q and U, alike
    bounds: dict[str, Any]
    attributes: dict[str, Any]  #: Of the file
    others: tuple[str, ...]  #: Names of all other variables and coordinates
    along: dict[str, tuple[str, ...]]  #: Dimensions of those of numbers
    sun: dict[str, list[Any]]  #: What the file has under the names of the sun's angles, at each place

    @property
    def n_bytes(self) -> int:
        """Bytes of all arrays as float64."""
        return sum(math.prod(one.shape) * 8 for one in self._parts)

    @property
    def _parts(self) -> tuple[Any, ...]:
        return (self.radiance, *self.radiance.coords.values(), *(self.stokes or ()), *self.bounds.values())

    def loaded(self) -> Chosen:
        """The same in memory."""
        stokes = None if self.stokes is None else (self.stokes[0].load(), self.stokes[1].load())
        bounds = {name: one.load() for name, one in self.bounds.items()}
        return replace(self, radiance=self.radiance.load(), stokes=stokes, bounds=bounds)


def choose(field: Any, stated: Stated) -> Chosen:
    """The radiance, and Q and U, of an xarray.DataArray or Dataset, by what is stated; FieldError.

    Variables over a part of its dimensions are coordinates, too: some programs do not mark them as such.
    """
    stated.check()
    if not hasattr(field, "data_vars"):
        if not all(hasattr(field, name) for name in ("coords", "dims", "shape", "values")):
            raise FieldError(
                f"a radiance field is an xarray.DataArray or Dataset with coordinates, got {type(field).__name__}",
                "give values without coordinates to sky.TabulatedSky(grid=, wavelength_nm=, values=)",
            )
        field = field.to_dataset(name=RADIANCE if field.name in (None, *field.coords) else field.name)
    if stated.decimal is not None:
        raise FieldError("decimal is for a table of text", "leave it out", "decimal")
    for dim in [dim for dim in field.dims if dim in field.indexes and field.indexes[dim].nlevels > 1]:
        field = field.reset_index(dim)  # stacked directions; `indexes` has their levels, too
    whole = _at_indices(field, dict(stated.isel))
    entries = _stokes_entries(whole, stated)
    name, *stokes = _names(whole if entries is None else entries[0], stated)
    radiance = (whole if entries is None else entries[0])[name]
    others = None
    if entries is not None:
        others = (entries[1][name], entries[2][name])
    elif stokes:
        others = (whole[stokes[0]], whole[stokes[1]])
    if empty := [str(dim) for dim, size in zip(radiance.dims, radiance.shape, strict=True) if size == 0]:
        raise FieldError(f"the field has no values: its dimension {empty[0]!r} has length 0")
    named = {one for one in (getattr(stated, role) for role in COORDINATES) if one is not None}
    beside = {
        str(key): one
        for key, one in whole.data_vars.items()
        if key not in (name, *stokes)
        and one.ndim
        and one.dtype.kind in "biuf"
        and ({*one.dims} < {*radiance.dims} or ({*one.dims} == {*radiance.dims} and (key in named or named_role(key))))
    }
    texts = [key for key, axis in radiance.coords.items() if axis.dtype.kind not in "biuf"]
    radiance = radiance.drop_vars(texts).assign_coords(beside)
    edges = {bounds_name(axis) for axis in radiance.coords.values()}
    return Chosen(
        radiance=radiance,
        stokes=others,
        bounds={key: whole[key].reset_coords(drop=True) for key in edges if key in whole.variables},
        attributes=dict(whole.attrs),
        others=tuple(str(key) for key in whole.variables if key not in (name, *stokes, *edges, *whole.dims)),
        along={
            str(key): tuple(map(str, one.dims))
            for key, one in whole.variables.items()
            if one.dtype.kind in "iuf" and key not in (name, *stokes, *edges, *SUN_NAMES)
        },
        sun={
            key: [place[key] for place in (whole.attrs, radiance.attrs, whole.variables) if key in place]
            for key in SUN_NAMES
        },
    )


def _at_indices(field: Any, isel: Mapping[str, int]) -> Any:
    for dim, index in isel.items():
        if dim not in field.sizes:
            shown = ", ".join(repr(str(one)) for one in field.sizes)
            raise FieldError(printable(f"the field has no dimension {dim!r}; it has {shown}"), argument="isel")
        if not 0 <= index < field.sizes[dim]:
            message = f"dimension {dim!r} has indices 0 to {field.sizes[dim] - 1}, not {index}"
            raise FieldError(printable(message), argument="isel")
    return field.isel(isel)


def _stokes_entries(whole: Any, stated: Stated) -> tuple[Any, Any, Any] | None:
    """The entries I, Q and U of a dimension ``stokes``, as sasktran2 has them; None without."""
    if "stokes" not in whole.dims or stated.variable_q is not None:
        return None
    listed = np.atleast_1d(whole.coords.get("stokes", [])).tolist()
    found = {(one.decode("latin-1") if isinstance(one, bytes) else str(one)): k for k, one in enumerate(listed)}
    if not {"I", "Q", "U"} <= set(found):
        return None
    i, q, u = (whole.isel(stokes=found[name], drop=True) for name in "IQU")
    return i, q, u


def _names(dataset: Any, stated: Stated) -> list[str]:
    """Names of the radiance, and of Q and U where they are stated or have their names."""
    edges = {bounds_name(one) for one in dataset.variables.values()}
    edges |= {word for one in dataset.variables.values() for word in str(one.attrs.get("cell_measures", "")).split()}
    roles = {getattr(stated, role): role for role in COORDINATES if getattr(stated, role) is not None}
    numbers = {
        str(name): one
        for name, one in dataset.data_vars.items()
        if one.dtype.kind in "biufc" and one.ndim and name not in edges and name not in roles
    }
    for argument in ("variable", "variable_q", "variable_u"):
        given = getattr(stated, argument)
        if given is not None and given not in numbers:
            shown = ", ".join(map(repr, list(numbers)[:MAX_NAMES])) or "none at all"
            message = f"the file has no variable {given!r} of numbers; it has {shown}"
            raise FieldError(printable(message), argument=argument)
    stokes = [stated.variable_q, stated.variable_u] if stated.variable_q is not None else [RADIANCE_Q, RADIANCE_U]
    name = stated.variable or (RADIANCE if RADIANCE in numbers else None)
    if name is None:
        angles = {
            dim
            for key, one in dataset.variables.items()
            if named_role(str(key)) in COORDINATES[:3] or roles.get(key) in COORDINATES[:3]
            for dim in one.dims
        }
        light = {key: one for key, one in numbers.items() if not named_role(key) and key not in stokes}
        most = max((one.ndim for one in light.values()), default=0)
        fitting = [key for key, one in light.items() if angles <= {*one.dims}] if angles else []
        fitting = fitting or [key for key, one in light.items() if one.ndim == most]
        if not fitting:
            advice = "write a group into a file of its own: xarray.open_dataset(path, group='NAME').to_netcdf(...)"
            raise FieldError("the file has no variables of numbers outside of groups", advice)
        if len(fitting) > 1:
            shown = ", ".join(map(repr, fitting[:MAX_NAMES]))
            message = f"none of {len(fitting)} variables has the name radiance: {shown}"
            raise FieldError(printable(message), "write --variable NAME (variable=)", "variable")
        name = fitting[0]
    if stated.variable_q is not None:
        if len({name, *stokes}) < 3:
            raise FieldError("I, Q and U are three variables, and one is named twice", argument="variable_q")
        return [name, *map(str, stokes)]
    there = [str(one) for one in stokes if one in numbers]
    if stated.variable is not None or not there:
        return [name]
    if len(there) == 1:
        advice = f"name both, --variable-q and --variable-u, or I alone, --variable {name} (variable=)"
        raise FieldError(f"the field has {there[0]!r} beside {name!r}: one of Q and U without the other", advice)
    return [name, *there]


def sun_of(chosen: Chosen, given: SunAngles, convention: AzimuthConvention | None) -> SunAngles:
    """The angles of the sun that the file states and the caller does not.

    Its azimuth counts by its own convention, or that of the others.
    """
    found: list[float | None] = []
    for (name, places), own in zip(chosen.sun.items(), given, strict=True):
        values = [] if own is not None else [_angle_of_sun(name, one, convention) for one in places]
        if np.ptp(values or [0.0]) > _SAME_DEG:
            message = f"{name} of the file is {' and '.join(f'{one:g}' for one in sorted(values))}"
            raise FieldError(message, f"keep one of them, or {_SAY_ANGLE_OF_SUN[name]}", "table")
        found.append(next(iter(values), None))
    return found[0], found[1]


def _angle_of_sun(name: str, stated: Any, convention: AzimuthConvention | None) -> float:
    """One statement: a number of an attribute, or of a variable with attributes. [deg]"""
    attributes = getattr(stated, "attrs", {})
    advice = f"{_SAY_ANGLE_OF_SUN[name]}, or one number of degrees in the file"
    try:
        (value,) = np.asarray(getattr(stated, "values", stated), dtype=np.float64).ravel().tolist()
    except (TypeError, ValueError):
        raise FieldError(f"{name} of the file is not one number", advice) from None
    if ANGLE_DEGREES.get(plain_unit(str(attributes.get("units", "deg")))) != 1.0:
        raise FieldError(f"{name} of the file has the unit {attributes['units']!r}", advice)
    low, high = (0.0, 180.0) if name == SUN_NAMES[0] else (-360.0, 360.0)
    if not low <= value <= high:
        raise FieldError(f"{name} of the file is {value:g}, and not {low:g} to {high:g} degrees", advice)
    if name == SUN_NAMES[0]:
        return float(value)
    text = str(attributes.get("azimuth_convention", ""))
    counts = convention_of(text) if text else convention
    if counts is None or counts.is_from_sun:
        raise FieldError(f"nothing says from where {name} of the file counts", SAY_SUN)
    return float(to_enu_azimuth_deg(value, counts))
