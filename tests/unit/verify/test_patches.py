"""Intervals and patches by table: what bisection finds, at edges, between them and outside."""

from __future__ import annotations

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import Law
from aomc_sky.directions import Frame, sky_columns_deg, sky_from_travel, travel_from_sky
from aomc_sky.verify.sky.direction_counts import DirectionCounter, PhotonRows
from aomc_sky.verify.sky.patches import EdgeFinder, PatchFinder, PhotonAngles, interior_of, zone_of_patches
from aomc_sky.verify.sky.zones import drop_of_mu, growth_of_sin2
from tests.support.shared import INPUTS

RNG = np.random.default_rng(4)

STARTS = {
    "one": np.array([3.0]),
    "even": np.arange(90.0),
    "uneven": np.sort(RNG.random(200) ** 8),
    "close": np.array([0.0, 1e-9, 2e-9, 3e-9, 40.0, 40.0, 40.0, 89.0]),
    "below zero": np.arange(-0.5, 359.0),
    "all equal": np.array([7.0, 7.0, 7.0]),
}


def around(edges):
    """Edges, their neighbours in floating point, and numbers between them."""
    between = RNG.uniform(edges.min(), edges.max() + 1.0, 2000)
    return np.concatenate([edges, np.nextafter(edges, np.inf), np.nextafter(edges, -np.inf), between])


@pytest.mark.parametrize("name", STARTS)
def test_the_interval_that_bisection_finds(name):
    starts = STARTS[name]
    values = around(starts)
    wanted = np.maximum(np.searchsorted(starts, values, side="right") - 1, 0)
    assert np.array_equal(EdgeFinder(starts, starts[-1] + 1.0).find(values), wanted)
    assert np.array_equal(EdgeFinder(starts, starts[-1]).find(values), wanted)


def test_what_is_no_number_gets_some_interval():
    finder = EdgeFinder(STARTS["even"], 90.0)
    found = finder.find(np.array([np.nan, np.inf, -np.inf, 1e300, -1e300]))
    assert found.min() >= 0
    assert found.max() < 90


def grid_of(zenith, azimuth):
    return sky.PatchGrid(zenith_bounds_deg=np.array(zenith), azimuth_bounds_deg=np.array(azimuth))


GRIDS = {
    "regular": sky.PatchGrid.regular(90, 360),
    "whole degrees": sky.PatchGrid.whole_degrees(),
    "points": sky.PatchGrid.lattice(91, 360),
    "with gaps": grid_of([[5.0, 10.0], [20.0, 30.0]], [[10.0, 20.0], [20.0, 100.0], [200.0, 300.0]]),
    "not to the horizon": grid_of([[0.0, 30.0], [30.0, 60.0]], [[15.0, 195.0], [195.0, 375.0]]),
    "one patch": grid_of([[0.0, 90.0]], [[0.0, 360.0]]),
}


@pytest.mark.parametrize("name", GRIDS)
def test_the_patch_that_the_grid_finds(name):
    grid = GRIDS[name]
    zenith = np.clip(around(grid.zenith_bounds_deg.ravel()), 0.0, 180.0)
    azimuth = np.mod(around(grid.azimuth_bounds_deg.ravel()), 360.0)
    zenith, azimuth = RNG.choice(zenith, 20_000), RNG.choice(azimuth, 20_000)
    found = PatchFinder(grid).find(zenith, azimuth)
    patch = np.where(found.is_inside, found.ring * grid.n_azimuth + found.column, -1)
    assert np.array_equal(patch, grid.patch_of(zenith, azimuth))


@pytest.mark.parametrize("frame", Frame)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_angles_in_columns(frame, dtype):
    zenith, azimuth = RNG.uniform(0, 90, 5000), RNG.uniform(0, 360, 5000)
    zenith[:6], azimuth[:6] = [0.0, 90.0, 90.0, 45.0, 30.0, 60.0], [0.0, 90.0, 180.0, 270.0, 0.0, 359.9999999]
    u = travel_from_sky(zenith, azimuth, frame).astype(dtype)
    x, y, z = np.ascontiguousarray(u.T, dtype=np.float64)
    found = sky_columns_deg(x, y, z, x * x + y * y, frame)
    for x, wanted in zip(found, sky_from_travel(u, frame), strict=True):
        np.testing.assert_array_max_ulp(x, np.rad2deg(wanted), maxulp=8)
    assert found[1].max() < 360.0


def plainly(component, zenith_deg, azimuth_deg, n):
    """Photons of each step along and across patches, by the differences of sines and cosines."""
    grid = component.grid
    ring, column = np.divmod(grid.patch_of(zenith_deg, azimuth_deg), grid.n_azimuth)
    near, far = grid.zenith_bounds_deg[ring].T
    measure = {Law.CELL_MU: drop_of_mu, Law.CELL_MU2: growth_of_sin2}.get(component.law, lambda b: b[:, 1] - b[:, 0])
    along = measure(np.column_stack([near, zenith_deg])) / measure(np.column_stack([near, far]))
    start, end = grid.azimuth_bounds_deg[column].T
    across = np.mod(azimuth_deg - start, 360.0) / (end - start)
    return [np.bincount(np.clip((x * n).astype(int), 0, n - 1), minlength=n) for x in (along, across)]


@pytest.mark.parametrize(
    ("name", "weighting"), [("clear_day", None), ("clear_day", "solid-angle"), ("overcast", None), ("perez_sky", None)]
)
def test_steps_inside_patches(name, weighting):
    """The same whole numbers as by the differences of sines and cosines, patch by patch."""
    options = {} if weighting is None else {"weighting": weighting}
    scene = sky.read_scene(INPUTS / name / "amc.inp", iterations=30_000, **options)
    source = scene.source(3)
    interior, why = interior_of(source)
    assert interior is not None, why
    directions = source.photons(0).directions
    zenith, azimuth = (np.rad2deg(x) for x in sky_from_travel(directions))
    usable = interior._is_usable[interior.grid.patch_of(zenith, azimuth)]
    angles = PhotonAngles.of(directions, Frame.UP)
    counts = interior.tally(angles, interior.find(angles))
    assert counts.patch.sum() == usable.sum() > 5000
    (component,) = (c for c in source.components if c.grid is not None)
    along, across = plainly(component, zenith[usable], azimuth[usable], interior.n_steps)
    assert np.array_equal(counts.along, along)
    assert np.array_equal(counts.across, across)


def test_damaged_directions_are_counted_as_such():
    zones = PatchFinder(sky.PatchGrid.regular(4, 4))
    source = sky.read_scene(INPUTS / "clear_day" / "amc.inp", iterations=1000).source(0)
    counter = DirectionCounter(zones=zones, is_dark=np.zeros(16, dtype=bool), interior=interior_of(source)[0])
    good = source.photons(0).directions[:6]
    bad = np.array([[np.nan, 0, -1], [np.inf, 0, -1], [0, 0, 0], [0, 0, np.nan], [0, 0, 1], [3e38, 3e38, -3e38]])
    counts = counter.count(PhotonRows(start=0, direction=np.concatenate([good, bad.astype(good.dtype)])))
    assert (counts.n, counts.n_bad_length) == (12, 5)
    assert counts.zone.sum() + counts.n_upward == 12
    assert 6 <= counts.zone.sum() <= 10


@pytest.mark.parametrize("name", ["regular", "whole degrees", "not to the horizon", "with gaps", "points"])
@pytest.mark.parametrize("columns", [[0, 90, 240, 300, 360], [0.5, 100.5, 360.5], [0, 360]])
def test_zones_of_whole_patches(name, columns):
    """The zone of a direction is that of its patch, or zones cut patches."""
    grid, edges = GRIDS[name], np.asarray(columns, dtype=np.float64)
    rings = np.array([0.0, 30.0, 60.0, 90.0] if name == "regular" else [0.0, 1.5, 40.5, 90.0])
    zones = grid_of(np.column_stack([rings[:-1], rings[1:]]), np.column_stack([edges[:-1], edges[1:]]))
    table = zone_of_patches(zones, grid)
    whole = {"regular": columns[0] == 0, "whole degrees": columns[-2] in (0, 100.5)}
    assert (table is not None) == whole.get(name, False)
    if table is not None:
        zenith = RNG.choice(np.append(RNG.uniform(0, 90, 500), grid.zenith_bounds_deg), 20_000)
        azimuth = RNG.choice(np.mod(np.append(RNG.uniform(0, 360, 500), grid.azimuth_bounds_deg), 360.0), 20_000)
        assert np.array_equal(table[grid.patch_of(zenith, azimuth)], zones.patch_of(zenith, azimuth))
