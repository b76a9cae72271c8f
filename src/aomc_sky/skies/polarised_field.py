"""A field of Stokes parameters with coordinates, as vector codes give it, as values over patches."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from aomc_sky.errors import FieldError
from aomc_sky.formats.radiance_unit import radiance_factor
from aomc_sky.formats.radiance_words import Stated, SunAngles
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.field_axes import Axis, axis_of, radiances
from aomc_sky.skies.field_choice import Chosen
from aomc_sky.skies.radiance_field import Made, read_radiance_field

_ROUNDED = 1e-4  # the solvers' own
_GAPS = ("valid_range", "valid_min", "valid_max", "_FillValue", "missing_value")


def read_polarised_field(
    chosen: Chosen, stated: Stated, *, grid: PatchGrid | None, sun: SunAngles, other_sun: SunAngles = (None, None)
) -> Made:
    """Turn I, Q and U with coordinates into arguments of a `TabulatedSky`.

    Means of Q over patches are those of the radiances 2 I + Q and 2 I - Q, which are not negative: half of their
    difference. In the meridian plane Q and U go on across the zenith as radiances do. Lines of sight that are all pairs
    of some zenith angles and azimuths are a grid.
    """
    how: dict[str, Any] = {"grid": grid, "sun": sun, "other_sun": other_sun}
    zenith, azimuth = (axis_of(chosen.radiance, role, stated, chosen.bounds) for role in ("zenith", "azimuth"))
    assert zenith is not None
    if azimuth is not None and zenith.dims == azimuth.dims:
        chosen = _unstacked(chosen, zenith, azimuth)
    field, others = chosen.radiance, chosen.stokes or ()
    light, name = radiances(field), field.name
    if any({*one.dims} != {*field.dims} for one in others):
        raise FieldError(f"Q and U want the dimensions of {name!r}: {field.dims}", argument="variable")
    of_light = str(field.attrs.get("units", stated.radiance_unit or ""))
    for one in others:
        unit = str(one.attrs.get("units", of_light))
        if unit != of_light and not (radiance_factor(unit) and radiance_factor(unit) == radiance_factor(of_light)):
            message = f"{one.name!r} has the unit {unit!r}, and {name!r} has the unit {of_light!r}"
            advice = f"give Q and U in the unit of I, a share times I; or I alone: --variable {name} (variable=)"
            raise FieldError(message, advice, "variable_q")
    signs = stated.stokes_signs or (1, 1)
    q, u = (sign * radiances(one.transpose(*field.dims)) for sign, one in zip(signs, others, strict=True))
    if not np.all(np.isfinite([light, q, u])):
        advice = (
            f"interpolate I, Q and U to such a grid, or give I alone: --variable {name} (variable=), --isel stokes=0"
        )
        raise FieldError("a polarised field wants I, Q and U in every direction of a grid, without gaps", advice)
    if np.any(np.hypot(q, u) > np.abs(light) * (1.0 + _ROUNDED)):
        raise FieldError("the field has more polarised light than light", "give Q and U in the unit of I", "variable")

    def values_of(radiance: np.ndarray) -> np.ndarray:
        made = field.copy(data=radiance)
        made.attrs, made.encoding = {key: value for key, value in field.attrs.items() if key not in _GAPS}, {}
        read = read_radiance_field(replace(chosen, radiance=made), stated, **how).arguments
        return np.asarray(read["values"].reshape(len(read["values"]), -1))

    made = read_radiance_field(chosen, stated, **how)
    read = made.arguments
    values, shares = read["values"].reshape(len(read["values"]), -1), []
    for part in (q, u):
        above, below = values_of(2.0 * light + part), values_of(2.0 * light - part)
        total = above + below
        shares.append(np.divide(2.0 * (above - below), total, out=np.zeros_like(total), where=total > 0))
    both = np.stack(shares) * (values / np.maximum(np.hypot(*shares), 1.0))
    largest = np.max(np.hypot(q, u)[light > 0] / light[light > 0], initial=0.0)
    said = f"photons carry q and u of Q and U of the field, of a degree up to {largest:.2g}; V is not read"
    remarks = (*read["remarks"], said)
    arguments = {**read, "values": values, "values_q": both[0], "values_u": both[1], "remarks": remarks}
    return made._replace(arguments=arguments)


def _unstacked(chosen: Chosen, zenith: Axis, azimuth: Axis) -> Chosen:
    """The field with a dimension for each of the two angles; pairs that are absent are NaN."""
    attributes = {one.name: one.attributes for one in (zenith, azimuth)}

    def unstacked(field: Any) -> Any:
        made = field.set_index({zenith.dims[0]: list(attributes)}).unstack(zenith.dims[0])
        for name, attrs in attributes.items():
            made[name].attrs = attrs
        return made

    assert chosen.stokes is not None
    coords = {name: chosen.radiance.coords[name] for name in attributes}
    try:
        radiance = unstacked(chosen.radiance)
        q, u = (unstacked(one.assign_coords(coords)) for one in chosen.stokes)
    except Exception as error:  # whatever xarray says of directions that come twice, or of several dimensions
        raise FieldError("a polarised field wants each direction of a grid once, without gaps", str(error)) from error
    return replace(chosen, radiance=radiance, stokes=(q, u))
