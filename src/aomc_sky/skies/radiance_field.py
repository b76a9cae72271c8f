"""A radiance field with coordinates, as programs and instruments give it, as values over patches."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from aomc_sky.directions import EDGE_DEG, AzimuthConvention, sin_cos_deg, travel_from_sky
from aomc_sky.errors import FieldError
from aomc_sky.formats.radiance_words import MAX_RADIANCE, Stated, SunAngles, by_wavelength, doubt_of_gaps
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.field_axes import SAY_BOUNDS, Axis, Azimuths, azimuths, radiances, statements, zenith_deg
from aomc_sky.skies.field_choice import Chosen, sun_of
from aomc_sky.skies.patch_integrals import slopes_of
from aomc_sky.skies.quadrature import POINTS, angles_at, centres_deg, weighted_sum, zeniths_at

_ALL_MISSING = "all values of the field are missing: NaN, fill values, or outside of valid_range"
_WIDE_GAP = 3.0  #: How many usual steps are a gap.
_HALF_DEG = 120.0  #: A gap as wide as this is a part of the sky that the field does not hold.
_SAME_DEG = 1e-6  #: Azimuths that are nearer are one.
_TWICE = 0.01  #: Most that two radiances of one direction may differ, as a share.


class Made(NamedTuple):
    """A field as a table, and how it was read."""

    arguments: dict[str, Any]  #: Of a `TabulatedSky`
    sun: SunAngles
    sun_of_file: SunAngles  #: Those of its angles that the file states and the caller does not
    convention: AzimuthConvention | None  #: None without azimuths
    names: tuple[str, ...]  #: Of the coordinates


def read_radiance_field(
    chosen: Chosen, stated: Stated, *, grid: PatchGrid | None, sun: SunAngles, other_sun: SunAngles = (None, None)
) -> Made:
    """Turn a radiance with coordinates into arguments of a `TabulatedSky`.

    An angle of the sun is that of the caller, else of the file, else of `other_sun`.

    Zenith angles and azimuths that are dimensions of the field become patches: between their bounds, or half-way
    between them. Those of scattered directions, and fields with NaN, are interpolated on the sphere to `grid`, with
    the sun as `RadianceField` has it.
    """
    field = chosen.radiance
    said = statements(field, chosen.bounds, chosen.attributes, chosen.along, stated)
    remarks = list(said.remarks)
    zenith, azimuth, wavelength, convention = said.zenith, said.azimuth, said.wavelength, said.convention
    wavelength_nm = said.wavelength_nm
    if said.radiance_unit is None:
        remarks.append("no unit of radiance is stated, so the light is relative (--radiance-unit says one)")
    of_file = sun_of(chosen, sun, convention)
    sun = _first(sun[0], of_file[0], other_sun[0]), _first(sun[1], of_file[1], other_sun[1])
    columns = None
    if azimuth is None or convention is None:
        remarks.append("the field has no azimuth, so its sky is the same all around")
    else:
        columns = azimuths(azimuth, said.azimuth_scale, convention, sun[1], remarks)
    if wavelength is None:
        remarks.append("the field has no wavelength, so its sky is the same at all wavelengths")
    point_nm = None if wavelength is None else _nm_of_points(field, zenith, azimuth, wavelength, wavelength_nm)
    row_wavelength, n_rows = (wavelength, wavelength_nm.size) if point_nm is None else (None, 1)
    values = _values(field, zenith, azimuth, row_wavelength, n_rows)
    angle = zenith_deg(zenith, zenith.values, said.zenith_scale)
    has_bounds = any(one is not None and (one.bounds is not None or one.absent_bounds) for one in (zenith, azimuth))
    settled = {"radiance_unit": said.radiance_unit or 0.0, "has_wavelength": wavelength is not None}

    def made(nm: np.ndarray, means: np.ndarray, slope: np.ndarray | None, patches: PatchGrid) -> Made:
        table = {"wavelength_nm": nm, "values": means, "slope": slope, "grid": patches, "remarks": tuple(remarks)}
        return Made({**table, **settled}, sun, of_file, convention, tuple(one.name for one in said.axes))

    if columns is None or zenith.dims != azimuth.dims:  # type: ignore[union-attr]
        edges = None if zenith.bounds is None else zenith_deg(zenith, zenith.bounds, said.zenith_scale)
        gaps: list[str] = []
        angle, values, rings = _rings(zenith, angle, edges, values, remarks, gaps)
        turned, values, bounds_of_columns = _columns(azimuth, columns, values, remarks, gaps)
        product = PatchGrid(zenith_bounds_deg=rings, azimuth_bounds_deg=bounds_of_columns)
        _check_radiances(values)
        if not np.isnan(values).any():
            slope = None
            if not has_bounds and angle.size > 1:
                means = [_joined(angle, turned, row, product) for row in values]
                values, slope = (np.stack(part) for part in zip(*means, strict=True))
            remarks += gaps
            return made(wavelength_nm, values, slope, product)
        if grid is None and np.isfinite(values).all(axis=0).mean() >= 0.5:
            grid = product  # else points that were unstacked, or a scan: no field
            remarks += gaps
        angle, turned = (one.ravel() for one in np.meshgrid(angle, turned, indexing="ij"))
        values = values.reshape(wavelength_nm.size, -1)
    else:
        angle, turned, values, point_nm = _above(zenith, angle, columns.enu_deg, values, point_nm, remarks)
    _check_radiances(values, point_nm)
    grid = PatchGrid.regular(90, 180) if grid is None else grid
    wavelength_nm, values, slope = _interpolated((angle, turned), values, wavelength_nm, point_nm, grid, sun, remarks)
    return made(wavelength_nm, values, None if has_bounds else slope, grid)


def _first(*angles: float | None) -> float | None:
    """The first one that is known."""
    return next((angle for angle in angles if angle is not None), None)


def _above(
    zenith: Axis,
    zenith_deg: np.ndarray,
    azimuth_deg: np.ndarray,
    values: np.ndarray,
    point_nm: np.ndarray | None,
    remarks: list[str],
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None]:
    """Scattered directions of the sky; a negative zenith angle is beyond the zenith, as in scans."""
    azimuth_deg = np.where(np.isnan(azimuth_deg) & (zenith_deg == 0.0), 0.0, azimuth_deg)  # overhead they are all one
    is_direction = np.isfinite(zenith_deg) & np.isfinite(azimuth_deg)
    above = is_direction & (np.abs(np.where(is_direction, zenith_deg, 0.0)) <= 90)
    _refuse_below(zenith, zenith_deg[is_direction])
    if not above.any():
        raise FieldError(f"coordinate {zenith.name!r} has no zenith angles up to 90 degrees", argument="zenith")
    for n, what in (
        (np.sum(~is_direction), "values without a direction"),
        (np.sum(is_direction & ~above), "directions below the horizon"),
    ):
        remarks += [f"{n} {what} were left out"] if n else []
    return zenith_deg[above], azimuth_deg[above], values[:, above], None if point_nm is None else point_nm[above]


def _refuse_below(zenith: Axis, angle: np.ndarray) -> None:
    """Refuse directions of which the horizon alone is of the sky: those that light goes to."""
    if np.any(angle > 90.0) and angle.min() >= 90.0:
        message = f"coordinate {zenith.name!r} has no angles below 90 degrees; are they those that light goes to?"
        raise FieldError(message, "write 180 degrees minus them, and azimuths plus 180 degrees", "zenith")


def _nm_of_points(
    field: Any, zenith: Axis, azimuth: Axis | None, wavelength: Axis, wavelength_nm: np.ndarray
) -> np.ndarray | None:
    """Wavelength of each scattered direction, where it lies along their dimensions; else None. [nm]"""
    angles = {*zenith.dims, *(azimuth.dims if azimuth else ())}
    if angles.isdisjoint(wavelength.dims):
        return None
    if azimuth is None or zenith.dims != azimuth.dims:
        raise FieldError(
            f"coordinate {wavelength.name!r} has the dimension {wavelength.dims[0]!r} of an angle; then zenith angle "
            "and azimuth must both have this dimension"
        )
    sizes = dict(zip(map(str, field.dims), field.shape, strict=True))
    shape = [sizes.get(dim, 1) for dim in zenith.dims]
    own = [size if dim in wavelength.dims else 1 for dim, size in zip(zenith.dims, shape, strict=True)]
    return np.broadcast_to(wavelength_nm.reshape(own), shape).ravel()


def _values(field: Any, zenith: Axis, azimuth: Axis | None, wavelength: Axis | None, n_wl: int) -> np.ndarray:
    """Radiance (n_wl, n_zenith, n_azimuth), or (n_wl, n_direction) of scattered directions."""
    if azimuth is not None and zenith.dims != azimuth.dims and {*zenith.dims} & {*azimuth.dims}:
        raise FieldError(
            f"coordinates {zenith.name!r} and {azimuth.name!r} share a part of their dimensions; give them all or none"
        )
    if zenith.dims != (azimuth or zenith).dims and max(len(zenith.dims), len((azimuth or zenith).dims)) > 1:
        raise FieldError(f"coordinates {zenith.name!r} and {(azimuth or zenith).name!r} must have one dimension each")
    order = [*(wavelength.dims if wavelength else ()), *zenith.dims]
    order += [dim for dim in (azimuth.dims if azimuth else ()) if dim not in zenith.dims]
    sizes = dict(zip(map(str, field.dims), field.shape, strict=True))
    others = [dim for dim in sizes if dim not in order]
    missing = [dim for dim in order if dim not in sizes]
    if missing:
        raise FieldError(f"the field has no dimension {missing[0]!r}, which its coordinate has")
    axes = {dim: k for k, dim in enumerate(sizes)}
    values = np.transpose(radiances(field), [axes[dim] for dim in (*order, *others)])
    is_scattered = azimuth is None or zenith.dims == azimuth.dims
    values = values.reshape(n_wl, -1) if is_scattered else values.reshape(n_wl, zenith.values.size, -1)
    return values if azimuth is not None else values[:, :, None]


def _check_radiances(values: np.ndarray, point_nm: np.ndarray | None = None) -> None:
    """Refuse values that are no radiance of the sky; those left out before may be anything."""
    bad = values[(values < 0) | np.isinf(values)]
    if bad.size:
        message = f"the field has values that are negative or infinite: {bad.size}, such as {bad.min():g}"
        raise FieldError(message, "a radiance is 0 or more; NaN, or a _FillValue that the file declares, is a gap")
    if np.any(values > MAX_RADIANCE):
        message = f"the field has values up to {np.nanmax(values):g}, beyond all radiances"
        raise FieldError(message, "NaN, or a _FillValue that the file declares, is a gap")
    rows = values if point_nm is None else [values[0, k] for k in by_wavelength(point_nm)]
    if doubt := doubt_of_gaps(rows):
        raise FieldError(*doubt)
    if not np.any(values > 0):
        raise FieldError("the field has no positive value" if np.isfinite(values).any() else _ALL_MISSING)


def _rings(
    zenith: Axis,
    angle: np.ndarray,
    edges: np.ndarray | None,
    values: np.ndarray,
    remarks: list[str],
    gaps: list[str],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Zenith angles of the sky, rising, values in their order, and rings around them. [deg]

    `gaps` are remarks on the rings.
    """
    above = angle <= 90.0
    if not np.all(np.isfinite(angle)):
        raise FieldError(f"coordinate {zenith.name!r} has values that are not finite", argument="zenith")
    _refuse_below(zenith, angle)
    if not np.all(angle >= 0) or not above.any():
        message = f"coordinate {zenith.name!r} has no zenith angles from 0 to 90 degrees, or some below 0"
        raise FieldError(message, "write 0 to 90 degrees, azimuths plus 180 degrees beyond the zenith", "zenith")
    if not above.all():
        remarks.append(f"{np.count_nonzero(~above)} zenith angles below the horizon were left out")
    if angle[above].size == 1 and edges is None:
        gaps.append("the field has one zenith angle, so its sky is the same from the zenith to the horizon")
    order = np.flatnonzero(above)[np.argsort(angle[above], kind="stable")]
    angle, values = angle[order], values[:, order]
    if np.any(np.diff(angle) <= 0):
        raise FieldError(f"coordinate {zenith.name!r} has a zenith angle twice", "leave one of them out", "zenith")
    if edges is None:
        _refuse_absent_bounds(zenith, np.diff(angle))
        rings = _between(angle).clip(0.0, 90.0)
        for k, edge, end in ((0, 0, 0.0), (-1, 1, 90.0)):
            if abs(end - rings[k, edge]) < rings[k, 1] - rings[k, 0]:
                rings[k, edge] = end
    else:
        rings = np.sort(edges[order], axis=1)
        if np.any((rings[:, 0] > angle + EDGE_DEG) | (rings[:, 1] < angle - EDGE_DEG)):
            raise FieldError(f"the bounds of coordinate {zenith.name!r} are not around it", SAY_BOUNDS, "zenith")
        rings[rings <= EDGE_DEG] = 0.0
        rings[rings >= 90.0 - EDGE_DEG] = 90.0
        rings = _joined_edges(zenith.name, rings)
    for low, high in zip([0.0, *rings[:, 1]], [*rings[:, 0], 90.0], strict=True):
        if high > low:
            span = f"{low:g} to {high:g} degrees"
            gaps.append(f"the field has no radiance from {span} from the zenith; no photon comes from there")
    return angle, values, rings


def _columns(
    azimuth: Axis | None, columns: Azimuths | None, values: np.ndarray, remarks: list[str], gaps: list[str]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Azimuths from +x towards +y, rising, values in their order, and columns around them. [deg]"""
    if azimuth is None or columns is None:
        return np.array([0.0]), values, np.array([[0.0, 360.0]])
    if not np.all(np.isfinite(columns.enu_deg)):
        raise FieldError(f"coordinate {azimuth.name!r} has values that are not finite", argument="azimuth")
    order = np.argsort(columns.enu_deg, kind="stable")
    turned, values = columns.enu_deg[order], values[:, :, order]
    first = np.flatnonzero(np.append(True, np.diff(turned) > _SAME_DEG))
    if first.size < turned.size:
        values = _once(values, first, columns.in_field[order], remarks)
    edges = columns.bounds_deg
    if edges is not None:
        beside = edges[order] - turned[:, None]
        beside = np.stack([np.minimum.reduceat(beside[:, 0], first), np.maximum.reduceat(beside[:, 1], first)], axis=1)
    turned = turned[first]
    after = np.append(turned[1:], turned[0] + 360.0)
    step = after - turned
    if edges is not None:
        bounds = _joined_edges(azimuth.name, turned[:, None] + beside, turn=360.0)
        away = np.append(bounds[1:, 0], bounds[0, 0] + 360.0) - bounds[:, 1]
        for k in np.flatnonzero(away > 0).tolist():
            low, high = bounds[k, 1] % 360, (bounds[k, 1] + away[k]) % 360
            span = f"azimuths {low:g} to {high:g} degrees (from +x towards +y)"
            gaps.append(f"the field has no radiance at {span}; no photon comes from there")
        return turned, values, bounds
    _refuse_absent_bounds(azimuth, step)
    k = int(step.argmax())
    between = f"the field has no azimuths between {turned[k]:g} and {after[k] % 360:g} degrees"
    if turned.size == 1:
        gaps.append("the field has one azimuth, so its sky is the same all around")
    elif step[k] >= _HALF_DEG and step[k] > 1.5 * np.median(step):
        advice = "add the other half, mirrored where the sky is alike on both sides of the sun"
        raise FieldError(f"{between} (from +x towards +y)", advice, "azimuth")
    elif step[k] >= _HALF_DEG or step[k] > (1 - 1e-9) * _WIDE_GAP * np.median(step):
        gaps.append(f"{between}; neighbours fill them")
    middle = turned + step / 2
    return turned, values, np.column_stack([np.concatenate([[middle[-1] - 360.0], middle[:-1]]), middle])


def _once(values: np.ndarray, first: np.ndarray, in_field: np.ndarray, remarks: list[str]) -> np.ndarray:
    """Radiances of azimuths that come twice, as 0 and 360 degrees, are their mean if they agree."""
    low, high = (reduce.reduceat(values, first, axis=2) for reduce in (np.fmin, np.fmax))
    with np.errstate(invalid="ignore"):
        differs = np.nan_to_num((high - low) / np.where(high > 0, high, 1.0))
    if differs.any():
        k = int(differs.max(axis=(0, 1)).argmax())
        same = in_field[first[k] : np.append(first, in_field.size)[k + 1]]
        shown = f"azimuths {' and '.join(f'{one:g}' for one in same[:2])} are one direction"
        by = f"their radiances differ by up to {100 * differs.max():.2g} %"
        if differs.max() > _TWICE:
            raise FieldError(f"{shown}, but {by}", "leave one of them out", "azimuth")
        remarks.append(f"{shown}; {by}, and count with their mean")
    return np.where(high > low, low + (high - low) / 2, high)


def _refuse_absent_bounds(axis: Axis, steps: np.ndarray) -> None:
    """Half-way between equal steps is where bounds are that the field does not hold; others cannot be known."""
    if axis.absent_bounds and np.ptp(steps) > EDGE_DEG:
        message = f"coordinate {axis.name!r} has the bounds {axis.absent_bounds!r}, which are not in this field"
        raise FieldError(message, "give the dataset that holds them: from_xarray(dataset, variable='NAME')", "table")


def _joined_edges(name: str, edges: np.ndarray, turn: float = 0.0) -> np.ndarray:
    """Bounds (n, 2) of patches in their order, neighbours touching to the bit; an error where they overlap."""
    edges = edges.copy()
    before = np.append(edges[-1, 1] - turn, edges[:-1, 1]) if turn else np.append(edges[0, 0], edges[:-1, 1])
    is_same = np.abs(edges[:, 0] - before) <= EDGE_DEG
    edges[is_same, 0] = before[is_same]
    if np.any(edges[:, 0] < before) or np.any(edges[:, 1] <= edges[:, 0]):
        raise FieldError(f"the bounds of coordinate {name!r} overlap, or are empty", SAY_BOUNDS, "table")
    return edges


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
    try:
        mean, slope = _between_samples(zenith_deg, azimuth_deg, np.ldexp(values, -exponent), grid)
    except Exception as error:  # whatever scipy says of the angles
        raise FieldError(f"the field cannot be interpolated ({error})") from error
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
    nodes, weight_v, v = _around_samples(grid.azimuth_bounds_deg, azimuth_deg)
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
    (sine, after, sine_sum), (cosine, _, _) = sin_cos_deg([nodes, nodes - rings[:, 0], nodes + rings[:, 0]])
    weight_u = length * sine * cosine
    at_nodes = PchipInterpolator(np.concatenate(angles), np.concatenate(levels))(nodes)
    weight_u /= weight_u.sum(axis=0)
    u = 2.0 * after * sine_sum / grid.ring_sin2()[1] - 1.0
    u -= (weight_u * u).sum(axis=0)  # so a constant has no slope, also where the points do not integrate a wide ring
    return _laws(at_nodes, weight_u, u, weight_v, v)


def _around_samples(bounds: np.ndarray, samples: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gauss points between bounds (n, 2) and a sample in each, their weights, and places -1 to 1, (8, n) each."""
    gauss, weights, _ = POINTS[4]
    (start, end), width = bounds.T, bounds[:, 1] - bounds[:, 0]
    ends = ((start, samples), (samples, end))
    nodes = np.concatenate([low + (high - low) * gauss[:, None] for low, high in ends])
    shares = np.concatenate([(high - low) / width * weights[:, None] for low, high in ends])
    return nodes, shares, 2.0 * (nodes - start) / width - 1.0


def _laws(
    values: np.ndarray, weight_u: np.ndarray, u: np.ndarray, weight_v: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Means (n_zenith, n_azimuth), slopes (n_patch, 2) from radiances at points (k, n_zenith, m, n_azimuth) of patches.

    Weights `weight_u` (k, n_zenith), `weight_v` (m, n_azimuth), and the places 2u - 1, 2v - 1 of the points.
    """
    values = np.moveaxis(values, 2, 0)
    lines, leaning = weighted_sum(values, weight_v), weighted_sum(values, weight_v * v)
    weights = [part[..., None] for part in (weight_u, weight_u * u)]
    mean = weighted_sum(lines, weights[0])
    first_moment = np.stack([weighted_sum(lines, weights[1]), weighted_sum(leaning, weights[0])])
    return mean, np.moveaxis(slopes_of(first_moment, mean), 0, -1).reshape(-1, 2)


def _interpolated(
    directions: tuple[np.ndarray, np.ndarray],
    values: np.ndarray,
    wavelength_nm: np.ndarray,
    point_nm: np.ndarray | None,
    grid: PatchGrid,
    sun: SunAngles,
    remarks: list[str],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Wavelengths, means and slopes of patches by 4 x 4 Gauss points, interpolated as a `RadianceField`.

    With `point_nm` the values (1, n) are those of points of their own wavelengths.
    """
    from scipy.spatial import KDTree

    from aomc_sky.skies.measured import RadianceField
    from aomc_sky.skies.on_sphere import notes_of, percent, warn_of_extrapolation

    angles_of_sun: dict[str, Any] = dict(zip(("sun_zenith_deg", "sun_azimuth_deg"), sun, strict=True))
    is_given = np.all(np.isfinite(values), axis=0)
    zenith_deg, azimuth_deg = (angle[is_given] for angle in directions)
    values = values[:, is_given]
    if point_nm is not None:
        measured = RadianceField.from_points(zenith_deg, azimuth_deg, values[0], point_nm[is_given], **angles_of_sun)
        wavelength_nm = measured.wavelength_nm
    else:
        rows = np.arange(float(len(values)))  # in place of wavelengths, which may come twice
        measured = RadianceField.from_points(zenith_deg, azimuth_deg, values, rows, **angles_of_sun)
    parts, has_sun = [measured.interpolant(row) for row in range(wavelength_nm.size)], measured.sun is not None
    remarks += (*notes_of(parts, has_sun=has_sun), *measured.remarks)
    warn_of_extrapolation(parts, has_sun=has_sun)
    nodes, weights, _ = POINTS[4]
    zenith, azimuth = zeniths_at(grid, nodes), angles_at(np.deg2rad(grid.azimuth_bounds_deg), nodes)
    asked = np.broadcast_arrays(zenith.T[:, :, None, None], azimuth.T[None, None])
    point_weight, places = weights[:, None], 2.0 * nodes[:, None] - 1.0
    laws = [_laws(part(*asked), point_weight, places, point_weight, places) for part in parts]
    means, slopes = (np.stack(one) for one in zip(*laws, strict=True))
    if not is_given.all():
        # the light of patches whose nearest direction has no value, the largest of all wavelengths
        patches = travel_from_sky(*centres_deg(grid).reshape(2, -1))
        is_gap = ~is_given[KDTree(travel_from_sky(*directions)).query(patches)[1]]
        light = means.reshape(len(means), -1) * grid.projected_solid_angle_sr
        share = float((light[:, is_gap].sum(axis=1) / light.sum(axis=1)).max())
        remarks.append(
            f"{np.sum(~is_given)} of {is_given.size} directions have no value at one wavelength or more; they "
            f"are interpolated and have {percent(share)} of the light"
        )
    return wavelength_nm, means, slopes
