"""A field of Stokes parameters with coordinates, as vector codes give it, as values over patches."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from aomc_sky.errors import FieldError, UsageError
from aomc_sky.skies.field_axes import Axis, axis_of, field_and_bounds, radiances
from aomc_sky.skies.radiance_field import read_radiance_field

_NAMES = (
    re.compile(r"(?:(?:stokes|radiance|sky_radiance)_?)?([iqu])"),
    re.compile(r"([iqu])_(?:stokes|radiance)"),
    re.compile(r".*\bstokes (?:parameter |component |vector )?([iqu])\b.*"),
)
"""Names and long names of the three parameters, in small letters; I may be called the radiance alone, too."""
_RADIANCE = ("radiance", "sky_radiance")
_ROUNDED = 1e-4  # the solvers' own
_GAPS = ("valid_range", "valid_min", "valid_max", "_FillValue", "missing_value")


def stokes_fields(
    field: Any, variable: str | None, variable_q: str | None, variable_u: str | None
) -> tuple[Any, tuple[str, str, str]] | None:
    """A dataset and the names of I, Q and U in it; None for a field of radiances alone.

    They are three variables, or the entries I, Q, U of a dimension ``stokes`` as sasktran2 has it.
    """
    if (variable_q is None) != (variable_u is None):
        raise UsageError("variable_q and variable_u belong together: give both, or none")
    if not hasattr(field, "isel"):
        return None
    whole = field if hasattr(field, "data_vars") else field.to_dataset(name=field.name or "radiance")
    if "stokes" in whole.dims and variable_q is None:
        found = {str(name): k for k, name in enumerate(np.atleast_1d(whole.coords.get("stokes", [])).tolist())}
        if not {"I", "Q", "U"} <= set(found):
            return None
        of = [whole.isel(stokes=found[name], drop=True) for name in "IQU"]
        name = str(field_and_bounds(of[0], variable)[0].name)
        return of[0].assign(_q=of[1][name], _u=of[2][name]), (name, "_q", "_u")
    names = {"i": variable, "q": variable_q, "u": variable_u}
    if variable_q is None and (variable is not None or not hasattr(field, "data_vars")):
        return None
    if variable_q is None:
        for key, one in whole.data_vars.items():
            texts = str(key).lower(), str(one.attrs.get("long_name", "")).lower()
            role = next((m[1] for text in texts for pattern in _NAMES if (m := pattern.fullmatch(text))), None)
            role = "i" if texts[0] in _RADIANCE else role
            if role is not None and names[role] is None:
                names[role] = str(key)
    elif variable is None:
        names["i"] = str(field_and_bounds(whole.drop_vars([variable_q, variable_u], errors="ignore"), None)[0].name)
    if missing := [name for name in (variable_q, variable_u) if name is not None and name not in whole.data_vars]:
        raise FieldError(f"the dataset has no variable {missing[0]!r}", argument="variable")
    if None in names.values():
        return None
    return whole, (str(names["i"]), str(names["q"]), str(names["u"]))


def read_polarised_field(
    fields: tuple[Any, tuple[str, str, str]],
    stokes_signs: tuple[float, float],
    names: Mapping[str, str | None],
    **how: Any,
) -> dict[str, Any]:
    """Turn I, Q and U with coordinates, of `stokes_fields`, into arguments of a `TabulatedSky`.

    Means of Q over patches are those of the radiances 2 I + Q and 2 I - Q, which are not negative: half of their
    difference. In the meridian plane Q and U go on across the zenith as radiances do. Lines of sight that are all pairs
    of some zenith angles and azimuths are a grid.
    """
    if len(stokes_signs) != 2 or any(sign not in (-1, 1) for sign in stokes_signs):
        raise UsageError(f"stokes_signs are two of 1 and -1, for Q and for U, got {stokes_signs!r}")
    dataset, (name, *others_names) = fields
    zenith, azimuth = _axes(dataset, name, names)
    if azimuth is not None and zenith.dims == azimuth.dims and len(zenith.dims) == 1:
        dataset = _unstacked(dataset, zenith, azimuth)
        zenith, azimuth = _axes(dataset, name, names)
    field, others = field_and_bounds(dataset, name)[0], [dataset[other] for other in others_names]
    light = radiances(field)
    if any({*one.dims} != {*field.dims} for one in others):
        raise FieldError(f"Q and U want the dimensions of {name!r}: {field.dims}", argument="variable")
    q, u = (sign * radiances(one.transpose(*field.dims)) for sign, one in zip(stokes_signs, others, strict=True))
    if (azimuth is not None and zenith.dims == azimuth.dims) or not np.all(np.isfinite([light, q, u])):
        advice = "interpolate I, Q and U to such a grid, or give I alone: field.isel(stokes=0), or variable='NAME'"
        raise FieldError("a polarised field wants I, Q and U in every direction of a grid, without gaps", advice)
    if np.any(np.hypot(q, u) > np.abs(light) * (1.0 + _ROUNDED)):
        raise FieldError("the field has more polarised light than light", "give Q and U in the unit of I", "variable")
    read = read_radiance_field(dataset, variable=name, names=names, **how)
    values = read["values"].reshape(len(read["values"]), -1)

    def mean_share(part: np.ndarray) -> np.ndarray:
        above, below = (
            read_radiance_field(
                dataset.assign({name: _replaced(field, 2.0 * light + s * part)}), variable=name, names=names, **how
            )
            for s in (1.0, -1.0)
        )
        above, below = above["values"].reshape(values.shape), below["values"].reshape(values.shape)
        total = above + below
        return np.divide(2.0 * (above - below), total, out=np.zeros_like(total), where=total > 0)

    shares = np.stack([mean_share(q), mean_share(u)])
    shares /= np.maximum(np.hypot(*shares), 1.0)
    return {**read, "values": values, "values_q": shares[0] * values, "values_u": shares[1] * values}


def _axes(dataset: Any, name: str, names: Mapping[str, str | None]) -> tuple[Axis, Axis | None]:
    """Zenith angles and azimuths of a variable."""
    field, bounds = field_and_bounds(dataset, name)
    zenith, azimuth = (axis_of(field, role, names.get(role), bounds) for role in ("zenith", "azimuth"))
    assert zenith is not None
    return zenith, azimuth


def _unstacked(dataset: Any, zenith: Axis, azimuth: Axis) -> Any:
    """The dataset with a dimension for each of the two angles; pairs that are absent are NaN."""
    attributes = {one.name: dataset[one.name].attrs for one in (zenith, azimuth)}
    try:
        made = dataset.set_index({zenith.dims[0]: [zenith.name, azimuth.name]}).unstack(zenith.dims[0])
    except Exception:  # whatever xarray says of directions that come twice
        return dataset
    for name, attrs in attributes.items():
        made[name].attrs = attrs
    return made


def _replaced(field: Any, values: np.ndarray) -> Any:
    """A field with other values, for which the gaps and the range of the old ones do not hold."""
    made = field.copy(data=values)
    made.attrs = {key: value for key, value in field.attrs.items() if key not in _GAPS}
    made.encoding = {}
    return made
