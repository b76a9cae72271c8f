"""The parts of the successive orders of scattering: Legendre series, path weights, columns."""

import mpmath
import numpy as np
import pytest

from aomc_sky.errors import SceneError
from aomc_sky.skies.atmosphere.optical_depth import optical_depth_to_top, vertical_optical_depth
from aomc_sky.skies.atmosphere.scattering_orders.orders import legendre_table, phase_moments
from aomc_sky.skies.atmosphere.scattering_orders.slab import altitude_grid, slabs_of_medium
from tests.support import atmospheres


def test_addition_theorem_at_high_degree():
    one, two, azimuth, n = 0.3, -0.8, 2.2, 150
    first, second = (legendre_table(np.array([x]), n, n)[:, :, 0] for x in (one, two))
    cosine = one * two + np.sqrt((1 - one**2) * (1 - two**2)) * np.cos(azimuth)
    terms = np.where(np.arange(n) == 0, 1.0, 2.0) * np.cos(np.arange(n) * azimuth)
    for degree in (0, 1, 60, 149):
        m = np.arange(degree + 1)
        found = np.sum(terms[m] * first[m, degree - m] * second[m, degree - m])
        assert found == pytest.approx(float(mpmath.legendre(degree, cosine)), abs=1e-12)


def test_moments_of_a_peak_and_of_no_phase_function():
    sharp = phase_moments(lambda cosine: atmospheres.peaked_phase(cosine, 0), 4)
    assert sharp[0] == 1.0
    x = (np.arange(200_000) + 0.5) / 200_000
    cosine = 1.0 - 2.0 * x**4
    mean = np.mean(16.0 * np.pi * x**3 * cosine * atmospheres.peaked_phase(cosine, 0))
    assert sharp[1] == pytest.approx(mean, rel=1e-7)
    with pytest.raises(SceneError, match=r"integral 1\.1 over the sphere"):
        phase_moments(lambda cosine: np.full_like(cosine, 1.1 / (4.0 * np.pi)), 4)


def test_moments_of_a_phase_function_with_jumps():
    """A stair: its moments are differences of Legendre functions, x_l = 2 pi h (P_l-1 - P_l+1)(c) / (2 l + 1)."""
    at, low, high = np.array([-0.97, 0.3]), 0.01, 0.1
    last = (1.0 / (2.0 * np.pi) - low * (at[1] - at[0]) - high * (1.0 - at[1])) / (at[0] + 1.0)
    found = phase_moments(lambda c: np.where(c > at[1], high, np.where(c > at[0], low, last)), 40)
    for degree in range(1, 40):
        values = [np.polynomial.legendre.legval(at, np.eye(42)[degree + k]) for k in (-1, 1)]
        steps = np.array([low - last, high - low])
        expected = 2.0 * np.pi * steps @ (values[0] - values[1]) / (2 * degree + 1)
        np.testing.assert_allclose(found[degree], expected, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("medium", [atmospheres.full([450.0, 600.0]), atmospheres.mol_ozone([550.0])])
def test_columns_of_a_medium(medium):
    sun = np.deg2rad(80.0)
    grid = altitude_grid(medium, 8)
    assert set(atmospheres.OZONE_KINKS_M) <= set(grid.edge_m)
    assert np.all(np.diff(grid.edge_m) < 0.0)
    for row, slab in enumerate(slabs_of_medium(medium, grid, sun)):
        assert slab.edge_depth[-1] == pytest.approx(vertical_optical_depth(medium)[row].sum(), rel=1e-9)
        assert np.all((slab.share > 0.0) & (slab.share < 1.0))
        share = slab.scattering.sum(axis=0)
        assert np.all((share > 0.0) & (share <= 1.0 + 1e-12))
        depth = optical_depth_to_top(medium, grid.node_m.ravel(), float(sun))[row]
        np.testing.assert_allclose(slab.beam.ravel(), np.exp(-depth), rtol=1e-12)


def test_a_wavelength_that_sees_nothing():
    both = atmospheres.medium_of([atmospheres.molecules(np.array([400.0, 500.0]))], [400.0, 500.0])
    both.constituents[0].scattering_m2[1] = 0.0
    seen, empty = slabs_of_medium(both, altitude_grid(both, 6), 0.3)
    assert np.all(np.diff(empty.edge_depth) > 0.0)
    assert empty.edge_depth[-1] < 1e-12 < seen.edge_depth[-1]
    assert np.all((empty.share > 0.0) & (empty.share < 1.0))
