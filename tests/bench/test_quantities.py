"""Exact values of the benchmark's quantities against quadratures of another kind, and against known samples."""

import numpy as np
import pytest

from bench.quantities import (
    CONE_HALF_ANGLE_DEG,
    N_ROWS,
    N_SECTORS,
    QUANTITIES,
    REFRACTIVE_INDEX,
    RING_ZENITH_DEG,
    Tally,
    cone_axis,
    histogram_grid,
)
from bench.skies import SKIES, bench_sky


@pytest.fixture(scope="module")
def skies():
    return {name: bench_sky(name) for name in SKIES}


@pytest.mark.parametrize("name", SKIES)
def test_every_truth_states_its_error(skies, name):
    truth = skies[name].truth
    assert set(truth.error) == set(QUANTITIES)
    assert all(0 < error <= 2e-10 for error in truth.error.values())
    assert abs(truth.values.histogram.sum() - 1) < 1e-9
    assert truth.values.scalar >= 1 / truth.values.planar


def test_uniform_sky_has_the_values_of_textbooks(skies):
    values = skies["uniform"].truth.values
    assert values.planar == pytest.approx(2 / 3, rel=1e-14)
    assert values.scalar == pytest.approx(2, rel=1e-14)
    # a cone of half-angle r around an axis at mu holds mu sin(r)^2 of the flux
    assert values.cone == pytest.approx(cone_axis()[2] * np.sin(np.deg2rad(CONE_HALF_ANGLE_DEG)) ** 2, rel=1e-13)
    near, far = np.cos(np.deg2rad(RING_ZENITH_DEG))
    assert values.ring == pytest.approx(near**2 - far**2, rel=1e-12)


def test_bins_are_rows_of_refracted_angle():
    grid = histogram_grid()
    assert (grid.n_zenith, grid.n_azimuth) == (N_ROWS, N_SECTORS)
    refracted = np.arcsin(np.sin(np.deg2rad(grid.zenith_bounds_deg)) / REFRACTIVE_INDEX)
    assert np.ptp(np.diff(refracted, axis=1)) < 1e-12
    assert refracted[-1, 1] == pytest.approx(np.arcsin(1 / REFRACTIVE_INDEX), rel=1e-14)


def test_regions_against_a_count_on_a_fine_lattice(skies):
    """Two million directions on a rotated lattice, weighted by the radiance."""
    n = 2_000_000
    i = np.arange(n) + 0.5
    mu = np.sqrt(i / n)
    azimuth = np.mod(i * (np.sqrt(5) - 1) / 2, 1.0) * 2 * np.pi
    zenith = np.arccos(mu)
    degrees = np.rad2deg(zenith), np.rad2deg(azimuth)
    direction = np.stack([np.sqrt(1 - mu**2) * np.cos(azimuth), np.sqrt(1 - mu**2) * np.sin(azimuth), mu])
    inside = cone_axis() @ direction > np.cos(np.deg2rad(CONE_HALF_ANGLE_DEG))
    ring = (degrees[0] >= RING_ZENITH_DEG[0]) & (degrees[0] < RING_ZENITH_DEG[1])
    bins = histogram_grid().patch_of(*degrees)
    for name in SKIES:
        if name == "spike":
            continue
        values, weight = skies[name].truth.values, weights(skies[name], zenith, azimuth)
        total = weight.sum()
        assert weight[inside].sum() / total == pytest.approx(values.cone, rel=3e-3), name
        assert weight[ring].sum() / total == pytest.approx(values.ring, rel=3e-3), name
        assert weight @ mu / total == pytest.approx(values.planar, rel=1e-4), name
        counted = np.bincount(bins, weight, minlength=values.histogram.size) / total
        assert np.linalg.norm(counted - values.histogram) < 3e-3 * np.linalg.norm(values.histogram), name


def weights(sky, zenith, azimuth):
    """Radiance in these directions, of a table from the masses of its patches."""
    if not sky.is_table:
        return sky.model.radiance(zenith, azimuth, 500.0)
    density = sky.mass / sky.grid.projected_solid_angle_sr
    return density[sky.grid.patch_of(np.rad2deg(zenith), np.rad2deg(azimuth))]


def test_half_of_the_spike_is_uniform(skies):
    """The rest lies in one patch, which the cone's rim cuts: its part inside by a lattice in the patch alone."""
    sky = skies["spike"]
    patch = int(np.argmax(sky.mass))
    ring, column = divmod(patch, sky.grid.n_azimuth)
    u = (np.arange(2000) + 0.5) / 2000
    near, far = np.cos(np.deg2rad(sky.grid.zenith_bounds_deg[ring])) ** 2
    mu = np.sqrt(far + (near - far) * u)[:, None]
    start, end = np.deg2rad(sky.grid.azimuth_bounds_deg[column])
    azimuth = start + (end - start) * u
    x, y, z = cone_axis()
    along = mu * z + np.sqrt(1 - mu * mu) * (x * np.cos(azimuth) + y * np.sin(azimuth))
    inside = np.mean(along > np.cos(np.deg2rad(CONE_HALF_ANGLE_DEG)))
    assert 0.2 < inside < 0.8
    expected = 0.5 * inside + 0.5 * skies["uniform"].truth.values.cone
    assert sky.truth.values.cone == pytest.approx(expected, rel=1e-4)


def test_tally_of_known_photons():
    """One photon in the middle of every bin, one in the cone, one in the ring, one nearly overhead."""
    grid = histogram_grid()
    zenith = np.repeat(grid.zenith_bounds_deg.mean(axis=1), N_SECTORS)
    azimuth = np.tile(grid.azimuth_bounds_deg.mean(axis=1), N_ROWS)
    for dtype in (np.float32, np.float64):
        sums = Tally()
        sums.add(*travel(zenith, azimuth, dtype))
        values = sums.values()
        assert np.all(values.histogram == 1 / (N_ROWS * N_SECTORS))
        assert values.planar == pytest.approx(np.cos(np.deg2rad(zenith)).mean(), rel=1e-6)
        assert values.scalar == pytest.approx((1 / np.cos(np.deg2rad(zenith))).mean(), rel=1e-5)
        regions = Tally()
        regions.add(*travel(np.array([33.0, 88.0, 88.69, 87.29, 0.1]), np.array([218.0, 3.0, 200, 9, 5]), dtype))
        assert (regions.values().cone, regions.values().ring) == (0.2, 0.4)


def travel(zenith_deg, azimuth_deg, dtype):
    zenith, azimuth = np.deg2rad(zenith_deg), np.deg2rad(azimuth_deg)
    vector = -np.sin(zenith) * np.cos(azimuth), -np.sin(zenith) * np.sin(azimuth), -np.cos(zenith)
    return [component.astype(dtype) for component in vector]
