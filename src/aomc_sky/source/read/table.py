"""A sky file as the components of a scene: bins, weighting, wavelengths, and notes."""

from __future__ import annotations

import dataclasses
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from aomc_sky.component import Component
from aomc_sky.directions import sin_cos_deg
from aomc_sky.emission.irradiance import Moments, cell_moments, moments_of_rows
from aomc_sky.errors import InputFileError, InputWarning, Span, UsageError
from aomc_sky.formats.aomc.skydist import Bins, SkyTable, Values, read_skydist
from aomc_sky.formats.text_file import lines_at
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.tabulated import TabulatedSky, Weighting, aomc_weight
from aomc_sky.source.light.brightness import InBands
from aomc_sky.source.light.place import Sun
from aomc_sky.source.light.skies import Lowered, patterned
from aomc_sky.wavebands import midpoint_wavelength_index

if TYPE_CHECKING:
    from aomc_sky.source.scene import Scene

_HORIZON = 90  # degrees: the last zenith index that the AOMC program can use
_MOST_ENTRIES = 20
_FEW_COLUMNS = 3  # the example of the format's description has two of three
_BEYOND = "as whole degrees the zenith index must not go beyond {}"
_DEGREES_ADVICE = "without --bins degrees indices are numbers of equal bins"


@dataclass(frozen=True, kw_only=True, slots=True)
class Table:
    """skydist.inp as the sky of a scene."""

    table: SkyTable
    sky: TabulatedSky
    reading: dict[str, str | None]  #: how it was read
    is_compat: bool
    is_told: bool  #: whether the caller, sky.toml or the file says what its values are
    name, made_of, names = "table", "skydist.inp", ("bins", "azimuth_bins", "weighting")
    needs_sun = False
    has_sun = is_whole = True

    def irradiance(self, sun: Sun | None, wavelength_nm: np.ndarray) -> None:
        """It is relative."""

    def lower(self, sun: Sun | None, wavelength_nm: np.ndarray, light: InBands) -> Lowered:
        """A row for each set that a waveband takes."""
        of_band = self.sky.table_index(wavelength_nm)
        self.sky.warn_of_distance(wavelength_nm, of_band, self.table.path)
        sets, rows = np.unique(of_band, return_inverse=True)
        rows, of_table = rows.ravel(), self.sky.table_wavelength_nm(wavelength_nm)
        components = self.sky.lower_rows(sets)
        if not self.is_told:
            radiances = dataclasses.replace(self.sky, weighting=Weighting.PROJECTED).lower_rows(sets)
            _warn_of_two_readings(self.table.path, components[0], radiances[0], rows)
        components = patterned(self.sky, components, sun, self.sky.wavelength_nm[sets], self.made_of)
        notes = () if self.is_compat else tuple(_notes(self.table, self.sky))
        return Lowered(components=components, row_of_band=rows, notes=notes, table_wavelength_nm=of_table)


def table_of(table: SkyTable, *, compat: str | None, **how: str | None) -> Table:
    """A sky file as the sky of a scene; `how` as `tabulated_sky` takes it."""
    sky, reading = tabulated_sky(table, compat=compat, **how)
    is_told = bool(compat or how["weighting"] or table.declared_values)
    return Table(table=table, sky=sky, reading=reading, is_compat=compat is not None, is_told=is_told)


def tabulated_sky(
    table: SkyTable,
    *,
    bins: str | None = None,
    weighting: str | None = None,
    compat: str | None = None,
    azimuth_bins: str | None = "n+1",
) -> tuple[TabulatedSky, dict[str, str | None]]:
    """A sky file as a model, by default as the file declares, and how it was read."""
    if compat:
        return _compat_sky(table), {"bins": "degrees", "weighting": "aomc", "azimuth_bins": "n+1"}
    kind = Bins(bins) if bins else table.declared_bins or Bins.EQUAL
    declared = {Values.RADIANCE: "projected", Values.MASS: "listed", None: "listed"}[table.declared_values]
    meaning = Weighting(weighting or declared)
    grid, values = _grid_and_values(table, kind, azimuth_bins)
    if meaning is Weighting.AOMC and kind is not Bins.DEGREES:
        raise UsageError("weighting 'aomc' is the program's weight of whole degrees", "write --bins degrees with it")
    if meaning is Weighting.AOMC:
        _refuse_infinite_float32(table)
    sky = TabulatedSky(wavelength_nm=table.wavelength_nm, values=values, grid=grid, weighting=meaning)
    return sky, {"bins": kind.value, "weighting": meaning.value, "azimuth_bins": azimuth_bins}


def _compat_sky(table: SkyTable) -> TabulatedSky:
    """The program's reading: lattice points, its weights, midpoints in file order."""
    n_table, n_zenith, n_columns = table.radiance.shape
    beyond = np.add(np.argwhere(table.radiance[:, 90:, :] > 0), (0, 90, 0))
    if beyond.size:
        _raise_once(table, beyond, _BEYOND.format(90), "the program's zenith indices are degrees; correct the index")
    _refuse_infinite_float32(table)
    return TabulatedSky(
        wavelength_nm=table.wavelength_nm,
        values=table.radiance.reshape(n_table, -1),
        grid=PatchGrid.lattice(n_zenith, n_columns),
        weighting=Weighting.AOMC,
        midpoint_rule=True,
    )


def _refuse_infinite_float32(table: SkyTable) -> None:
    too_large = np.argwhere(table.radiance > np.finfo(np.float32).max)
    if too_large.size:
        message = "the value is infinite in the program's 32-bit floats, so it launches no photon"
        _raise_at(table, too_large, "E302", message, "divide all values of the file by one number")


def _grid_and_values(table: SkyTable, bins: Bins, azimuth_bins: str | None) -> tuple[PatchGrid, np.ndarray]:
    n_table, n_zenith, n_columns = table.radiance.shape
    if bins is Bins.DEGREES:
        if azimuth_bins != "n+1":
            raise UsageError("azimuth_bins 'n' counts equal bins; it contradicts bins 'degrees'")
        return PatchGrid.whole_degrees(), _degree_values(table)
    if azimuth_bins == "n":
        if n_columns < 2:
            raise UsageError("azimuth_bins 'n' needs sky_azimuth of at least 1 in the header")
        stray = np.argwhere(table.radiance[:, :, :1] > 0)
        if stray.size:
            message = "azimuth index 0 has no bin when indices run from 1 (--azimuth-bins n)"
            _raise_at(table, stray, "E301", message, "write --azimuth-bins n+1, or number from 1")
        grid = PatchGrid.regular(n_zenith, n_columns - 1, azimuth_first_index=1)
        return grid, np.ascontiguousarray(table.radiance[:, :, 1:]).reshape(n_table, -1)
    return PatchGrid.regular(n_zenith, n_columns), table.radiance.reshape(n_table, -1)


def _degree_values(table: SkyTable) -> np.ndarray:
    """Values on the cells around whole degrees; azimuth 360 is 0."""
    n_table, n_zenith, n_columns = table.radiance.shape
    given = table.line > 0
    outside = np.add(np.argwhere(given[:, 89:, :]), (0, 89, 0))
    if outside.size:
        _raise_once(table, outside, _BEYOND.format(89), _DEGREES_ADVICE)
    far = np.add(np.argwhere(given[:, :, 361:]), (0, 0, 361))
    if far.size:
        _raise_once(table, far, "whole degrees of azimuth run from 0 to 360", _DEGREES_ADVICE)
    values = np.zeros((n_table, 89, 360))
    rings, columns = min(n_zenith, 89), min(n_columns, 360)
    values[:, :rings, :columns] = table.radiance[:, :rings, :columns]
    if n_columns > 360:
        seam, first = table.radiance[:, :rings, 360], table.radiance[:, :rings, 0]
        both = given[:, :rings, 360] & given[:, :rings, 0]
        differing = np.argwhere((both & (seam != first))[:, :, None])
        if differing.size:
            message = "azimuth 0 and 360 are one direction, but their values differ"
            advice = "give the direction once, or the same value twice"
            _raise_at(table, np.add(differing, (0, 0, 360)), "E309", message, advice)
        values[:, :rings, 0] = np.where(given[:, :rings, 360], seam, first)
    return values.reshape(n_table, -1)


def _raise_once(table: SkyTable, entries: np.ndarray, message: str, advice: str) -> None:
    """Raise E307 for entries (n, 3) that one reading makes wrong: the first line, and how many more."""
    first = np.argmin(table.line[tuple(entries.T)])
    n_more = len(entries) - 1
    more = f" (and {n_more} more line{'s' if n_more > 1 else ''} like this)" if n_more else ""
    _raise_at(table, entries[first : first + 1], "E307", message + more, advice)


def _raise_at(table: SkyTable, entries: np.ndarray, code: str, message: str, advice: str) -> None:
    """Raise for the first 20 entries (n, 3) in the order of the indices, sorted by their lines."""
    indices = sorted(map(tuple, entries[:_MOST_ENTRIES].tolist()), key=lambda index: table.line[index])
    line_of = {index: int(table.line[index]) for index in indices}
    texts = lines_at(table.path, line_of.values())
    problems = []
    for (_, zenith, azimuth), line in line_of.items():
        text, field = texts.get(line, ""), f"zenith index {zenith + 1}, azimuth index {azimuth}"
        span = Span(line, 1, text, len(text.rstrip()))
        problems.append(span.problem(table.path, code, message, field=field, advice=advice))
    raise InputFileError(problems)


def _notes(table: SkyTable, sky: TabulatedSky) -> list[str]:
    notes = []
    if table.wavelength_nm.size > 1 and np.any(np.diff(table.wavelength_nm) < 0):
        notes.append(
            "the wavelengths of skydist.inp are not in ascending order: bands take the nearest one; the AOMC "
            "program compares with midpoints in file order and may take another"
        )
    offers = sky.grid.azimuth_first_index == 0 and sky.weighting is not Weighting.AOMC
    if offers and table.radiance.shape[2] > 1 and not np.any(table.line[:, :, 0]) and np.any(table.line):
        warnings.warn(
            f"{table.path}: warning[E311]: azimuth index 0 is empty at every wavelength; if indices run from 1 to "
            f"{table.radiance.shape[2] - 1}, write --azimuth-bins n",
            InputWarning,
            stacklevel=5,
        )
    has_entry = np.any(table.line, axis=(0, 1))
    if offers and len(has_entry) > _FEW_COLUMNS and np.all(has_entry[:-1]) and not has_entry[-1]:
        low, high = sky.grid.azimuth_bounds_deg[-1]
        n = table.radiance.shape[2] - 1
        warnings.warn(
            f"{table.path}: warning[E313]: azimuth index {n}, the last of the header, is empty at all wavelengths: the "
            f"sky is dark from azimuth {low:g} to {high:g} degrees; for {n} columns numbered from 0 write {n - 1} as "
            "sky_azimuth in the header; where it is dark indeed, write a row with the value 0",
            InputWarning,
            stacklevel=5,
        )
    return notes


_MATTERS = 0.05
"""Difference of Ed/Eo by two readings that a person must hear of."""


def _warn_of_two_readings(path: str, masses: Component, radiances: Component, rows: np.ndarray) -> None:
    """Warn where values as radiances give another Ed/Eo than as masses; `rows` are those of the wavebands."""
    ours, theirs = (_moments_of_rows(one, set(rows.tolist())) for one in (masses, radiances))
    both = [(ours[row].planar_over_scalar, theirs[row].planar_over_scalar) for row in rows.tolist()]
    band = int(np.argmax([abs(one - other) / min(one, other) if min(one, other) > 0 else 0.0 for one, other in both]))
    listed, projected = both[band]
    if abs(listed - projected) > _MATTERS * min(listed, projected):
        in_band = f" in waveband {band + 1}" if len(both) > 1 else ""
        warnings.warn(
            f"{path}: warning[E312]: it does not say what its values are. As the light of each patch "
            f"(--weighting listed) Ed/Eo is {listed:.4f}{in_band}; this reading was taken. As radiances "
            f"(--weighting projected) it is {projected:.4f}. Write the option that is right, or weighting below [sky] "
            "of sky.toml",
            InputWarning,
            stacklevel=5,
        )


def has_remark(scene: Scene) -> bool:
    """Whether the sky is a table that AOMC may read otherwise."""
    return "bins" in scene.options and scene.options["compat"] is None


def remarks_of(scene: Scene) -> list[str]:
    """How skydist.inp was read, and what the program launches instead in the waveband that differs most.

    The file is read again. The list is empty without `has_remark`.
    """
    if not has_remark(scene):
        return []
    options = scene.options
    how = {name: options[name] for name in ("bins", "weighting", "azimuth_bins")}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)  # they were given before
        table = read_skydist(scene.input_files["skydist"], lenient=options["lenient"], max_memory_bytes=2**62)
    sky, _ = tabulated_sky(table, **how)
    wavelength_nm, is_on_degrees = scene.wavebands.wavelength_nm, how["bins"] == Bins.DEGREES.value
    sets, rows = np.unique(sky.table_index(wavelength_nm), return_inverse=True)
    component = sky.lower_rows(sets)[0]
    return [_reading_remark(table, sky, component, wavelength_nm, rows.ravel(), is_on_degrees=is_on_degrees)]


def _reading_remark(
    table: SkyTable,
    sky: TabulatedSky,
    component: Component,
    wavelength_nm: np.ndarray,
    rows: np.ndarray,
    is_on_degrees: bool,
) -> str:
    """The remark on a sky as it was read, `component`; `rows` are its rows for each waveband."""
    read = (
        f"skydist.inp read with {sky.weighting.value} values {'at whole degrees' if is_on_degrees else 'in equal bins'}"
    )
    lit = np.argwhere(table.radiance[:, _HORIZON:] > 0)
    if lit.size:
        index = int(lit[:, 1].max()) + _HORIZON + 1
        return f"{read}; AOMC cannot use this file, because its zenith indices go to {index}"
    taken = midpoint_wavelength_index(wavelength_nm, table.wavelength_nm).tolist()
    ours = _moments_of_rows(component, set(rows.tolist()))
    theirs = _moments_of_program(table.radiance[:, :_HORIZON], set(taken))
    pairs = [(ours[row], theirs[other]) for row, other in zip(rows.tolist(), taken, strict=True)]
    change = [np.nan_to_num(abs(aomc.mean_mu - own.mean_mu), nan=np.inf) for own, aomc in pairs]
    band = int(np.argmax(change))
    in_band = f" in waveband {band + 1}" if wavelength_nm.size > 1 else ""
    now, then = ((f"{one.mean_mu:.4f}", f"{one.planar_over_scalar:.4f}") for one in pairs[band])
    if np.isinf(change[band]):
        theirs_said = f"AOMC would launch no photon{in_band}"
    elif now == then:
        same = f"of the same mean cosine, {now[0]}, and Ed/Eo, {now[1]}"
        theirs_said = f"AOMC would read this file{in_band} as a sky {same}"
    else:
        cosines = f"of mean cosine {then[0]}, not {now[0]}, and Ed/Eo {then[1]}, not {now[1]}"
        theirs_said = f"AOMC would read this file{in_band} as a sky {cosines}"
    return f"{read}; {theirs_said}; write {_same_reading(table, sky, is_on_degrees)}"


def _moments_of_rows(component: Component, rows: set[int]) -> dict[int, Moments]:
    """Moments of each row of the component; the cells of a ring share theirs."""
    assert component.grid is not None
    n_azimuth, moments = component.grid.n_azimuth, cell_moments((component,))
    mean_mu, inverse_mu = (values[::n_azimuth] for values in moments)
    masses = {row: component.mass[row] for row in rows}
    rings = [  # sums of huge values stay finite
        (mass / (mass.max() or 1.0)).reshape(-1, n_azimuth).sum(axis=1) for mass in masses.values()
    ]
    return dict(zip(masses, moments_of_rows(rings, mean_mu, inverse_mu), strict=True))


def _moments_of_program(radiance: np.ndarray, rows: set[int]) -> dict[int, Moments]:
    """Moments of each row with the program's weights, before it rounds them to photons; NaN without light."""
    mu = sin_cos_deg(np.arange(1.0, radiance.shape[1] + 1))[1]
    with np.errstate(all="ignore"):
        ring = {row: aomc_weight(radiance[row]).sum(axis=1, dtype=np.float64) for row in rows}
        return dict(zip(ring, moments_of_rows(ring.values(), mu, 1.0 / mu), strict=True))


def _same_reading(table: SkyTable, sky: TabulatedSky, is_on_degrees: bool) -> str:
    launches = "--compat aomc to launch as AOMC does"
    if sky.weighting is Weighting.AOMC and is_on_degrees:
        return launches
    if np.any(table.line[:, _HORIZON - 1 :]) or np.any(table.line[:, :, 361:]):
        return launches  # --bins degrees refuses such indices
    return f"--bins degrees --weighting aomc to read it so, or {launches}"
