"""How a rule of a plan is refused, and the rules of its components: parameters of cells, the tables of a law."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from aomc_sky.component import N_ENVELOPE_PARAMETERS, N_LOBE_SHARED, N_SHARED, Law, cells_of_grid
from aomc_sky.directions import sin_cos_deg
from aomc_sky.errors import InputFileError, Problem
from aomc_sky.grid import PatchGrid
from aomc_sky.source.plan.options import Placement

Arrays = Mapping[str, np.ndarray]

UNIT_TOLERANCE = 1e-14
"""Of sums of squares that are 1: each has at most six roundings of half an ulp of 1; fifteen times that is allowed."""

CELL_TOLERANCE = 1e-15
"""Of a cell's parameters against its grid, which give the same bits everywhere: a few ulp of 1."""

_MOST_SHOWN = 100

_LARGEST_LUMINANCE = 1e200
_MAX_BIN_BITS = 16  # the number of a bin in its cell, and of a cell in its lobe, share one word of 32 bits
_LEAST_WIDTH = 1e-280  # of a bin: its 2^-53rd part is still a normal number, whose logarithm is known
_LARGEST_STRETCH = 1e100
_PLACES = (0.1, 0.5, 0.9)  # of a cell of an envelope, along each side
_LEAST_TAKEN = 1e-3  # envelopes of ours let four of ten photons stay and more


class PlanRuleError(Exception):
    """Code, member, and what is wrong with it; `naming` adds the path."""

    def __init__(self, code: str, member: str, message: str) -> None:
        self.code, self.member, self.message = code, member, message
        super().__init__(code, member, message)


def refuse_value(member: str, found: object, expected: str) -> PlanRuleError:
    """The problem of values that a plan cannot have (E954)."""
    text = found if isinstance(found, str) else shown(found)
    return PlanRuleError("E954", member, f"found {text}, wanted {expected}")


def shown(value: object) -> str:
    """A value for a message: short, and without characters that a terminal obeys."""
    text = ascii(value.item() if isinstance(value, np.generic) else value)
    return text if len(text) <= _MOST_SHOWN else f"{text[: _MOST_SHOWN - 3]}..."


@contextmanager
def naming(path: str) -> Iterator[None]:
    """Turn the problem of a rule into the error of a file, with code, path and member."""
    try:
        yield
    except PlanRuleError as rule:
        problem = Problem(
            path=path,
            line=0,
            column=0,
            code=rule.code,
            field=rule.member,
            message=rule.message,
            advice="make the run again, or take the plan.npz that it wrote",
        )
        raise InputFileError([problem]) from None


def check_components(arrays: Arrays, options: Mapping[str, Any]) -> None:
    """Raise E952 to E954 where the arrays of a component are not what its law reads."""
    start = arrays["component_start"]
    laws = [Law(int(law)) for law in arrays["law"][start[:-1]]]
    if laws.count(Law.PEREZ) > 1:
        raise refuse_value("law", f"{laws.count(Law.PEREZ)} components of law PEREZ", "at most one")
    for k, law in enumerate(laws):
        cells = arrays["cell"][start[k] : start[k + 1]]
        has_grid = f"zenith_bounds_deg_{k}" in arrays
        _check_members(arrays, k, law)
        grid = _grid(arrays, k, len(cells)) if has_grid else None
        if grid is None:
            _CELL_RULES[law](cells)
        else:
            _check_cells_of_grid(cells, grid, law, k)
        if law is Law.PEREZ:
            assert grid is not None
            mass = arrays["mass"][:, start[k] : start[k + 1]]
            _check_perez_sky(arrays[f"shared_{k}"], f"shared_{k}")
            _check_perez_bounds(arrays[f"bounds_{k}"], f"bounds_{k}", arrays[f"shared_{k}"], grid, mass)
        elif law.is_lobe:
            _check_frame(arrays[f"shared_{k}"], f"shared_{k}", law)
            _check_envelope(arrays[f"bounds_{k}"], f"bounds_{k}")
            _check_fall(arrays[f"bounds_{k}"], arrays[f"shared_{k}"], f"bounds_{k}", law)
    if options["allocation"] == "aomc" and (len(laws) != 1 or "zenith_bounds_deg_0" not in arrays):
        raise PlanRuleError("E955", "options.allocation", f"found aomc with {len(laws)} components, wanted one table")
    if options["placement"] == Placement.CENTRE.value and any(law.is_lobe for law in laws):
        raise PlanRuleError("E955", "options.placement", "found centre, and a lobe has none; wanted r2 or philox")


def _check_members(arrays: Arrays, k: int, law: Law) -> None:
    """Which arrays component k has, and their shapes."""
    n = int(arrays["component_start"][k + 1] - arrays["component_start"][k])
    has_table = law is Law.PEREZ or law.is_lobe
    may_have_grid = law in (Law.CELL_MU2, Law.CELL_MU, Law.PEREZ)
    for names, is_needed, may_be in (
        (("zenith_bounds_deg", "azimuth_bounds_deg"), law is Law.PEREZ, may_have_grid),
        (("shared", "bounds"), has_table, has_table),
    ):
        present = [f"{name}_{k}" in arrays for name in names]
        if any(present) != all(present) or (is_needed and not any(present)):
            missing = names[present.index(False)]
            raise PlanRuleError("E952", f"{missing}_{k}", f"is missing, and component {k} has law {law.name}")
        if any(present) and not may_be:
            raise PlanRuleError(
                "E952", f"{names[0]}_{k}", f"does not belong to component {k}, which has law {law.name}"
            )
    if not has_table:
        return
    if law.is_lobe and n != 1:
        raise refuse_value("component_start", f"{n} cells of component {k}", f"one, for law {law.name}")
    shared, bounds = arrays[f"shared_{k}"].shape, arrays[f"bounds_{k}"].shape
    if law.is_lobe:
        fits, expected = shared == (N_LOBE_SHARED,), f"({N_LOBE_SHARED},)"
        fits_bounds, expected_bounds = bounds[1] == N_ENVELOPE_PARAMETERS, f"(n, {N_ENVELOPE_PARAMETERS})"
    else:
        fits, expected = shared == (N_SHARED,), f"({N_SHARED},)"
        fits_bounds, expected_bounds = bounds == (n, 4), f"({n}, 4)"
    if not fits:
        raise PlanRuleError("E953", f"shared_{k}", f"found shape {shared}, wanted {expected} for law {law.name}")
    if not fits_bounds:
        raise PlanRuleError("E953", f"bounds_{k}", f"found shape {bounds}, wanted {expected_bounds} for law {law.name}")


def _grid(arrays: Arrays, k: int, n_cell: int) -> PatchGrid:
    zenith, azimuth = arrays[f"zenith_bounds_deg_{k}"], arrays[f"azimuth_bounds_deg_{k}"]
    if len(zenith) * len(azimuth) != n_cell:
        what = f"{len(zenith)} rings and {len(azimuth)} columns"
        raise refuse_value(f"zenith_bounds_deg_{k}", what, f"as many patches as component {k} has cells, {n_cell}")
    for name, bounds in (("zenith", zenith), ("azimuth", azimuth)):
        width = bounds[:, 1] - bounds[:, 0]
        if width.min() < 0 or width.max() > 360:
            raise refuse_value(
                f"{name}_bounds_deg_{k}", bounds[int(np.abs(width - 180).argmax())].tolist(), "start <= end"
            )
    return PatchGrid(zenith_bounds_deg=zenith, azimuth_bounds_deg=azimuth)


def _check_cells_of_grid(cells: np.ndarray, grid: PatchGrid, law: Law, k: int) -> None:
    off = np.abs(cells - cells_of_grid(grid, law)).max(axis=1)
    if not (off.max() <= CELL_TOLERANCE and cells[:, :4].min() >= 0.0):
        worst = int(off.argmax())
        raise refuse_value("cell", cells[worst].tolist(), f"the parameters of patch {worst} of component {k}")


def _require(holds: np.ndarray, cells: np.ndarray, expected: str) -> None:
    if not holds.all():
        raise refuse_value("cell", cells[int(holds.argmin())].tolist(), expected)


def _is_one(total: np.ndarray) -> np.ndarray:
    return np.asarray(np.abs(total - 1.0) <= UNIT_TOLERANCE)


def _check_flat(cells: np.ndarray) -> None:
    """CELL_MU2, CELL_MU: the three parts of 1 and half a width, none of them negative, and an azimuth."""
    near, growth, far, half_width, sine, cosine = cells.T
    holds = (cells[:, :4].min(axis=1) >= 0.0) & (half_width <= 2.0)
    holds &= _is_one(near + growth + far) & _is_one(sine * sine + cosine * cosine)
    _require(holds, cells, "near edge, growth and far edge that add up to 1, half a width up to 2, a sine and a cosine")


def _check_beam(cells: np.ndarray) -> None:
    _check_flat(cells)
    _require((cells[:, 1] == 0.0) & (cells[:, 3] == 0.0), cells, "a beam without growth and width")


def _check_disc(cells: np.ndarray) -> None:
    """DISC: two pairs of sine and cosine, and a rim that stays above the horizon."""
    sin_z, cos_z, sin_r, cos_r, sine, cosine = cells.T
    holds = (cells[:, :4].min(axis=1) >= 0.0) & _is_one(sin_z**2 + cos_z**2) & _is_one(sin_r**2 + cos_r**2)
    holds &= _is_one(sine * sine + cosine * cosine) & (sin_r > 0.0)
    holds &= cos_z * cos_r - sin_z * sin_r >= -UNIT_TOLERANCE
    _require(
        holds, cells, "sine and cosine of a zenith angle, a radius and an azimuth, all of the disc above the horizon"
    )


def _check_disc_at_horizon(cells: np.ndarray) -> None:
    """DISC_AT_HORIZON: rim and width that follow from centre and radius, so that six of ten tries hit the disc."""
    top, half_width, chord2, cos_z, sine, cosine = cells.T
    holds = (chord2 > 0.0) & (chord2 <= 4.0 * float(sin_cos_deg(5.0)[0]) ** 2 * (1.0 + 1e-12)) & (np.abs(cos_z) <= 1.0)
    holds &= (half_width > 0.0) & (half_width <= 1.0) & _is_one(sine * sine + cosine * cosine)
    _require(holds, cells, "a disc of at most 10 degrees that the horizon cuts")
    sin_z, sin_r = np.sqrt(1.0 - cos_z * cos_z), np.sqrt(chord2 * (1.0 - chord2 / 4.0))
    rim = cos_z * (1.0 - chord2 / 2.0) + sin_z * sin_r
    wide = sin_cos_deg(half_width * 90.0)[0] * sin_z
    holds = (cos_z >= 0.0) & (cos_z <= sin_r * (1.0 + 1e-9)) & (np.abs(top / rim**2 - 1.0) <= 1e-9)
    holds &= np.abs(wide / sin_r - 1.0) <= 1e-9
    _require(holds, cells, "upper rim and width of the disc around that centre")


def _check_lobe_cell(cells: np.ndarray) -> None:
    """Lobes: the mean of mu, and that of 1 / mu, for the books."""
    mean, inverse = cells[:, 0], cells[:, 2]
    holds = (mean > 0.0) & (mean <= 1.0 + 1e-9) & (inverse >= 1.0 - 1e-9) & np.all(cells[:, [1, 3, 4]] == 0.0, axis=1)
    _require(
        holds & (cells[:, 5] == 1.0),
        cells,
        "the mean of mu up to 1, that of 1 / mu from 1, and 0, 0, 0, 1 in the other columns",
    )


_CELL_RULES: dict[Law, Callable[[np.ndarray], None]] = {
    Law.CELL_MU2: _check_flat,
    Law.CELL_MU: _check_flat,
    Law.BEAM: _check_beam,
    Law.DISC: _check_disc,
    Law.DISC_AT_HORIZON: _check_disc_at_horizon,
    Law.HG: _check_lobe_cell,
    Law.GGX: _check_lobe_cell,
    Law.BECKMANN: _check_lobe_cell,
}


def _check_perez_sky(sky: np.ndarray, name: str) -> None:
    """Coefficients of a finite luminance, and a sun whose angles, sine and direction agree."""
    a, b, c, d, e, zenith, azimuth, sine = sky[:8]
    with np.errstate(over="ignore"):
        largest = (1 + abs(a)) * (1 + abs(c) * np.exp(max(d, 0.0) * np.pi) + abs(e))
    if not (b <= 0.0 and largest < _LARGEST_LUMINANCE and abs(d) < _LARGEST_LUMINANCE):
        raise refuse_value(name, sky[:5].tolist(), "coefficients a to e of a finite luminance, b at most 0")
    if not (0.0 <= zenith <= 1.0 and 0.0 <= azimuth <= 4.0):
        raise refuse_value(name, sky[5:7].tolist(), "the sun above the horizon, in quarter turns")
    (sin_z, east), (cos_z, north) = sin_cos_deg(np.array([zenith * 90.0, azimuth * 90.0]))
    expected = np.array([sin_z, sin_z * north, sin_z * east, cos_z])
    if np.abs(sky[7:] - expected).max() > UNIT_TOLERANCE:
        raise refuse_value(name, [sine, *sky[8:].tolist()], f"sine and direction of that sun, {expected.tolist()}")


def _check_perez_bounds(bounds: np.ndarray, name: str, sky: np.ndarray, grid: PatchGrid, mass: np.ndarray) -> None:
    """Bounds and tilts that the sky gives its patches, so that photons are taken soon; light where there are photons.

    Their ratio then stays below 1 in the 12 bits that hold it, and tilts are whole steps in 10 bits.
    """
    from aomc_sky.skies.perez.bounds import patch_bounds  # no other scene needs them

    zenith, azimuth = grid.zenith_bounds_deg / 90.0, grid.azimuth_bounds_deg / 90.0
    expected = patch_bounds(zenith, azimuth, sky).reshape(-1, 4)
    holds = np.all(np.abs(bounds[:, :2] - expected[:, :2]) <= 1e-12 * expected[:, :1], axis=1)
    holds &= np.all(bounds[:, 2:] == expected[:, 2:], axis=1) & ((bounds[:, 0] > 0.0) | ~np.any(mass > 0.0, axis=0))
    if not holds.all():
        k = int(holds.argmin())
        raise refuse_value(
            name, bounds[k].tolist(), f"bounds and tilts of patch {k}, {expected[k].tolist()}, above 0 if lit"
        )


def _check_frame(shared: np.ndarray, name: str, law: Law) -> None:
    """A rotation, stretched across its axis for all laws but HG, and turned as `LobeFrame` has it."""
    matrix, g = shared[:9].reshape(3, 3), float(shared[9])
    axis, across = matrix[:, 2], matrix[:, :2]
    with np.errstate(over="ignore", invalid="ignore"):  # a size beyond all numbers is refused below
        stretch = across.T @ across
    size = float(np.sqrt(np.trace(stretch)))
    holds = matrix[2, 1] == 0.0 and matrix[2, 0] >= 0.0 and 0.0 < size < _LARGEST_STRETCH
    holds = holds and abs(axis @ axis - 1.0) <= 1e-12 and bool(np.abs(across.T @ axis).max() <= 1e-12 * size)
    turned = float(np.cross(across[:, 0] / size, across[:, 1] / size) @ axis) if holds else 0.0
    if not (holds and turned > 0.0):
        raise refuse_value(name, matrix.ravel().tolist(), "a rotation, stretched across its axis, 0 in its last row")
    if law is Law.HG:
        if not (0.0 <= g < 1.0 and np.abs(stretch - np.eye(2)).max() <= 1e-12):
            raise refuse_value(name, [*matrix.ravel().tolist(), g], "a rotation, and 0 <= g < 1, for law HG")
    elif g != 0.0:
        raise refuse_value(name, g, f"g = 0 for law {law.name}")


def _check_envelope(cells: np.ndarray, name: str) -> None:
    """Bins whose numbers fit their words, whose shares stay inside the lobe, and whose masses are equal."""
    least_b, width, least_a, count, half, sine, cosine, bound = cells.T
    total = float(count.sum())
    is_power = 2.0 <= total <= 2.0**_MAX_BIN_BITS and int(total).bit_count() == 1
    if not (is_power and np.all(count == np.rint(count)) and count.min() >= 1.0 and len(cells) <= 2**_MAX_BIN_BITS):
        raise refuse_value(name, f"{total:g} bins in {len(cells)} cells", "a power of two of whole bins, 2 to 2^16")
    holds = (least_b >= 0.0) & (least_a >= 0.0) & (width > _LEAST_WIDTH) & (half > 0.0) & (half <= 0.5) & (bound > 0.0)
    holds &= np.abs(least_b + width * count + least_a - 1.0) <= 1e-12
    holds &= _is_one(sine * sine + cosine * cosine)
    area = bound * width * half
    holds &= np.abs(area / area[0] - 1.0) <= 1e-9
    if not holds.all():
        expected = "shares of the lobe that add up to 1, a part of the circle, and bins of one mass"
        raise refuse_value(name, cells[int(holds.argmin())].tolist(), expected)


def _check_fall(cells: np.ndarray, shared: np.ndarray, name: str, law: Law) -> None:
    """The bounds of an envelope lie above the cosine, and not so far that photons fall without an end.

    Both are looked at in nine places of each cell; see `kernels.lobes.law` for the law.
    """
    from aomc_sky.kernels.lobes import law as lobe_law  # no other scene needs it

    least_b, width, least_a, count, half, sine, cosine, bound = cells.T[:, :, None]
    s, t = (x.ravel() for x in np.meshgrid(_PLACES, _PLACES))
    a, b = least_a + width * count * (1.0 - s), least_b + width * count * s
    turn = half * (2.0 * t - 1.0) * (np.pi / 2)
    if law is Law.HG:
        radius, z = lobe_law.heights_hg(a, b, shared[9])
    elif law is Law.GGX:
        radius, z = np.sqrt(a), np.sqrt(b)
    else:
        radius, z = np.sqrt(-np.where(a < 0.25, np.log1p(-np.minimum(a, 0.5)), np.log(b))), np.ones_like(b)
    c, d = cosine * np.cos(turn) - sine * np.sin(turn), sine * np.cos(turn) + cosine * np.sin(turn)
    mu = -lobe_law.world(radius, z, d, c, *np.delete(shared[:9], 7))[2]
    if np.any(mu > bound * (1.0 + 1e-9)):
        worst = int((mu - bound).max(axis=1).argmax())
        raise refuse_value(name, cells[worst].tolist(), f"a bound above the cosine {mu[worst].max():g} in that cell")
    taken = float(np.sum(count[:, 0] * np.mean(np.maximum(mu, 0.0) / bound, axis=1)) / count.sum())
    if not taken >= _LEAST_TAKEN:
        raise refuse_value(name, f"a share {taken:g} of photons that stay", f"at least {_LEAST_TAKEN:g}")
