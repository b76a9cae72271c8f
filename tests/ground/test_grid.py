"""Patches: bounds, areas, indices."""

import numpy as np
import pytest
from mpmath import mp, mpf

import aomc_sky as sky


def test_areas_and_whole_degrees():
    grid = sky.PatchGrid.regular(90_000, 1)
    with mp.workdps(40):
        for k in (0, 1, 44_999, 89_998, 89_999):
            near, far = (mpf(float(x)) * mp.pi / 180 for x in grid.zenith_bounds_deg[k])
            projected = (mp.sin(far) ** 2 - mp.sin(near) ** 2) * mp.pi
            plain = (mp.cos(near) - mp.cos(far)) * 2 * mp.pi
            assert abs(grid.projected_solid_angle_sr[k] / projected - 1) < 1e-11
            assert abs(grid.solid_angle_sr[k] / plain - 1) < 1e-11
    grid = sky.PatchGrid.whole_degrees()
    assert (grid.n_zenith, grid.n_azimuth) == (89, 360)
    np.testing.assert_array_equal(grid.zenith_bounds_deg[[0, 1, 88]], [[0, 1.5], [1.5, 2.5], [88.5, 90]])
    np.testing.assert_array_equal(grid.azimuth_bounds_deg[[0, 359]], [[-0.5, 0.5], [358.5, 359.5]])
    assert abs(grid.projected_solid_angle_sr.sum() - np.pi) < 1e-13
    edges = np.linspace(0.0, 2 * np.pi, 8).astype(np.float32)
    columns = np.stack([edges[:-1], edges[1:]], axis=1)
    grid = sky.PatchGrid(zenith_bounds_deg=[[0, 90]], azimuth_bounds_rad=columns)
    assert grid.solid_angle_sr.sum() == pytest.approx(2 * np.pi)


def test_index_and_patch_belong_together():
    grid = sky.PatchGrid.regular(9, 12, azimuth_first_index=1)
    patch = np.arange(grid.n_patches)
    zenith, azimuth = grid.index_of(patch)
    assert zenith.min() == 1
    assert (azimuth.min(), azimuth.max()) == (1, 12)
    centre_z = (zenith - 0.5) * 10
    centre_a = (azimuth - 0.5) * 30
    np.testing.assert_array_equal(grid.patch_of(centre_z, centre_a), patch)
    np.testing.assert_array_equal(grid.patch_of(centre_z, centre_a + 720), patch)
    assert grid.patch_of(np.array([90.0]), np.array([0.0]))[0] == 8 * 12
    degrees = sky.PatchGrid.whole_degrees()
    assert degrees.patch_of(np.array([0.0, 45.2]), np.array([359.7, 0.4])).tolist() == [0, 44 * 360]
    for bounds in ([[0, 91]], [[10, 5]], [[0, np.nan]], [0, 90], np.empty((0, 2))):
        with pytest.raises(sky.SceneError, match="bounds"):
            sky.PatchGrid(zenith_bounds_deg=bounds, azimuth_bounds_deg=[[0, 360]])
    with pytest.raises(sky.SceneError, match="at least one"):
        sky.PatchGrid.regular(0, 3)
    with pytest.raises(sky.SceneError, match=r"at most 2\^27"):
        sky.PatchGrid.regular(10**9, 10**9)


@pytest.mark.parametrize(
    ("rings", "columns", "words"),
    [
        ([[0, 90]], [[0, 180], [90, 270]], "azimuth_bounds_deg must rise and not overlap, got 0 to 180 bef"),
        ([[0, 90]], [[180, 360], [0, 180]], "must rise and not overlap"),
        ([[0, 90]], [[0, 400]], "must not pass a whole turn, got 0 to 400"),
        ([[0, 50], [45, 90]], [[0, 360]], "zenith_bounds_deg must rise and not overlap, got 0 to 50 before 45 to 90"),
    ],
)
def test_light_is_not_counted_twice(rings, columns, words):
    with pytest.raises(sky.SceneError, match=words):
        sky.PatchGrid(zenith_bounds_deg=rings, azimuth_bounds_deg=columns)


def rings(low_deg, high_deg):
    return sky.PatchGrid(zenith_bounds_deg=[[low_deg, high_deg]], azimuth_bounds_deg=[[0, 360]])


@pytest.mark.parametrize("bounds", [(np.nextafter(0, -1), 90.0), (0.0, np.nextafter(90, 91))])
def test_no_ring_leaves_the_sky_by_one_ulp(bounds):
    assert rings(0.0, 90.0).n_zenith == 1
    with pytest.raises(sky.SceneError, match="within 0 to 90 degrees"):
        rings(*bounds)


@pytest.mark.parametrize("shape", [(0, 1), (1, 0), (-1, -1)])
def test_a_regular_grid_has_one_patch_or_more(shape):
    assert sky.PatchGrid.regular(1, 1).n_patches == 1
    with pytest.raises(sky.SceneError, match="at least one ring and one column"):
        sky.PatchGrid.regular(*shape)


def test_a_regular_grid_has_as_many_patches_as_are_allowed_and_no_more():
    assert sky.PatchGrid.regular(2**14, 2**13).n_patches == 2**27
    with pytest.raises(sky.SceneError, match=r"at most 2\^27"):
        sky.PatchGrid.regular(2**14, 2**13 + 1)


def test_points_of_a_lattice_are_whole_degrees_and_none_is_below_the_horizon():
    grid = sky.PatchGrid.lattice(92, 3)
    assert grid.zenith_bounds_deg.tolist() == [[z, z] for z in (*range(1, 91), 90, 90)]
    assert grid.azimuth_bounds_deg.tolist() == [[0, 0], [1, 1], [2, 2]]


@pytest.mark.parametrize("name", ["zenith_bounds_deg", "azimuth_bounds_deg"])
def test_bounds_of_a_grid_cannot_be_changed(name):
    with pytest.raises(ValueError, match="read-only"):
        getattr(rings(0.0, 90.0), name)[0, 0] = 1.0
