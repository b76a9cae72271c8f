"""Coordinates and values of a radiance field: in degrees and nm, azimuths from +x towards +y, gaps as NaN."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from aomc_sky.directions import EDGE_DEG, AzimuthConvention, at_quarter_deg, to_enu_azimuth_deg, within_sky_deg
from aomc_sky.errors import FieldError
from aomc_sky.formats.azimuth_words import (
    ASSUMED_AZIMUTH,
    SAY_AZIMUTH,
    UnclearError,
    convention_of,
    given_convention,
    is_on_azimuths,
    speaks_of_azimuths,
)
from aomc_sky.formats.netcdf import bounds_name, chosen_field
from aomc_sky.formats.radiance_words import (
    ANGLE_DEGREES,
    COSINES,
    FROM_HORIZON,
    GAP_NUMBERS,
    LEAST_NM,
    LENGTH_NM,
    MAX_RADIANCE,
    MOST_NM,
    MOST_SAID,
    ON_ZENITHS,
    SAY_ANGLE,
    SAY_COMES_FROM,
    SAY_SUN,
    TRUE_NORTH,
    have_look_of_degrees,
    may_be_radians,
    name_of_column,
    names_fill,
    plain_unit,
    travel_of,
    unit_and_counts,
)
from aomc_sky.inputs import SURE_NM

_COSINES = ("mu", "umu")  #: The last one as DISORT has it: negative where light comes from the sky.
_FROM_ZENITH = re.compile(r"\bzenith angle|\bfrom (?:the )?zenith", re.I)
_ROUNDED = 1e-6  #: By so much a cosine of rounded numbers may be beyond 1.
_ENDS = {
    "zenith": ("zenith_angle", "elevation_angle", "altitude_angle"),
    "azimuth": ("azimuth_angle",),
    "wavelength": ("wavelength",),
}
"""Ends of names and standard names of coordinates."""
_MOST_AZIMUTH_DEG = 720.0
_HEIGHTS = ("km", "hpa", "pa", "mbar", "feet", "ft")
_NO_TEXTS = ("history", "source", "conventions", "institution", "azimuth_convention", "units", "unit", "coordinates")
"""Attributes of a file or a field, in small letters, that are no sentences on its directions."""
_OF_FILE = "texts of the file"  #: Attribute of a field with the texts of its dataset.
_OTHERS = "other texts"  #: Attribute of an axis with what the coordinate says under names of its own.
_ON_AXIS = (
    "standard_name", "long_name", "convention", "direction", "origin", "positive", "reference", "comment",
    "description", "azimuth_convention", "units", "unit", "bounds", "axis",
)  # fmt: skip
_UNITS = ("", *ANGLE_DEGREES, *LENGTH_NM)  #: What a name may add: zenith_deg.
_CF_AZIMUTHS = ("sensor_azimuth_angle", "platform_azimuth_angle")  #: Clockwise, by the CF conventions.
_DIGITS = 10  #: Digits of a degree; radians become the degrees that they were.
_DEFAULT_FILLS = {
    "i2": -32767, "u2": 65535, "i4": -2147483647, "u4": 4294967295, "i8": -9223372036854775806,
    "u8": 18446744073709551614,
}  # fmt: skip
"""What the netCDF library has where nothing was written, by the kind of number; of floats above `MAX_RADIANCE`."""


def stated_unit(attributes: Mapping[str, Any]) -> str:
    """The attribute units, or unit, in any letters; an empty text where there is none."""
    texts = {str(name).lower(): str(value).strip() for name, value in attributes.items()}
    return texts.get("units", texts.get("unit", ""))


SAY_BOUNDS = "write bounds in the unit of the angles, each beside the next, or leave the attribute bounds out"


class Axis(NamedTuple):
    """One coordinate of a field."""

    name: str
    dims: tuple[str, ...]
    values: np.ndarray  #: (n,), also of a coordinate with several dimensions
    attributes: dict[str, Any]
    bounds: np.ndarray | None  #: CF bounds (n, 2) of a coordinate with one dimension
    absent_bounds: str  #: Name of bounds that the coordinate has and the field has not, or an empty text

    @property
    def unit(self) -> str:
        """The unit that its attributes state, or its name: zenith_rad."""
        named = name_of_column(self.name)
        stated = stated_unit(self.attributes)
        return stated or (unit_and_counts(named.unit)[0] if named is not None else "")

    def texts(self, *names: str) -> list[str]:
        """What attributes say in words."""
        return [str(self.attributes[name]) for name in names if name in self.attributes]


def field_and_bounds(field: Any, variable: str | None) -> tuple[Any, dict[str, Any]]:
    """The radiance of an xarray.Dataset with the bounds of its coordinates, or a DataArray, which can have none."""
    if hasattr(field, "data_vars"):
        whole = {name: field.attrs[name] for name in ("azimuth_convention",) if name in field.attrs}
        texts = sentences(field.attrs)
        field, bounds = chosen_field(field, variable)
        field = field.assign_attrs({**whole, **field.attrs, _OF_FILE: ". ".join(texts)})
    else:
        bounds = {}
    if not all(hasattr(field, name) for name in ("coords", "dims", "shape", "values")):
        raise FieldError(
            f"a radiance field is an xarray.DataArray or Dataset with coordinates, got {type(field).__name__}",
            "give values without coordinates to sky.TabulatedSky(grid=, wavelength_nm=, values=)",
        )
    empty = [str(dim) for dim, size in zip(field.dims, field.shape, strict=True) if size == 0]
    if empty:
        raise FieldError(f"the field has no values: its dimension {empty[0]!r} has length 0")
    return field, bounds


def axis_of(field: Any, role: str, given: str | None, bounds: Mapping[str, Any]) -> Axis | None:
    """The coordinate of a role: the one that is named, or the only one whose name or standard name says it."""
    name = _name_of(field, role, given)
    if name is None:
        return None
    coordinate = field.coords[name]
    try:
        values = np.asarray(coordinate.values, dtype=np.float64)
        values = np.where(np.isin(values, GAP_NUMBERS), np.nan, values)
    except (TypeError, ValueError):
        raise FieldError(f"coordinate {name!r} holds no numbers", argument=role) from None
    if values.ndim > 1 and role == "wavelength":
        raise FieldError(f"coordinate {name!r} has {values.ndim} dimensions; a wavelength has one", argument=role)
    attributes = {**getattr(coordinate, "encoding", {}), **coordinate.attrs}
    if "azimuth_convention" in field.attrs and role == "azimuth":
        attributes.setdefault("azimuth_convention", field.attrs["azimuth_convention"])
    attributes[_OF_FILE] = ". ".join(sentences(field.attrs))
    if role == "azimuth":
        own = [text for word, text in coordinate.attrs.items() if word not in _ON_AXIS and isinstance(text, str)]
        attributes[_OTHERS] = [text for text in own if speaks_of_azimuths(text, is_comment=True)]
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
    return Axis(name, tuple(map(str, coordinate.dims)), values.ravel(), attributes, edges, absent)


def _name_of(field: Any, role: str, given: str | None) -> str | None:
    """The name of the coordinate of a role; None where the field has none and needs none."""
    if given is not None:
        if given not in field.coords:
            raise FieldError(f"the field has no coordinate {given!r}; it has {_listed(field)}", argument=role)
        return given
    candidates = [str(name) for name in field.coords if _has_role(str(name), field.coords[name], role)]
    if role == "wavelength" and role in candidates:
        return role
    if len(candidates) > 1:  # altitude without a unit beside zenith angles is a height
        candidates = [one for one in candidates if one != "altitude" or stated_unit(field.coords[one].attrs)]
    if len(candidates) > 1:
        shown = ", ".join(map(repr, candidates))
        message = f"the field has {len(candidates)} coordinates that may be its {role}: {shown}"
        advice = f"leave the others out of the file, or say which one: {role}='NAME' (Python, or [sky] of sky.toml)"
        raise FieldError(message, advice, role)
    if not candidates and role == "wavelength" and any("wavenumber" in str(name).lower() for name in field.coords):
        raise FieldError("the field has wavenumbers", "give wavelengths, and radiances per nm", role)
    if not candidates and role == "zenith":
        raise _without_zenith(field)
    return candidates[0] if candidates else None


def _without_zenith(field: Any) -> FieldError:
    """What to do about a field without a coordinate of zenith angles."""
    message = f"the field has no coordinate of zenith angles among {_listed(field)}"
    advice = "give it the name zenith, or say which one it is: zenith='NAME' (Python, or [sky] of sky.toml)"
    single = {str(name): one.expand_dims("one") for name, one in field.coords.items() if not one.dims}
    if alone := next((name for name, one in single.items() if _has_role(name, one, "zenith")), None):
        message = f"the field has one zenith angle, and its coordinate {alone!r} has no dimension"
        advice = f"give it one: field.expand_dims({alone!r})"
    if any("nadir" in str(name).lower() for name in field.coords):
        advice = "write zenith angles, 0 overhead: 180 degrees minus the angles from the nadir"
    return FieldError(message, advice)


def sentences(attributes: Mapping[str, Any]) -> list[str]:
    """Attributes that may be sentences; one whose name is of azimuths is on them."""
    texts = [(str(name).lower(), text) for name, text in attributes.items() if isinstance(text, str)]
    return [
        f"azimuth {text[:MOST_SAID]}" if "azimuth" in name and not re.search("sun|solar", name) else text[:MOST_SAID]
        for name, text in texts
        if name not in _NO_TEXTS
    ]


def sentences_of_file(attributes: Mapping[str, Any]) -> list[str]:
    """The sentences of a dataset, one by one."""
    return re.split(r"[.;\n](?:\s|\Z)", str(attributes.get(_OF_FILE, "")))


def _listed(field: Any) -> str:
    return ", ".join(repr(str(name)) for name in field.coords) or "none at all"


def _has_role(name: str, coordinate: Any, role: str) -> bool:
    if role != "wavelength" and not coordinate.dims:
        return False  # a single angle is not one of the sky: that of the sun, as a rule
    if role != "wavelength" and plain_unit(stated_unit(coordinate.attrs)) in (*LENGTH_NM, *_HEIGHTS):
        return False  # a height: altitude in m
    standard = str(coordinate.attrs.get("standard_name", ""))
    text = name.lower()
    is_of_sun = any(word in f"{text} {standard}" for word in ("sun", "solar", "sza", "saa"))
    if is_of_sun and not re.search("rel|from_|to_", text):
        return False
    known = name_of_column(text)
    unit, counts = ("", "") if known is None else unit_and_counts(known.unit)
    is_named = known is not None and known.slot == role and (plain_unit(unit) in _UNITS or bool(counts))
    is_named |= _is_cosine(text) if role == "zenith" else role == "wavelength" and text == "w"
    return is_named or text.endswith(_ENDS[role]) or standard.endswith(_ENDS[role])


def _is_cosine(name: str) -> bool:
    """Whether a name in small letters is one of cosines of zenith angles: mu, cos_theta, cosine_of_zenith_angle."""
    of_angle = re.match(r"(?:cosine|cos)_?(?:of_)?(?:the_)?(\w+)", name)
    angle = name_of_column(of_angle[1]) if of_angle else None
    return name in _COSINES or (angle is not None and angle.role == "zenith" and not angle.unit)


def _in_degrees(axis: Axis, values: np.ndarray, given: str | None, *, is_azimuth: bool = False) -> np.ndarray:
    """Angles by the argument, the attribute, or values that no radian has. [deg]"""
    if not np.any(np.isfinite(axis.values)):
        raise FieldError(f"coordinate {axis.name!r} has no finite value")
    stated = axis.unit if given is None else given
    scale = ANGLE_DEGREES.get(plain_unit(stated))
    if scale is None and given is None and not stated and have_look_of_degrees(axis.values):
        scale = 1.0
    if given is None and scale == 1.0 and may_be_radians(axis.values, is_azimuth=is_azimuth):
        message = f"coordinate {axis.name!r} has values up to {np.nanmax(axis.values):g} degrees; are they radians?"
        raise FieldError(message, f"{SAY_ANGLE}, or correct its attribute units", "angle_unit")
    if scale is None:
        message = f"coordinate {axis.name!r} does not say whether it is in degrees or radians"
        shown = f" (units = {stated!r})" if stated else ""
        advice = f"{SAY_ANGLE}, or set its attribute units"
        if stated not in ("", "1"):
            advice = f"if it is in one of them, {advice}"
        raise FieldError(f"{message}{shown}", advice, "angle_unit")
    return values if scale == 1.0 else np.round(values * scale, _DIGITS)


def zenith_deg(axis: Axis, values: np.ndarray, angle_unit: str | None) -> np.ndarray:
    """Zenith angles from values, or bounds, of a coordinate of zenith angles, elevations or cosines. [deg]"""
    name = axis.name.lower()
    if _is_cosine(name):
        if np.nanmax(np.abs(values)) > 1 + _ROUNDED:
            raise FieldError(f"coordinate {axis.name!r} is a cosine, and has values beyond -1 to 1", argument="zenith")
        if name != "umu" and np.nanmin(values) < 0 < np.nanmax(values):
            message = f"coordinate {axis.name!r} has cosines of both signs; which of them are of the sky?"
            raise FieldError(message, "keep those of the sky, above 0; 'umu' is read as DISORT has it", "zenith")
        cosine = (-values if name == "umu" else values).clip(-1.0, 1.0)
        return within_sky_deg(np.rad2deg(np.arccos(cosine)))
    texts = axis.texts("long_name", "comment", "description")
    if any(map(COSINES.search, texts)) and not np.any(np.abs(axis.values) > 1 + _ROUNDED):
        message = f"coordinate {axis.name!r} is a zenith angle by its name, but its text speaks of a cosine"
        raise FieldError(message, "give cosines of zenith angles the name mu", "zenith")
    angle = _in_degrees(axis, values, angle_unit)
    named, standard = name_of_column(name), str(axis.attributes.get("standard_name", ""))
    is_elevation = (named is not None and named.role == "elevation") or any(
        word in f"{name} {standard}" for word in ("elevation", "altitude")
    )
    texts += [one for one in sentences_of_file(axis.attributes) if ON_ZENITHS.search(one) and not is_elevation]
    for text in texts:
        if is_elevation and _FROM_ZENITH.search(text):
            message = f"coordinate {axis.name!r} is an elevation by its name, but its text says {text!r}"
            raise FieldError(message, "give zenith angles the name zenith", "zenith")
        if word := travel_of(f"zenith: {text}"):
            message = f"coordinate {axis.name!r} speaks of {word!r}: are its directions those that light goes to?"
            raise FieldError(message, SAY_COMES_FROM, "zenith")
        if not is_elevation and (found := FROM_HORIZON.search(text)):
            message = f"coordinate {axis.name!r} is a zenith angle by its name, but its text speaks of {found[0]!r}"
            raise FieldError(message, "name elevations 'elevation', and clear the text of zenith angles", "zenith")
    return within_sky_deg(np.round(90.0 - angle if is_elevation else angle, _DIGITS))


class Azimuths(NamedTuple):
    """Azimuths of a field."""

    enu_deg: np.ndarray  #: From +x towards +y. [deg, 0 to 360)
    bounds_deg: np.ndarray | None  #: Edges (n, 2) around them, rising. [deg]
    in_field: np.ndarray  #: As the field has them, in its unit.


def azimuths(
    axis: Axis,
    angle_unit: str | None,
    given: AzimuthConvention | str | None,
    sun_azimuth_deg: float | None,
    remarks: list[str],
) -> tuple[Azimuths, AzimuthConvention]:
    """The azimuths of a coordinate, and their convention in the field."""
    convention = _convention(axis, remarks) if given is None else given_convention(given)
    if convention.is_from_sun and sun_azimuth_deg is None:
        raise FieldError(f"azimuth {axis.name!r} counts from the sun, but nothing says where it is", SAY_SUN, "azimuth")
    if convention.is_from_sun:
        point, sense = "antisun" if convention.value[0] else "sun", "counter" * (convention.value[1] > 0)
        remarks.append(
            f"azimuth {axis.name!r} counts {sense}clockwise from the {point}; the sun is at {sun_azimuth_deg:g}"
        )
    angle = at_quarter_deg(_in_degrees(axis, axis.values, angle_unit, is_azimuth=True))
    if np.any(np.abs(angle) > _MOST_AZIMUTH_DEG):
        message = f"azimuth {axis.name!r} goes to {np.nanmax(np.abs(angle)):g} degrees; are its units radians?"
        raise FieldError(message, f"{SAY_ANGLE}, or correct its attribute units", "angle_unit")
    turned = to_enu_azimuth_deg(angle, convention, sun_azimuth_deg)
    edges = None
    if axis.bounds is not None:
        pairs = np.sort(at_quarter_deg(_in_degrees(axis, axis.bounds, angle_unit, is_azimuth=True)), axis=1)
        beside = pairs - angle[:, None]
        is_apart = (beside[:, 0] > 0) | (beside[:, 1] < 0)  # 352.5 and 7.5 around 0
        beside[is_apart] = (beside[is_apart] + 180.0) % 360.0 - 180.0
        beside.sort(axis=1)
        if np.any((beside[:, 0] > EDGE_DEG) | (beside[:, 1] < -EDGE_DEG)):
            raise FieldError(f"the bounds of coordinate {axis.name!r} are not around it", SAY_BOUNDS, "azimuth")
        edges = turned[:, None] + np.sort(convention.value[1] * beside, axis=1)
    return Azimuths(turned, edges, axis.values), convention


def _convention(axis: Axis, remarks: list[str]) -> AzimuthConvention:
    """What name and attributes of a coordinate say; else from +x towards +y, with a remark."""
    named = name_of_column(axis.name)
    said = ["relative"] if named is not None and named.role == "relative azimuth" else []
    texts = [axis.name, *axis.texts("standard_name", "long_name", "convention", "direction", "origin", "positive")]
    texts += [f"from {text}" for text in axis.texts("reference")]
    said += [text for text in texts if speaks_of_azimuths(text)]
    said += [text for text in axis.texts("comment", "description") if speaks_of_azimuths(text, is_comment=True)]
    said += [*axis.attributes.get(_OTHERS, ()), *axis.texts("azimuth_convention")]
    said += ["clockwise from north"] if plain_unit(axis.unit) in TRUE_NORTH else []
    said = said or [one for one in sentences_of_file(axis.attributes) if is_on_azimuths(one, is_comment=True)]
    is_clockwise = axis.attributes.get("standard_name", axis.name) in _CF_AZIMUTHS
    if not said and not is_clockwise:
        remarks.append(f"azimuth {axis.name!r} {ASSUMED_AZIMUTH}")
        return AzimuthConvention.ENU_FROM_EAST
    try:
        return convention_of(*dict.fromkeys(said), is_clockwise=is_clockwise)
    except UnclearError as error:
        raise FieldError(f"azimuth {axis.name!r}: {error}", SAY_AZIMUTH, "azimuth_convention") from None


def wavelengths_nm(axis: Axis) -> np.ndarray:
    """Wavelengths of a coordinate. [nm]"""
    scale = LENGTH_NM.get(plain_unit(axis.unit or "nm"))
    advice = "set its attribute units to nm, um, m or angstrom"
    if scale is None or any("wavenumber" in text.lower() for text in axis.texts("standard_name", "long_name")):
        shown = axis.unit or "wavenumbers"
        message = f"coordinate {axis.name!r} has the unit {shown!r}; a wavelength is in nm, um, m or angstrom"
        raise FieldError(message, "give wavelengths, and radiances per nm")
    values = np.asarray(axis.values * scale)
    if not np.all(np.isfinite(values)):
        raise FieldError(f"coordinate {axis.name!r} has values that are not finite", argument="wavelength")
    least, most = np.nanmin(values), np.nanmax(values)
    question = "micrometres" if 0.1 <= least < LEAST_NM else "angstroms" if least > SURE_NM and not axis.unit else ""
    if question or not np.all((values >= LEAST_NM) & (values <= MOST_NM)):
        shown = f"{least:g}" if least == most else f"{least:g} to {most:g}"
        shown += f" nm; are they {question}?" if question else f" nm; {LEAST_NM:g} to {MOST_NM:g} are read"
        raise FieldError(f"coordinate {axis.name!r} has wavelengths of {shown}", advice, "wavelength")
    return values


def _numbers_of(text: str) -> Any:
    """The numbers of a text such as '-99.0', or the text."""
    try:
        return np.array([float(word) for word in re.split(r"[\s,;]+", text) if word])
    except ValueError:
        return text


def radiances(field: Any) -> np.ndarray:
    """The values of a field in its own shape, NaN where they are missing: fill values, and beyond the valid range."""
    values = np.asarray(field.values)
    if values.dtype.kind not in "iuf":
        raise FieldError(f"the field holds {values.dtype} instead of real numbers", argument="variable")
    attributes, encoding = dict(field.attrs), dict(getattr(field, "encoding", {}))
    if {"scale_factor", "add_offset"} & set(attributes):
        raise FieldError("the field is packed (scale_factor, add_offset)", "open it with mask_and_scale=True")
    stored = np.dtype(encoding.get("dtype", values.dtype))
    scale, offset = encoding.get("scale_factor", 1.0), encoding.get("add_offset", 0.0)

    def is_fill(name: str, value: Any) -> bool:
        is_word = name.lower().strip("_") in ("fill", "missing")
        return names_fill(name) and (not is_word or np.asarray(value).dtype.kind in "iuf")

    is_plain = stored.kind == "f" and not {"scale_factor", "add_offset"} & set(encoding)
    for name, value in {**encoding, **attributes}.items():  # '-99.0' is text, which the library does not compare
        if is_fill(name, value) and isinstance(value, str):
            attributes[name] = _numbers_of(value)
        elif is_fill(name, value) and is_plain:  # nor is -999.9 of float64 equal to that of float32
            attributes[name] = value

    def limits(name: str, count: int) -> np.ndarray:
        """Numbers of an attribute, unpacked where they are as the file stores them; none where it is absent."""
        found = np.atleast_1d(attributes.get(name, []))
        if found.dtype.kind not in "iuf" or (found.size and count not in (0, found.size)):
            raise FieldError(f"the attribute {name} of the field is {attributes[name]!r}, and no numbers of a range")
        is_packed = found.dtype.kind in "iu" and stored.kind in "iu"
        if is_packed:
            return found * scale + offset
        with np.errstate(over="ignore"):
            return found.astype(values.dtype if values.dtype.kind == "f" else np.float64).astype(np.float64)

    radiance: np.ndarray = values.astype(np.float64)
    pair = limits("valid_range", 2)
    low = np.max([*pair[:1], *limits("valid_min", 1)], initial=-np.inf)
    high = np.min([*pair[1:], *limits("valid_max", 1)], initial=np.inf)
    fills = [
        *GAP_NUMBERS,
        *(one for name, value in attributes.items() if is_fill(name, value) for one in limits(name, 0)),
    ]
    if stored.str[1:] in _DEFAULT_FILLS:
        fills.append(_DEFAULT_FILLS[stored.str[1:]] * scale + offset)
    is_missing = (radiance < low) | (radiance > high) | np.isin(radiance, fills)
    is_missing |= (radiance > MAX_RADIANCE) & np.isfinite(radiance)
    return np.where(is_missing, np.nan, radiance)
