"""Positions inside patches, counted patch by patch."""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.directions import sky_from_travel
from aomc_sky.verify.inside import _touched, interior_of
from tests.support.shared import INPUTS


def growth(law, near, far):
    """What grows evenly with the photons of a ring, by sines of differences."""
    near, far = np.deg2rad(near), np.deg2rad(far)
    if law is Law.CELL_MU:
        return 2 * np.sin((far + near) / 2) * np.sin((far - near) / 2)
    return np.sin(far - near) * np.sin(far + near) if law is Law.CELL_MU2 else far - near


@pytest.mark.parametrize(
    ("name", "weighting"), [("clear_day", None), ("clear_day", "solid-angle"), ("overcast", None), ("perez_sky", None)]
)
def test_steps_inside_patches(name, weighting):
    """The same whole numbers as by the differences of sines and cosines, patch by patch."""
    options = {} if weighting is None else {"weighting": weighting}
    source = sky.read_scene(INPUTS / name / "amc.inp", iterations=30_000, **options).source(3)
    interior, why = interior_of(source)
    assert interior is not None, why
    zenith, azimuth = (np.rad2deg(x) for x in sky_from_travel(source.photons(0).directions))
    counts, n = interior.count(zenith, azimuth), interior.n_steps
    usable = interior.is_usable[interior.grid.patch_of(zenith, azimuth)]
    assert counts[: -2 * n].sum() == usable.sum() > 5000
    zenith, azimuth = zenith[usable], azimuth[usable]
    (component,) = (c for c in source.components if c.grid is not None)
    ring, column = np.divmod(interior.grid.patch_of(zenith, azimuth), interior.grid.n_azimuth)
    near, far = interior.grid.zenith_bounds_deg[ring].T
    start, end = interior.grid.azimuth_bounds_deg[column].T
    along = growth(component.law, near, zenith) / growth(component.law, near, far)
    across = np.mod(azimuth - start, 360.0) / (end - start)
    wanted = [np.bincount(np.clip((x * n).astype(int), 0, n - 1), minlength=n) for x in (along, across)]
    assert np.array_equal(counts[-2 * n :], np.concatenate(wanted))


def test_patches_that_touch_a_beam_are_left_out():
    """Those around the sun alone, also where it stands on the edges of four of them."""
    grid = sky.PatchGrid.regular(9, 36)
    flux = grid.projected_solid_angle_sr[None, :]
    even = Component(name="sky", law=Law.CELL_MU2, strength=np.ones(1), mass=flux, cell=cells_of_grid(grid), grid=grid)
    for azimuth, n_touched in ((45.0, 2), (40.0, 4), (0.0, 4)):
        parts = (even, sky.DirectBeam(sun_zenith_deg=30.0, sun_azimuth_deg=azimuth, strength=1.0))
        scene = sky.Scene(wavebands=[500.0], n_photons=np.array([10]), components=parts)
        interior, why = interior_of(scene.source(0))
        assert interior is not None, why
        assert np.count_nonzero(~interior.is_usable) == n_touched
        around = grid.patch_of(np.array([29.9, 30.1]), np.array([azimuth, azimuth]))
        assert not interior.is_usable[around].any()


@pytest.mark.parametrize(
    ("start", "end"), [(15, 15), (40, 40), (0, 0), (350, 355), (358, 362), (-5, 5), (30, 50), (-180, 180)]
)
def test_intervals_of_azimuth_touch_where_they_share_a_degree(start, end):
    """Both ends belong to an interval, so whole numbers tell."""
    grid = sky.PatchGrid.regular(9, 36)
    degrees = {k % 360 for k in range(start, end + 1)}
    columns = [not degrees.isdisjoint(k % 360 for k in range(low, low + 11)) for low in range(0, 360, 10)]
    rings = [low <= 30 and low + 10 >= 25 for low in range(0, 90, 10)]
    found = _touched(grid, np.array([[25.0, 30.0, start, end]]))
    assert np.array_equal(found.reshape(9, 36), np.outer(rings, columns))
