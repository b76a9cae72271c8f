"""A field of Stokes parameters with coordinates, as vector codes give it, as values over patches."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from aomc_sky.errors import FieldError, UsageError
from aomc_sky.formats.radiance_unit import radiance_factor
from aomc_sky.skies.field_axes import Axis, axis_of, field_and_bounds, radiances, stated_unit
from aomc_sky.skies.radiance_field import read_radiance_field

_NAME = re.compile(
    r"(?:(?:stokes|radiance|sky_radiance)_?)?([iqu])|([iqu])_(?:stokes|radiance)|"
    r".*\bstokes (?:parameter |component |vector )?([iqu])\b.*|(?:sky_)?radiance"
)
"""Names and long names of the three parameters, in small letters; the radiance alone is I."""
_SHARE = re.compile(r"\b[QU] ?/ ?I\b|\b(?:normali[sz]ed|reduced|fractional)\b", re.I)
_STOKES_Q = "_q"  # the name of Q where it is an entry of a dimension
_ROUNDED = 1e-4  # the solvers' own
_GAPS = ("valid_range", "valid_min", "valid_max", "_FillValue", "missing_value")


def stokes_fields(
    field: Any, variable: str | None, variable_q: str | None, variable_u: str | None
) -> tuple[Any, list[str]] | None:
    """A dataset and the names of I, Q and U in it; None for a field of radiances alone.

    They are three variables, or the entries I, Q, U of a dimension ``stokes`` as sasktran2 has it.
    """
    if (variable_q is None) != (variable_u is None):
        raise UsageError("variable_q and variable_u belong together: give both, or none")
    if variable_q is not None and len({variable, variable_q, variable_u}) < 3:
        raise FieldError("I, Q and U are three variables, and one is named twice", argument="variable_q")
    whole = field if hasattr(field, "data_vars") else field.to_dataset(name=field.name or "radiance")
    if "stokes" in whole.dims and variable_q is None:
        listed = np.atleast_1d(whole.coords.get("stokes", [])).tolist()
        found = {(one.decode("latin-1") if isinstance(one, bytes) else str(one)): k for k, one in enumerate(listed)}
        if not {"I", "Q", "U"} <= set(found):
            return None
        i, q, u = (whole.isel(stokes=found[name], drop=True) for name in "IQU")
        name = str(field_and_bounds(i, variable)[0].name)
        return i.assign({_STOKES_Q: q[name], "_u": u[name]}), [name, _STOKES_Q, "_u"]
    names = {"i": variable, "q": variable_q, "u": variable_u}
    if variable_q is not None:
        for argument, given in (("variable_q", variable_q), ("variable_u", variable_u)):
            if given not in whole.data_vars:
                raise FieldError(f"the dataset has no variable {given!r}", argument=argument)
        names["i"] = variable or str(field_and_bounds(whole.drop_vars([variable_q, variable_u]), None)[0].name)
    elif variable is None:
        for key, one in whole.data_vars.items():
            texts = str(key).lower(), str(one.attrs.get("long_name", "")).lower()
            if found_name := next(filter(None, map(_NAME.fullmatch, texts)), None):
                role = next(filter(None, found_name.groups()), "i")
                names[role] = names[role] or str(key)
    both = [name for name in (names["q"], names["u"]) if name is not None]
    if len(both) == 1 and names["i"] is not None and {*whole[both[0]].dims} == {*whole[names["i"]].dims}:
        advice = f"name both, --variable-q and --variable-u, or I alone, --variable {names['i']} (variable=)"
        raise FieldError(f"the field has {both[0]!r} beside {names['i']!r}: one of Q and U without the other", advice)
    return None if None in names.values() else (whole, list(map(str, names.values())))


def read_polarised_field(
    fields: tuple[Any, list[str]], stokes_signs: tuple[float, float], names: Mapping[str, str | None], **how: Any
) -> dict[str, Any]:
    """Turn I, Q and U with coordinates, of `stokes_fields`, into arguments of a `TabulatedSky`.

    Means of Q over patches are those of the radiances 2 I + Q and 2 I - Q, which are not negative: half of their
    difference. In the meridian plane Q and U go on across the zenith as radiances do. Lines of sight that are all pairs
    of some zenith angles and azimuths are a grid.
    """
    if len(stokes_signs) != 2 or any(sign not in (-1, 1) for sign in stokes_signs):
        raise UsageError(f"stokes_signs are two of 1 and -1, for Q and for U, got {stokes_signs!r}")
    dataset, (name, *others) = fields
    field, bounds = field_and_bounds(dataset, name)
    zenith, azimuth = (axis_of(field, role, names.get(role), bounds) for role in ("zenith", "azimuth"))
    assert zenith is not None
    if azimuth is not None and zenith.dims == azimuth.dims:
        dataset = _unstacked(dataset, zenith, azimuth)
        field, _ = field_and_bounds(dataset, name)
    light = radiances(field)
    if any({*dataset[one].dims} != {*field.dims} for one in others):
        raise FieldError(f"Q and U want the dimensions of {name!r}: {field.dims}", argument="variable")
    of_light = stated_unit(field.attrs) or how.get("radiance_unit") or ""
    for one in others:
        unit, share = stated_unit(dataset[one].attrs), _SHARE.search(str(dataset[one].attrs.get("long_name", "")))
        share = None if _SHARE.search(str(field.attrs.get("long_name", ""))) else share
        if share or (unit != of_light and not _is_same(unit, of_light)):
            what = f"is a share by its text, {share[0]!r}" if share else f"has the unit {unit!r}"
            message = f"{one!r} {what}, and {name!r} has the unit {of_light!r}"
            raise FieldError(message, "give Q and U in the unit of I: a share times I", "variable_q")
    q, u = (
        sign * radiances(dataset[one].transpose(*field.dims)) for sign, one in zip(stokes_signs, others, strict=True)
    )
    if not np.all(np.isfinite([light, q, u])):
        alone = "field.isel(stokes=0) (--isel stokes=0)" if others[0] == _STOKES_Q else f"--variable {name} (variable=)"
        advice = f"interpolate I, Q and U to such a grid, or give I alone: {alone}"
        raise FieldError("a polarised field wants I, Q and U in every direction of a grid, without gaps", advice)
    if np.any(np.hypot(q, u) > np.abs(light) * (1.0 + _ROUNDED)):
        raise FieldError("the field has more polarised light than light", "give Q and U in the unit of I", "variable")

    def values_of(radiance: np.ndarray) -> np.ndarray:
        made = field.copy(data=radiance)
        made.attrs, made.encoding = {key: value for key, value in field.attrs.items() if key not in _GAPS}, {}
        read = read_radiance_field(dataset.assign({name: made}), variable=name, names=names, **how)
        return np.asarray(read["values"].reshape(len(read["values"]), -1))

    read = read_radiance_field(dataset, variable=name, names=names, **how)
    values, shares = read["values"].reshape(len(read["values"]), -1), []
    for part in (q, u):
        above, below = values_of(2.0 * light + part), values_of(2.0 * light - part)
        total = above + below
        shares.append(np.divide(2.0 * (above - below), total, out=np.zeros_like(total), where=total > 0))
    both = np.stack(shares) * (values / np.maximum(np.hypot(*shares), 1.0))
    largest = np.max(np.hypot(q, u)[light > 0] / light[light > 0], initial=0.0)
    said = f"photons carry q and u of Q and U of the field, of a degree up to {largest:.2g}; V is not read"
    remarks = (*read["remarks"], said)
    return {**read, "values": values, "values_q": both[0], "values_u": both[1], "remarks": remarks}


def _is_same(unit: str, of_light: str) -> bool:
    """Whether Q or U may be in the unit of I: it states none, or the same in other words."""
    return not unit or (radiance_factor(unit) or None) == radiance_factor(of_light)


def _unstacked(dataset: Any, zenith: Axis, azimuth: Axis) -> Any:
    """The dataset with a dimension for each of the two angles; pairs that are absent are NaN."""
    attributes = {one.name: dataset[one.name].attrs for one in (zenith, azimuth)}
    try:
        made = dataset.set_index({zenith.dims[0]: list(attributes)}).unstack(zenith.dims[0])
    except Exception as error:  # whatever xarray says of directions that come twice, or of several dimensions
        raise FieldError("a polarised field wants each direction of a grid once, without gaps", str(error)) from error
    for name, attrs in attributes.items():
        made[name].attrs = attrs
    return made
