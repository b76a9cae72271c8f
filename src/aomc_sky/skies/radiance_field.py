"""A radiance field with coordinates, as programs and instruments give it, as values over patches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from aomc_sky.directions import AzimuthConvention, sin_cos_deg, to_enu_azimuth_deg
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.patch_integrals import slopes_of
from aomc_sky.skies.quadrature import POINTS, weighted_sum

#: Names by which a coordinate is known, beside those that begin with one of them.
_NAMES = {
    "zenith": (
        "zenith",
        "vza",
        "theta",
        "mu",
        "umu",
        "cos_zenith",
        "elevation",
        "view_zenith",
        "viewing_zenith",
        "sky_zenith",
    ),
    "azimuth": ("azimuth", "vaa", "phi", "view_azimuth", "viewing_azimuth", "sky_azimuth", "relative_azimuth"),
    "wavelength": ("wavelength", "wavelengths", "wavelength_nm", "wl", "w", "lambda", "wvl"),
}
_COSINES = ("mu", "cos_zenith", "umu")  #: The last one as DISORT has it: negative where light comes from the sky.
_CF_AZIMUTHS = ("sensor_azimuth_angle", "platform_azimuth_angle")  #: Clockwise from north.
_DEGREES = {"degree", "degrees", "deg", "°"}
_RADIANS = {"rad", "radian", "radians"}
_NM = {"nm": 1.0, "um": 1e3, "µm": 1e3, "micron": 1e3, "microns": 1e3, "m": 1e9, "angstrom": 0.1, "angstroms": 0.1}
_NM |= {
    f"{prefix}met{end}": factor
    for prefix, factor in (("nano", 1.0), ("micro", 1e3))
    for end in ("er", "ers", "re", "res")
}
_DIGITS = 10  #: Digits of a degree; radians become the degrees that they were.
_WIDE_GAP = 3.0  #: How many usual steps are a gap.


class _Axis(NamedTuple):
    """One coordinate of a field."""

    name: str
    dims: tuple[str, ...]
    values: np.ndarray  #: (n,), also of a coordinate with several dimensions
    attributes: dict[str, Any]


def read_radiance_field(
    field: Any,
    *,
    names: dict[str, str | None],
    angle_unit: str | None,
    azimuth_convention: AzimuthConvention | str | None,
    grid: PatchGrid | None,
    sun: Mapping[str, Any],
) -> dict[str, Any]:
    """Turn an xarray.DataArray of radiance, or what has its members, into arguments of a `TabulatedSky`.

    Zenith angles and azimuths that are dimensions of the field become patches that end half-way between them. Those of
    scattered directions, and fields with NaN, are interpolated on the sphere to `grid`, with `sun` as `RadianceField`
    has it.
    """
    _check_kind(field)
    zenith, azimuth, wavelength = (_axis(field, role, names.get(role)) for role in ("zenith", "azimuth", "wavelength"))
    if zenith is None:
        raise SceneError(
            f"the field has no coordinate of zenith angles among {_listed(field)}; say which one it is: zenith='NAME'"
        )
    remarks: list[str] = []
    zenith_deg = _zenith_deg(zenith, angle_unit)
    azimuth_deg = None if azimuth is None else _azimuth_deg(azimuth, angle_unit, azimuth_convention, remarks)
    if azimuth is None:
        remarks.append("the field has no azimuth, so its sky is the same all around")
    wavelength_nm = np.array([550.0]) if wavelength is None else _wavelength_nm(wavelength)
    if wavelength is None:
        remarks.append("the field has no wavelength, so its sky is the same at all wavelengths")
    is_scattered = azimuth is not None and zenith.dims == azimuth.dims
    point_nm = None if wavelength is None else _nm_of_points(field, zenith, azimuth, wavelength, wavelength_nm)
    of_rows, n_rows = (wavelength, wavelength_nm.size) if point_nm is None else (None, 1)
    values = _values(field, zenith, azimuth, of_rows, n_rows)
    has_bounds = any("bounds" in part.attributes for part in (zenith, azimuth) if part is not None)
    if not is_scattered:
        gaps: list[str] = []
        zenith_deg, azimuth_deg, values, product = _product(zenith, zenith_deg, azimuth_deg, values, remarks, gaps)
        _check_radiances(values)
        if not np.isnan(values).any():
            if any(angle is not None for angle in sun.values()):
                raise UsageError("the sun: not used with a field that has a value in every direction of its grid")
            slope = None
            if not has_bounds and zenith_deg.size > 1:
                means = [_joined(zenith_deg, azimuth_deg, row, product) for row in values]
                values, slope = (np.stack(part) for part in zip(*means, strict=True))
            return _arguments(wavelength_nm, values, slope, product, [*remarks, *gaps])
        if grid is None and np.isfinite(values).all(axis=0).mean() >= 0.5:
            grid = product  # else points that were unstacked, or a scan: no field
            remarks += gaps
        zenith_deg, azimuth_deg = (a.ravel() for a in np.meshgrid(zenith_deg, azimuth_deg, indexing="ij"))
        values = values.reshape(wavelength_nm.size, -1)
    else:
        above = np.abs(zenith_deg) <= 90  # negative: beyond the zenith, as in scans of the principal plane
        if not above.any():
            raise SceneError(f"coordinate {zenith.name!r} has no zenith angles up to 90 degrees")
        if not above.all():
            remarks.append(f"{np.count_nonzero(~above)} directions below the horizon were left out")
        zenith_deg, azimuth_deg, values = zenith_deg[above], np.asarray(azimuth_deg)[above], values[:, above]
        point_nm = None if point_nm is None else point_nm[above]
    _check_radiances(values)
    grid = PatchGrid.regular(90, 180) if grid is None else grid
    directions = zenith_deg, np.asarray(azimuth_deg)
    wavelength_nm, values, slope = _interpolated(directions, values, wavelength_nm, point_nm, grid, sun, remarks)
    return _arguments(wavelength_nm, values, None if has_bounds else slope, grid, remarks)


def _arguments(
    wavelength_nm: np.ndarray, values: np.ndarray, slope: np.ndarray | None, grid: PatchGrid, remarks: list[str]
) -> dict[str, Any]:
    return {"wavelength_nm": wavelength_nm, "values": values, "slope": slope, "grid": grid, "remarks": tuple(remarks)}


def _nm_of_points(
    field: Any, zenith: _Axis, azimuth: _Axis | None, wavelength: _Axis, wavelength_nm: np.ndarray
) -> np.ndarray | None:
    """Wavelength of each scattered direction, where it lies along their dimensions; else None. [nm]"""
    angles = {*zenith.dims, *(azimuth.dims if azimuth else ())}
    if angles.isdisjoint(wavelength.dims):
        return None
    if azimuth is None or zenith.dims != azimuth.dims:
        raise SceneError(
            f"coordinate {wavelength.name!r} has the dimension {wavelength.dims[0]!r} of an angle; then zenith angle "
            "and azimuth must both have this dimension"
        )
    sizes = dict(zip(map(str, field.dims), field.shape, strict=True))
    shape = [sizes.get(dim, 1) for dim in zenith.dims]
    own = [size if dim in wavelength.dims else 1 for dim, size in zip(zenith.dims, shape, strict=True)]
    return np.broadcast_to(wavelength_nm.reshape(own), shape).ravel()


def _check_kind(field: Any) -> None:
    """Refuse what has no coordinates, several variables, or no value at all."""
    if hasattr(field, "data_vars"):
        names = list(map(str, field.data_vars))
        choice = f"; choose: dataset[{names[0]!r}]" if names else ""
        shown = ", ".join(map(repr, names)) or "nothing"
        raise SceneError(f"a radiance field is one xarray.DataArray, got a Dataset of {shown}{choice}")
    if not all(hasattr(field, name) for name in ("coords", "dims", "shape", "values")):
        raise SceneError(
            f"a radiance field is an xarray.DataArray with coordinates, got {type(field).__name__}; values without "
            "coordinates: give them to sky.TabulatedSky(grid=, wavelength_nm=, values=)"
        )
    empty = [str(dim) for dim, size in zip(field.dims, field.shape, strict=True) if size == 0]
    if empty:
        raise SceneError(f"the field has no values: its dimension {empty[0]!r} has length 0")


def has_wavelength(field: Any, given: str | None) -> bool:
    """Whether a field has a coordinate of wavelengths, of this name or any."""
    return _axis(field, "wavelength", given) is not None


def _listed(field: Any) -> str:
    return ", ".join(repr(str(name)) for name in field.coords) or "none at all"


def _axis(field: Any, role: str, given: str | None) -> _Axis | None:
    """The coordinate of a role: the one that is named, or the only one whose name or standard name says it."""
    if given is not None:
        if given not in field.coords:
            raise SceneError(f"the field has no coordinate {given!r}; it has {_listed(field)}")
        candidates = [given]
    else:
        candidates = [str(name) for name in field.coords if _has_role(str(name), field.coords[name], role)]
    if role == "wavelength" and role in candidates:
        candidates = [role]
    if len(candidates) > 1:
        raise SceneError(
            f"the field has {len(candidates)} coordinates that may be its {role}: {', '.join(map(repr, candidates))}; "
            f"say which one: {role}='NAME'"
        )
    if not candidates:
        return None
    coordinate = field.coords[candidates[0]]
    values = np.asarray(coordinate.values, dtype=np.float64)
    if values.ndim > 1 and role == "wavelength":
        raise SceneError(f"coordinate {candidates[0]!r} has {values.ndim} dimensions; a wavelength has one")
    if not np.all(np.isfinite(values)):
        raise SceneError(f"coordinate {candidates[0]!r} has values that are not finite")
    attributes = {**getattr(coordinate, "encoding", {}), **coordinate.attrs}  # xarray may put the bounds into either
    return _Axis(candidates[0], tuple(map(str, coordinate.dims)), values.ravel(), attributes)


def _has_role(name: str, coordinate: Any, role: str) -> bool:
    if role != "wavelength" and not coordinate.dims:
        return False  # a single angle is not one of the sky: that of the sun, as a rule
    standard = str(coordinate.attrs.get("standard_name", ""))
    text = name.lower()
    if any(word in f"{text} {standard}" for word in ("sun", "solar", "sza", "saa")):
        return False
    in_standard = {"zenith": ("zenith_angle", "elevation_angle"), "azimuth": ("azimuth_angle",)}
    ends = in_standard.get(role, ("wavelength",))
    return text in _NAMES[role] or text.endswith(ends) or standard.endswith(ends)


def _unit(axis: _Axis, given: str | None) -> str:
    """Unit "deg" or "rad": from the argument, the attribute, or values that no radian has."""
    stated = str(axis.attributes.get("units", axis.attributes.get("unit", ""))).strip().lower()
    stated = stated if given is None else given.lower()
    if stated in _DEGREES or stated in _RADIANS:
        return "deg" if stated in _DEGREES else "rad"
    if given is None and not stated and np.abs(axis.values).max() > 2 * np.pi:
        return "deg"
    raise SceneError(
        f"coordinate {axis.name!r} does not say whether it is in degrees or radians"
        + (f" (units = {stated!r})" if stated else "")
        + "; write angle_unit='deg' or 'rad', or set its attribute units"
    )


def _zenith_deg(axis: _Axis, angle_unit: str | None) -> np.ndarray:
    name = axis.name.lower()
    if name in _COSINES:
        if np.abs(axis.values).max() > 1:
            raise SceneError(f"coordinate {axis.name!r} is a cosine, and has values beyond -1 to 1")
        return np.rad2deg(np.arccos(-axis.values if name == "umu" else axis.values))
    angle = axis.values if _unit(axis, angle_unit) == "deg" else np.rad2deg(axis.values)
    is_elevation = name == "elevation" or "elevation" in str(axis.attributes.get("standard_name", ""))
    return np.round(90.0 - angle if is_elevation else angle, _DIGITS)


def _azimuth_deg(
    axis: _Axis, angle_unit: str | None, convention: AzimuthConvention | str | None, remarks: list[str]
) -> np.ndarray:
    angle = axis.values if _unit(axis, angle_unit) == "deg" else np.round(np.rad2deg(axis.values), _DIGITS)
    stated = axis.attributes.get("azimuth_convention") if convention is None else convention
    if isinstance(stated, AzimuthConvention):
        return to_enu_azimuth_deg(angle, stated)
    if stated is not None:
        known = {member.name.lower(): member for member in AzimuthConvention}
        if str(stated).lower() not in known:
            raise SceneError(f"there is no azimuth convention {stated!r}; write {', '.join(map(repr, known))}")
        return to_enu_azimuth_deg(angle, known[str(stated).lower()])
    if axis.attributes.get("standard_name") in _CF_AZIMUTHS:
        return to_enu_azimuth_deg(angle, AzimuthConvention.NORTH_CLOCKWISE)
    remarks.append(
        f"azimuth {axis.name!r} is taken from +x towards +y, for the field does not say from where it counts"
    )
    return to_enu_azimuth_deg(angle, AzimuthConvention.ENU_FROM_EAST)


def _wavelength_nm(axis: _Axis) -> np.ndarray:
    unit = str(axis.attributes.get("units", "nm")).strip().lower()
    if unit not in _NM:
        raise SceneError(f"coordinate {axis.name!r} has the unit {unit!r}; a wavelength is in nm, um, m or angstrom")
    values = axis.values * _NM[unit]
    if np.any(values <= 0):
        raise SceneError(f"coordinate {axis.name!r} has a wavelength that is not positive")
    return values


def _values(field: Any, zenith: _Axis, azimuth: _Axis | None, wavelength: _Axis | None, n_wl: int) -> np.ndarray:
    """Radiance (n_wl, n_zenith, n_azimuth), or (n_wl, n_direction) of scattered directions."""
    if azimuth is not None and zenith.dims != azimuth.dims and {*zenith.dims} & {*azimuth.dims}:
        raise SceneError(
            f"coordinates {zenith.name!r} and {azimuth.name!r} share a part of their dimensions; give them all or none"
        )
    if zenith.dims != (azimuth or zenith).dims and max(len(zenith.dims), len((azimuth or zenith).dims)) > 1:
        raise SceneError(f"coordinates {zenith.name!r} and {(azimuth or zenith).name!r} must have one dimension each")
    order = [*(wavelength.dims if wavelength else ()), *zenith.dims]
    order += [dim for dim in (azimuth.dims if azimuth else ()) if dim not in zenith.dims]
    sizes = dict(zip(map(str, field.dims), field.shape, strict=True))
    others = [dim for dim in sizes if dim not in order]
    large = [f"{dim!r} of {sizes[dim]}" for dim in others if sizes[dim] > 1]
    if large:
        raise SceneError(
            f"the field has a dimension {large[0]} besides angles and wavelength; choose one of it: "
            f"field.isel({others[0]}=0)"
        )
    missing = [dim for dim in order if dim not in sizes]
    if missing:
        raise SceneError(f"the field has no dimension {missing[0]!r}, which its coordinate has")
    axes = {dim: k for k, dim in enumerate(sizes)}
    values = np.asarray(field.values)
    if values.dtype.kind not in "biuf":
        raise SceneError(f"the field holds {values.dtype} instead of real numbers")
    values = np.transpose(values, [axes[dim] for dim in (*order, *others)]).astype(np.float64)
    is_scattered = azimuth is None or zenith.dims == azimuth.dims
    values = values.reshape(n_wl, -1) if is_scattered else values.reshape(n_wl, zenith.values.size, -1)
    return values if azimuth is not None else values[:, :, None]


def _check_radiances(values: np.ndarray) -> None:
    """Refuse values that are no radiance of the sky; those left out before may be anything."""
    if np.any(values < 0) or np.any(np.isinf(values)):
        raise SceneError("the field has values that are negative or infinite; a radiance is finite and not negative")
    if not np.any(values > 0):
        raise SceneError("the field has no positive value")


def _product(
    zenith: _Axis,
    zenith_deg: np.ndarray,
    azimuth_deg: np.ndarray | None,
    values: np.ndarray,
    remarks: list[str],
    gaps: list[str],
) -> tuple[np.ndarray, np.ndarray, np.ndarray, PatchGrid]:
    """Zenith angles and azimuths in ascending order, values in their order, and the patches around them.

    `gaps` are remarks on these patches.
    """
    above = zenith_deg <= 90.0
    if np.any(zenith_deg < 0) or not above.any():
        raise SceneError(f"coordinate {zenith.name!r} has no zenith angles from 0 to 90 degrees, or some below 0")
    if not above.all():
        remarks.append(f"{np.count_nonzero(~above)} zenith angles below the horizon were left out")
    order = np.flatnonzero(above)[np.argsort(zenith_deg[above], kind="stable")]
    zenith_deg, values = zenith_deg[order], values[:, order]
    if np.any(np.diff(zenith_deg) <= 0):
        raise SceneError(f"coordinate {zenith.name!r} has a zenith angle twice")
    rings = _between(zenith_deg).clip(0.0, 90.0)
    for k, edge, end in ((0, 0, 0.0), (-1, 1, 90.0)):
        gap = abs(end - rings[k, edge])
        if gap < rings[k, 1] - rings[k, 0]:
            rings[k, edge] = end
        else:
            lo, hi = sorted((end, float(rings[k, edge])))
            gaps.append(
                f"the field has no radiance from {lo:g} to {hi:g} degrees from the zenith; no photon comes from there"
            )
    if azimuth_deg is None:
        columns = np.array([[0.0, 360.0]])
        return zenith_deg, np.array([0.0]), values, PatchGrid(zenith_bounds_deg=rings, azimuth_bounds_deg=columns)
    azimuth_deg, first, inverse = np.unique(azimuth_deg, return_index=True, return_inverse=True)
    if not np.allclose(values, values[:, :, first[inverse]], rtol=1e-6, atol=0.0, equal_nan=True):
        raise SceneError("the field has an azimuth twice (0 and 360 degrees are one) with different values")
    values = values[:, :, first]
    after = np.append(azimuth_deg[1:], azimuth_deg[0] + 360.0)
    step = after - azimuth_deg
    if step.max() > _WIDE_GAP * np.median(step):
        k = int(step.argmax())
        gaps.append(
            f"the field has no azimuths between {azimuth_deg[k]:g} and {after[k] % 360:g} degrees; neighbours fill them"
        )
    middle = azimuth_deg + step / 2
    columns = np.column_stack([np.concatenate([[middle[-1] - 360.0], middle[:-1]]), middle])
    return zenith_deg, azimuth_deg, values, PatchGrid(zenith_bounds_deg=rings, azimuth_bounds_deg=columns)


def _between(centres: np.ndarray) -> np.ndarray:
    """Patches (n, 2) that end half-way between centres; the outer ones are as wide beyond their centre as before it."""
    if centres.size == 1:
        return np.array([[0.0, 90.0]])
    middle = (centres[1:] + centres[:-1]) / 2
    ends = np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])
    return np.column_stack([ends[:-1], ends[1:]])


def _joined(
    zenith_deg: np.ndarray, azimuth_deg: np.ndarray, values: np.ndarray, grid: PatchGrid
) -> tuple[np.ndarray, np.ndarray]:
    """`_between_samples` of radiances of any magnitude: no product of the cubic leaves the range of floats."""
    exponent = int(np.frexp(values.max())[1])
    mean, slope = _between_samples(zenith_deg, azimuth_deg, np.ldexp(values, -exponent), grid)
    with np.errstate(over="ignore"):
        return np.minimum(np.ldexp(mean, exponent), np.finfo(np.float64).max), slope


def _between_samples(
    zenith_deg: np.ndarray, azimuth_deg: np.ndarray, values: np.ndarray, grid: PatchGrid
) -> tuple[np.ndarray, np.ndarray]:
    """Mean radiance and slopes, as of `_laws`, of the patches around samples that a monotone cubic joins.

    Four Gauss points on either side of a sample, where the cubic is smooth. SciPy's PCHIP [fritsch1984].
    """
    from scipy.interpolate import PchipInterpolator

    rings, start = grid.zenith_bounds_deg, grid.azimuth_bounds_deg[0, 0]
    nodes, of_v, v = _around_samples(grid.azimuth_bounds_deg, azimuth_deg)
    turn, column = np.divmod(np.arange(-2, azimuth_deg.size + 2), azimuth_deg.size)
    around = PchipInterpolator(azimuth_deg[column] + 360.0 * turn, values[:, column], axis=1)
    rows, across = around(nodes), around(start + np.mod(nodes + 180.0 - start, 360.0))

    def beyond(edge: float, last: int, before: int) -> np.ndarray:
        step = (edge - zenith_deg[last]) / (zenith_deg[last] - zenith_deg[before])
        return np.maximum(rows[last] + (rows[last] - rows[before]) * step, 0.0)[None]

    angles, levels = [zenith_deg], [rows]
    if rings[0, 0] == 0.0:  # the sky goes on across the zenith
        near = np.flatnonzero(zenith_deg > 0.0)[1::-1]
        angles, levels = [-zenith_deg[near], *angles], [across[near], *levels]
    else:
        angles, levels = [rings[:1, 0], *angles], [beyond(rings[0, 0], 0, 1), *levels]
    if rings[-1, 1] > zenith_deg[-1]:
        angles, levels = [*angles, rings[-1:, 1]], [*levels, beyond(rings[-1, 1], -1, -2)]
    nodes, length, _ = _around_samples(rings, zenith_deg)
    (sine, after, of_both), (cosine, _, _) = sin_cos_deg([nodes, nodes - rings[:, 0], nodes + rings[:, 0]])
    of_u = length * sine * cosine
    at_nodes = PchipInterpolator(np.concatenate(angles), np.concatenate(levels))(nodes)
    of_u /= of_u.sum(axis=0)
    u = 2.0 * after * of_both / grid.ring_sin2()[1] - 1.0
    u -= (of_u * u).sum(axis=0)  # so a constant has no slope, also where the points do not integrate a wide ring
    return _laws(at_nodes, of_u, u, of_v, v)


def _around_samples(bounds: np.ndarray, samples: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gauss points between bounds (n, 2) and a sample in each, their weights, and places -1 to 1, (8, n) each."""
    gauss, weights, _ = POINTS[4]
    (start, end), width = bounds.T, bounds[:, 1] - bounds[:, 0]
    ends = ((start, samples), (samples, end))
    nodes = np.concatenate([low + (high - low) * gauss[:, None] for low, high in ends])
    shares = np.concatenate([(high - low) / width * weights[:, None] for low, high in ends])
    return nodes, shares, 2.0 * (nodes - start) / width - 1.0


def _laws(
    values: np.ndarray, of_u: np.ndarray, u: np.ndarray, of_v: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Means (n_zenith, n_azimuth), slopes (n_patch, 2) from radiances at points (k, n_zenith, m, n_azimuth) of patches.

    Weights `of_u` (k, n_zenith), `of_v` (m, n_azimuth), and the places 2u - 1, 2v - 1 of the points.
    """
    values = np.moveaxis(values, 2, 0)
    lines, leaning = weighted_sum(values, of_v), weighted_sum(values, of_v * v)
    weights = [part[..., None] for part in (of_u, of_u * u)]
    mean = weighted_sum(lines, weights[0])
    lean = np.stack([weighted_sum(lines, weights[1]), weighted_sum(leaning, weights[0])])
    return mean, np.moveaxis(slopes_of(lean, mean), 0, -1).reshape(-1, 2)


def _interpolated(
    directions: tuple[np.ndarray, np.ndarray],
    values: np.ndarray,
    wavelength_nm: np.ndarray,
    point_nm: np.ndarray | None,
    grid: PatchGrid,
    sun: Mapping[str, Any],
    remarks: list[str],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Wavelengths, means and slopes of patches by 4 x 4 Gauss points, interpolated as a `RadianceField`.

    With `point_nm` the values (1, n) are those of points of their own wavelengths.
    """
    from aomc_sky.skies.measured import RadianceField
    from aomc_sky.skies.on_sphere import notes_of, warn_of_extrapolation

    is_given = np.all(np.isfinite(values), axis=0)
    if not is_given.all():
        n_missing = np.count_nonzero(~is_given)
        remarks.append(
            f"{n_missing} of {is_given.size} directions have no value at one wavelength or more; they are interpolated"
        )
    zenith_deg, azimuth_deg = (angle[is_given] for angle in directions)
    values = values[:, is_given]
    if point_nm is not None:
        measured = RadianceField.from_points(zenith_deg, azimuth_deg, values[0], point_nm[is_given], **sun)
        wavelength_nm = measured.wavelength_nm
    else:
        rows = np.arange(float(len(values)))  # in place of wavelengths, which may come twice
        measured = RadianceField.from_points(zenith_deg, azimuth_deg, values, rows, **sun)
    parts, has_sun = [measured.interpolant(row) for row in range(wavelength_nm.size)], measured.sun is not None
    remarks += notes_of(parts, has_sun=has_sun)
    warn_of_extrapolation(parts, has_sun=has_sun)
    nodes, weights, _ = POINTS[4]
    near, growth, far = grid.ring_sin2()
    zenith = np.arctan2(
        np.sqrt(near[:, None] + growth[:, None] * nodes), np.sqrt(far[:, None] + growth[:, None] * (1 - nodes))
    )
    bounds = np.deg2rad(grid.azimuth_bounds_deg)
    azimuth = bounds[:, :1] + (bounds[:, 1:] - bounds[:, :1]) * nodes
    asked = np.broadcast_arrays(zenith.T[:, :, None, None], azimuth.T[None, None])
    of_points, places = weights[:, None], 2.0 * nodes[:, None] - 1.0
    laws = [_laws(part(*asked), of_points, places, of_points, places) for part in parts]
    means, slopes = (np.stack(one) for one in zip(*laws, strict=True))
    return wavelength_nm, means, slopes
