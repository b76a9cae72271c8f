"""Radiance inside a patch by its slopes."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import aomc_sky as sky
from aomc_sky.component import slope_factor

GRID = sky.PatchGrid.regular(6, 8)
slopes = st.floats(-0.9, 0.9)


def factor(slope, zenith_rad, azimuth_deg, patch):
    return slope_factor(np.array(slope), GRID, GRID.ring_sin2(), np.array(patch), zenith_rad, azimuth_deg)


@given(slopes, slopes, st.integers(0, GRID.n_patches - 1))
def test_slopes_are_those_from_edge_to_edge_in_mu2_and_azimuth(s, t, patch):
    ring, column = divmod(patch, 8)
    zenith, azimuth = GRID.zenith_bounds_deg[ring], GRID.azimuth_bounds_deg[column]
    middle = np.arcsin(np.sqrt((np.sin(np.deg2rad(zenith)) ** 2).mean()))
    places = np.array([*np.deg2rad(zenith), middle])
    expected = np.multiply.outer([1 - s, 1 + s, 1], [1 - t, 1, 1 + t])
    near_far = np.array([azimuth[0], azimuth.mean(), np.nextafter(azimuth[1], 0)])
    found = factor([[[s, t]]], places[:, None], near_far, [[patch]])
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


@given(slopes, slopes, st.integers(-720, 720))
def test_whole_turns_change_nothing(s, t, turn):
    zenith, azimuth = np.deg2rad([10.0, 80.0]), np.array([50.0, 300.0])
    patch = GRID.patch_of(np.rad2deg(zenith), azimuth)
    np.testing.assert_array_equal(
        factor([s, t], zenith, azimuth + 360 * turn, patch), factor([s, t], zenith, azimuth, patch)
    )


def test_beyond_its_edges_a_patch_keeps_the_light_of_its_edges():
    """Rounding puts a direction out of its patch."""
    below = factor([0.5, 0.0], np.deg2rad([14.9, 30.1]), np.full(2, 20.0), [8, 8])
    np.testing.assert_array_equal(below, [0.5, 1.5])
