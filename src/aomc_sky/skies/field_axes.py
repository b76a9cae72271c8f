"""Coordinates and values of a radiance field: in degrees and nm, azimuths from +x towards +y, gaps as NaN."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from aomc_sky.directions import EDGE_DEG, AzimuthConvention, at_quarter_deg, to_enu_azimuth_deg, within_sky_deg
from aomc_sky.errors import FieldError
from aomc_sky.formats.azimuth import OURS, SAY_AZIMUTH, convention_of, words_of
from aomc_sky.formats.quote import texts_of, with_texts
from aomc_sky.formats.radiance_unit import SAY_UNIT, radiance_factor
from aomc_sky.formats.radiance_words import (
    ANGLE_DEGREES,
    CF_CLOCKWISE,
    LEAST_NM,
    LENGTH_NM,
    MOST_NM,
    NAMES,
    SAY_ANGLE,
    SAY_LENGTH,
    SAY_SUN,
    TRUE_NORTH,
    Stated,
    instead,
    may_be_radians,
    plain_unit,
    quantity_of,
    say_coordinate,
)
from aomc_sky.formats.report import quoted

_MOST_AZIMUTH_DEG = 720.0
_DIGITS = 10  #: Digits of a degree; radians become the degrees that they were.
_DEFAULT_FILLS = {
    "i2": -32767, "u2": 65535, "i4": -2147483647, "u4": 4294967295, "i8": -9223372036854775806,
    "u8": 18446744073709551614, "f4": float(np.float32(9.969209968386869e36)), "f8": 9.969209968386869e36,
}  # fmt: skip
"""What the netCDF library has where nothing was written, by the kind of number."""
SAY_BOUNDS = "write bounds in the unit of the angles, each beside the next, or leave the attribute bounds out"

Questions = list[FieldError]
"""What a field leaves open, asked together."""


class Axis(NamedTuple):
    """One coordinate of a field."""

    role: str  #: "zenith", "elevation", "azimuth" or "wavelength"
    name: str
    dims: tuple[str, ...]
    values: np.ndarray  #: (n,), also of a coordinate with several dimensions
    attributes: dict[str, Any]
    bounds: np.ndarray | None  #: CF bounds (n, 2) of a coordinate with one dimension
    absent_bounds: str  #: Name of bounds that the coordinate has and the field has not, or an empty text

    @property
    def units(self) -> list[str]:
        """Units by its name and its attribute."""
        stated = (str(self.attributes.get(key) or "") for key in ("units", "unit"))
        return [text for text in (NAMES.get(self.name.lower(), ("", ""))[1], *stated) if text.strip()]

    def question(self, message: str, beside: Mapping[str, Any] | None = None) -> str:
        """A question, with what the coordinate and the file say in words."""
        return with_texts(message, [*texts_of(self.attributes), *texts_of(beside or {})])


def bounds_name(coordinate: Any) -> str:
    """Name of the CF bounds of a coordinate, or an empty text; xarray has it among attributes or the encoding."""
    return str({**getattr(coordinate, "encoding", {}), **coordinate.attrs}.get("bounds", ""))


def named_role(name: str) -> str:
    """What a coordinate is by its name, an empty text for other names."""
    return NAMES.get(name.lower(), ("",))[0]


def axis_of(field: Any, role: str, stated: Stated, bounds: Mapping[str, Any]) -> Axis | None:
    """The coordinate of a role: the one that is stated, or the only one of such a name; None without any."""
    given = {one: getattr(stated, one) for one in ((role, "elevation") if role == "zenith" else (role,))}
    own, name = next(((one, name) for one, name in given.items() if name is not None), (role, None))
    listed = ", ".join(repr(str(one)) for one in field.coords) or "none at all"
    if name is not None and name not in field.coords:
        raise FieldError(f"the field has no coordinate {name!r}; it has {listed}", argument=own)
    if name is None:
        # a single angle is not one of the sky: that of the sun, as a rule
        known = [str(one) for one, axis in field.coords.items() if axis.dims or role == "wavelength"]
        fitting = [one for one in known if named_role(one) in given]
        if len(fitting) > 1:
            shown = ", ".join(map(repr, fitting))
            message = f"the field has {len(fitting)} coordinates that may be its {role}: {shown}"
            raise FieldError(message, f"leave the others out of the file, or {say_coordinate(role)}", role)
        if not fitting and role == "zenith":
            single = [str(one) for one, axis in field.coords.items() if not axis.dims and named_role(str(one)) in given]
            free = [one for one in known if not named_role(one)]
            if single and not free:
                message = f"coordinate {single[0]!r} has no dimension"
                raise FieldError(message, f"give it one: field.expand_dims({single[0]!r})", role)
            advice = f"{say_coordinate('zenith', free)}, or elevation=NAME, or give it the name zenith"
            raise FieldError(f"the field has no coordinate zenith among {listed}", advice, role)
        if not fitting:
            return None
        name = fitting[0]
        own = named_role(name)
    coordinate = field.coords[name]
    if {"scale_factor", "add_offset"} & set(coordinate.attrs):
        message = f"coordinate {name!r} is packed (scale_factor, add_offset)"
        raise FieldError(message, "open it with mask_and_scale=True", role)
    try:
        values = np.asarray(coordinate.values, dtype=np.float64)
    except (TypeError, ValueError):
        raise FieldError(f"coordinate {name!r} holds no numbers", argument=role) from None
    if values.ndim > 1 and role == "wavelength":
        raise FieldError(f"coordinate {name!r} has {values.ndim} dimensions; a wavelength has one", argument=role)
    edges, absent = bounds.get(bounds_name(coordinate)), ""
    if values.ndim > 1:
        edges = None  # of corners, which are no patches
    elif edges is None:
        absent = bounds_name(coordinate)
    else:
        edges = np.asarray(edges, dtype=np.float64)
        if edges.shape != (*values.shape, 2) or not np.all(np.isfinite(edges)):
            message = f"the bounds of coordinate {name!r} have the shape {edges.shape}, or are not finite"
            raise FieldError(message, f"write two finite bounds for each of {values.size} angles", "table")
    return Axis(own, name, tuple(map(str, coordinate.dims)), values.ravel(), dict(coordinate.attrs), edges, absent)


def _scale(
    axis: Axis, given: str | None, units: Mapping[str, float], argument: str, advice: str, questions: Questions
) -> float:
    """One unit of a coordinate by the caller, its name and its attribute, which must not differ; 1 after a question."""
    said = [given] if given is not None else axis.units
    unknown = [text for text in said if plain_unit(text) not in units]
    scales = {units[plain_unit(text)] for text in said if text not in unknown}
    if len(scales) == 1 and not unknown:
        return scales.pop()
    message = f"coordinate {axis.name!r} does not say in which unit it is"
    if unknown:
        message = f"coordinate {axis.name!r} has the unit {unknown[0]!r}, which is none that is read"
    elif said:
        message = f"coordinate {axis.name!r} has the units {' and '.join(said)} by its name and its attributes"
    if "1" in unknown and axis.role != "wavelength":
        advice = f"of cosines write zenith angles, arccos(mu); else {advice}"
    questions.append(FieldError(axis.question(message), f"{advice}, or set its attribute units", argument))
    return 1.0


def angle_scale(axis: Axis, stated: Stated, questions: Questions) -> float:
    """One unit of an angle. [deg]"""
    scale = _scale(axis, stated.angle_unit, ANGLE_DEGREES, "angle_unit", SAY_ANGLE, questions)
    is_stated = stated.angle_unit is None and axis.units != []
    if scale == 1.0 and is_stated and may_be_radians(axis.values, is_azimuth=axis.role == "azimuth"):
        message = f"coordinate {axis.name!r} has values up to {np.nanmax(axis.values):g} degrees; are they radians?"
        questions.append(FieldError(message, f"{SAY_ANGLE}, or correct its attribute units", "angle_unit"))
    return scale


def _in_degrees(axis: Axis, values: np.ndarray, scale: float) -> np.ndarray:
    if not np.any(np.isfinite(axis.values)):
        raise FieldError(f"coordinate {axis.name!r} has no finite value", argument="table")
    return values if scale == 1.0 else np.round(values * scale, _DIGITS)


def zenith_deg(axis: Axis, values: np.ndarray, scale: float) -> np.ndarray:
    """Zenith angles from values, or bounds, of a coordinate of zenith angles or elevations. [deg]"""
    angle = _in_degrees(axis, values, scale)
    return within_sky_deg(np.round(90.0 - angle if axis.role == "elevation" else angle, _DIGITS))


class Azimuths(NamedTuple):
    """Azimuths of a field."""

    enu_deg: np.ndarray  #: From +x towards +y. [deg, 0 to 360)
    bounds_deg: np.ndarray | None  #: Edges (n, 2) around them, rising. [deg]
    in_field: np.ndarray  #: As the field has them, in its unit.


def azimuths(
    axis: Axis, scale: float, convention: AzimuthConvention, sun_azimuth_deg: float | None, remarks: list[str]
) -> Azimuths:
    """The azimuths of a coordinate."""
    if convention.is_from_sun and sun_azimuth_deg is None:
        raise FieldError(f"azimuth {axis.name!r} counts from the sun, but nothing says where it is", SAY_SUN, "azimuth")
    if convention.is_from_sun:
        remarks.append(f"azimuth {axis.name!r} counts {words_of(convention)}; the sun is at {sun_azimuth_deg:g}")
    angle = at_quarter_deg(_in_degrees(axis, axis.values, scale))
    if np.any(np.abs(angle) > _MOST_AZIMUTH_DEG):
        message = f"azimuth {axis.name!r} goes to {np.nanmax(np.abs(angle)):g} degrees; are its units radians?"
        raise FieldError(message, f"{SAY_ANGLE}, or correct its attribute units; NaN is a gap", "angle_unit")
    turned = to_enu_azimuth_deg(angle, convention, sun_azimuth_deg)
    edges = None
    if axis.bounds is not None:
        pairs = np.sort(at_quarter_deg(_in_degrees(axis, axis.bounds, scale)), axis=1)
        beside = pairs - angle[:, None]
        is_apart = (beside[:, 0] > 0) | (beside[:, 1] < 0)  # 352.5 and 7.5 around 0
        beside[is_apart] = (beside[is_apart] + 180.0) % 360.0 - 180.0
        beside.sort(axis=1)
        if np.any((beside[:, 0] > EDGE_DEG) | (beside[:, 1] < -EDGE_DEG)):
            raise FieldError(f"the bounds of coordinate {axis.name!r} are not around it", SAY_BOUNDS, "azimuth")
        edges = turned[:, None] + np.sort(convention.value[1] * beside, axis=1)
    return Azimuths(turned, edges, axis.values)


def azimuth_convention(
    axis: Axis, stated: Stated, field: Any, of_file: Mapping[str, Any], questions: Questions
) -> AzimuthConvention:
    """What the caller states, or else the coordinate, or else field and file."""
    if stated.convention is not None:
        return stated.convention
    attributes = axis.attributes
    places = (attributes,) if attributes.get("azimuth_convention") else (field.attrs, of_file)
    texts = dict.fromkeys(str(one["azimuth_convention"]) for one in places if one.get("azimuth_convention"))
    found: dict[str, AzimuthConvention] = {}
    for text in texts:
        known = AzimuthConvention.ENU_FROM_EAST if text == OURS else convention_of(text)
        if known is None:
            message = f"azimuth {axis.name!r}: {quoted(text)} is no convention of azimuths that is read"
            questions.append(FieldError(message, SAY_AZIMUTH, "azimuth_convention"))
            return AzimuthConvention.ENU_FROM_EAST
        found[f"azimuth_convention {text!r}"] = known
    north = AzimuthConvention.NORTH_CLOCKWISE
    if plain_unit(str(attributes.get("units", ""))) in TRUE_NORTH:
        found[f"units {attributes['units']!r}"] = north
    if attributes.get("standard_name") in CF_CLOCKWISE:
        found[f"standard_name {attributes['standard_name']!r}"] = north
    if str(attributes.get("long_name", "")) == f"azimuth of the sky element; {OURS}":
        found["the text of this package's files"] = AzimuthConvention.ENU_FROM_EAST
    if len(set(found.values())) > 1:
        message = f"azimuth {axis.name!r}: {' and '.join(found)} differ"
        questions.append(FieldError(message, SAY_AZIMUTH, "azimuth_convention"))
    elif not found:
        message = axis.question(
            f"nothing says from where azimuth {axis.name!r} counts and which way", {**of_file, **field.attrs}
        )
        advice = f"{SAY_AZIMUTH}; in the file its attribute azimuth_convention says it"
        questions.append(FieldError(message, advice, "azimuth_convention"))
    return next(iter(found.values()), AzimuthConvention.ENU_FROM_EAST)


def wavelengths_nm(axis: Axis, stated: Stated, questions: Questions) -> np.ndarray:
    """Wavelengths of a coordinate. [nm]"""
    n_before = len(questions)
    scale = _scale(axis, stated.wavelength_unit, LENGTH_NM, "wavelength_unit", SAY_LENGTH, questions)
    values = np.asarray(axis.values * scale)
    if not np.all(np.isfinite(values)):
        raise FieldError(f"coordinate {axis.name!r} has values that are not finite", argument="wavelength")
    least, most = np.nanmin(values), np.nanmax(values)
    if len(questions) == n_before and not (least >= LEAST_NM and most <= MOST_NM):
        shown = f"{least:g}" if least == most else f"{least:g} to {most:g}"
        message = f"coordinate {axis.name!r} has wavelengths of {shown} nm; {LEAST_NM:g} to {MOST_NM:g} are read"
        questions.append(FieldError(message, f"{SAY_LENGTH}, or correct its attribute units", "wavelength_unit"))
    return values


class Statements(NamedTuple):
    """What a field and its caller state."""

    zenith: Axis
    azimuth: Axis | None
    wavelength: Axis | None
    zenith_scale: float  #: One unit of the angle [deg]
    azimuth_scale: float
    convention: AzimuthConvention | None  #: None without azimuths
    wavelength_nm: np.ndarray
    radiance_unit: float | None  #: In W m-2 nm-1 sr-1, 0 for relative light, None where nothing says it
    remarks: tuple[str, ...]  #: Words of the caller that come before others of the file

    @property
    def axes(self) -> tuple[Axis, ...]:
        """The coordinates that the field has."""
        return tuple(one for one in (self.zenith, self.azimuth, self.wavelength) if one is not None)


def _ask_of_azimuths(
    zenith: Axis, wavelength: Axis | None, along: Mapping[str, tuple[str, ...]], questions: Questions
) -> None:
    """Ask for the azimuths of scattered directions, if other numbers lie along them; `along` are those of the file."""
    taken = (zenith.name, *(() if wavelength is None else (wavelength.name,)), *zenith.dims)
    beside = [name for name, dims in along.items() if {*dims} and {*dims} <= {*zenith.dims} and name not in taken]
    steps = np.diff(zenith.values)
    is_scattered = zenith.name not in zenith.dims or not (np.all(steps > 0) or np.all(steps < 0))
    if is_scattered and beside:
        there = ", ".join(map(repr, beside))
        message = f"the field has {there} beside the zenith angles {zenith.name!r}, and no coordinate azimuth"
        options = " or ".join(f"--coordinate azimuth={name}" for name in beside)
        questions.append(FieldError(message, f"write {options} (azimuth=), with --azimuth-convention", "azimuth"))


def statements(
    field: Any,
    bounds: Mapping[str, Any],
    of_file: Mapping[str, Any],
    along: Mapping[str, tuple[str, ...]],
    stated: Stated,
) -> Statements:
    """What is stated of a field; FieldError with all questions that are left open.

    `along` has the dimensions of all other variables of numbers.
    """
    questions: Questions = []
    axes: list[Axis | None] = []
    unclear: list[str] = []
    for role in ("zenith", "azimuth", "wavelength"):
        try:
            axes.append(axis_of(field, role, stated, bounds))
        except FieldError as error:
            axes.append(None)
            unclear.append(role)
            questions.append(error)
    zenith, azimuth, wavelength = axes
    unit = _radiance_unit(field, stated.radiance_unit, questions)
    scales = [1.0 if axis is None else angle_scale(axis, stated, questions) for axis in (zenith, azimuth)]
    beside = {**of_file, **field.attrs}
    convention = None if azimuth is None else azimuth_convention(azimuth, stated, field, of_file, questions)
    nm = np.array([550.0]) if wavelength is None else wavelengths_nm(wavelength, stated, questions)
    _ask_of_dimensions(field, [axis for axis in axes if axis is not None], questions)
    if zenith is not None and azimuth is None and "azimuth" not in unclear:
        _ask_of_azimuths(zenith, wavelength, along, questions)
    for axis, role, name in ((azimuth, "azimuth", "azimuth_convention"), (wavelength, "wavelength", "wavelength_unit")):
        if axis is None and role not in unclear and getattr(stated, name) is not None:
            message = f"{name} is given, and the field has no coordinate {role}"
            questions.append(FieldError(message, f"leave it out, or {say_coordinate(role)}", name))
    if zenith is None or questions:
        first = questions[0].problems[0]
        raise FieldError(first.message, first.advice, first.field, questions[1:])
    pairs: list[tuple[str, object, list[str]]] = [
        ("angle_unit", stated.angle_unit, axis.units) for axis in (zenith, azimuth) if axis is not None
    ]
    pairs += [("wavelength_unit", stated.wavelength_unit, [] if wavelength is None else wavelength.units)]
    pairs += [
        ("radiance_unit", stated.radiance_unit, [str(field.attrs[key]) for key in ("units",) if key in field.attrs])
    ]
    if azimuth is not None:
        said = azimuth.attributes.get("azimuth_convention", beside.get("azimuth_convention"))
        pairs += [("azimuth", stated.convention, [] if said is None else [str(said)])]
    remarks = dict.fromkeys(
        one for what, given, said in pairs if given for text in said for one in instead(what, given, text)
    )
    return Statements(zenith, azimuth, wavelength, scales[0], scales[1], convention, nm, unit, tuple(remarks))


def _radiance_unit(field: Any, given: str | None, questions: Questions) -> float | None:
    """One unit of the values in W m-2 nm-1 sr-1, None where nothing says it."""
    said = {name: str(text).strip() for name, text in field.attrs.items() if name in ("units", "unit")}
    unit = given if given is not None else next(iter(said.values()), "")
    if not unit:
        return None
    factor = radiance_factor(unit)
    if factor is None:
        message = f"the unit {unit!r} of the field is none of spectral radiance that is read"
        questions.append(FieldError(message, SAY_UNIT, "radiance_unit"))
    elif given is None and len({radiance_factor(text) for text in said.values()}) > 1:
        message = f"the field has units {said['units']!r} and unit {said['unit']!r}"
        questions.append(FieldError(message, SAY_UNIT, "radiance_unit"))
    return factor


def _ask_of_dimensions(field: Any, axes: Sequence[Axis], questions: Questions) -> None:
    """Ask for dimensions of which nothing says what they are."""
    known = {dim for axis in axes for dim in axis.dims}
    found = {quantity_of(axis.role) for axis in axes}
    roles = [role for role in ("zenith", "azimuth", "wavelength") if role not in found]
    for dim, size in zip(map(str, field.dims), field.shape, strict=True):
        if dim in known or size == 1:
            continue
        ways = [f"--coordinate {role}={dim} ({role}={dim!r})" for role in roles if dim in field.coords]
        ways += [] if dim in field.coords else [f"coordinates of it, field.assign_coords({dim}=...)"]
        ways.append(f"--isel {dim}=0, or field.isel({dim}=0), for one of it")
        message = f"the field has a dimension {dim!r} of {size} besides angles and wavelength"
        more = "; azimuths need --azimuth-convention, too" if "azimuth" in roles and dim in field.coords else ""
        questions.append(FieldError(message, f"write {', or '.join(ways)}{more}", "isel"))


def radiances(field: Any) -> np.ndarray:
    """The values of a field in its own shape, NaN where they are missing: fill values, and beyond the valid range."""
    values = np.asarray(field.values)
    if values.dtype.kind not in "iuf":
        raise FieldError(f"the field holds {values.dtype} instead of real numbers", argument="variable")
    attributes = {**getattr(field, "encoding", {}), **field.attrs}
    if {"scale_factor", "add_offset"} & set(field.attrs):
        raise FieldError("the field is packed (scale_factor, add_offset)", "open it with mask_and_scale=True")
    stored = np.dtype(attributes.get("dtype", values.dtype))
    scale, offset = attributes.get("scale_factor", 1.0), attributes.get("add_offset", 0.0)

    def limits(name: str, count: int) -> np.ndarray:
        """Numbers of an attribute, unpacked where they are as the file stores them; none where it is absent."""
        found = np.atleast_1d(attributes.get(name, []))
        if found.dtype.kind not in "iuf" or (found.size and count not in (0, found.size)):
            raise FieldError(f"the attribute {name} of the field is {attributes[name]!r}, and no numbers of a range")
        if found.dtype.kind in "iu" and stored.kind in "iu":
            return found * scale + offset
        with np.errstate(over="ignore"):
            return found.astype(values.dtype if values.dtype.kind == "f" else np.float64).astype(np.float64)

    radiance: np.ndarray = values.astype(np.float64)
    pair = limits("valid_range", 2)
    low = np.max([*pair[:1], *limits("valid_min", 1)], initial=-np.inf)
    high = np.min([*pair[1:], *limits("valid_max", 1)], initial=np.inf)
    fills = [*limits("_FillValue", 0), *limits("missing_value", 0)]
    if stored.str[1:] in _DEFAULT_FILLS:
        fills.append(_DEFAULT_FILLS[stored.str[1:]] * scale + offset)
    return np.where((radiance < low) | (radiance > high) | np.isin(radiance, fills), np.nan, radiance)
