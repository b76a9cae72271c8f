"""Slopes of a gridded radiance field: at edges of patches, of constant fields, and of fields of any magnitude."""

import numpy as np
import pytest

from aomc_sky.skies.tabulated import TabulatedSky
from tests.support.fields import field_of

ZENITH_DEG = np.arange(5.0, 90.0, 20.0)


def smooth(zenith_deg, azimuth_deg):
    return 2.0 + 1.9 * np.sin(np.deg2rad(zenith_deg)) * np.cos(np.deg2rad(azimuth_deg))


def field(zenith_deg, azimuth_deg, function):
    values = function(*np.meshgrid(zenith_deg, azimuth_deg, indexing="ij"))
    return TabulatedSky.from_xarray(field_of(values, zenith_deg, azimuth_deg))


@pytest.mark.parametrize(("n", "first", "error"), [(4, 0.1, 0.4), (24, 0.25, 0.02), (80, 0.5, 0.01), (120, 0.25, 0.01)])
def test_radiance_beside_the_edges_of_patches(n, first, error):
    table = field(ZENITH_DEG, first + np.arange(n) * 360.0 / n, smooth)
    edges = table.grid.azimuth_bounds_deg.ravel()
    beside = [np.nextafter(edges, end) for end in (-np.inf, np.inf)]
    azimuth_deg = np.concatenate([edges, *beside, edges + 360.0, edges - 720.0])
    found = table.radiance(np.deg2rad(65.0), np.deg2rad(azimuth_deg), 550.0)
    assert np.abs(found - smooth(65.0, azimuth_deg)).max() < error


@pytest.mark.parametrize("zenith_deg", [[0.0, 45.0, 90.0 - 1e-9, 90.0], [40.0, 41.0]])
def test_a_constant_field_has_no_slope(zenith_deg):
    table = field(np.array(zenith_deg), np.arange(0.0, 360.0, 30.0), lambda zenith, _: np.ones(zenith.shape))
    assert np.all(table.slope == 0)
    np.testing.assert_allclose(table.values, 1.0, rtol=1e-14)


@pytest.mark.parametrize("scale", [5e-324, 1e-310, 9e29])
def test_fields_of_any_magnitude(scale):
    table = field(ZENITH_DEG, np.arange(0.0, 360.0, 30.0), lambda zenith, _: np.where(zenith < 40, scale, 0.5 * scale))
    assert np.all(np.isfinite(table.values))
    assert table.values.max() == pytest.approx(scale, rel=0.01, abs=0.0)
    assert np.all(np.abs(table.slope) <= 1)
