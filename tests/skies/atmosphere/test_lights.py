"""The direct beam: the formula, sunrise, the reference table."""

from dataclasses import replace

import numpy as np
import pytest

from aomc_sky.skies.atmosphere.lights import ground_beam
from aomc_sky.skies.atmosphere.optical_depth import optical_depth_to_top
from tests.skies.atmosphere.reference_tables import MEDIA, needs_tables, rows
from tests.support.atmospheres import exponential, full

RADIUS_RAD = np.radians(0.2666)


def test_the_formula():
    medium = replace(full([450.0, 550.0]), toa_irradiance=np.array([2.0, 3.0]), sun_angular_radius_rad=RADIUS_RAD)
    for sun_deg in (0.0, 60.0, 89.0, 89.99):
        sun = np.radians(sun_deg)
        beam = ground_beam(medium, sun)
        np.testing.assert_allclose(beam.optical_depth, optical_depth_to_top(medium, 0.0, sun), rtol=0)
        expected = np.cos(sun) * np.array([2.0, 3.0]) * np.exp(-beam.optical_depth)
        np.testing.assert_allclose(beam.irradiance, expected, rtol=1e-15)


def test_sunrise_of_a_point():
    found = ground_beam(exponential(0.1), np.radians([89.0, 89.999, 90.0, 90.001, 91.0, 180.0])).irradiance[0]
    assert np.all(np.diff(found[:3]) < 0)
    assert found[2:].tolist() == [0.0] * 4
    assert np.isfinite(ground_beam(exponential(0.1), np.pi / 2).optical_depth[0])
    assert np.isinf(ground_beam(exponential(0.1), np.radians(90.001)).optical_depth[0])


@needs_tables
def test_reference_direct_irradiance():
    table = rows("spherical_flux.csv")
    for row in table:
        medium = MEDIA[row["case"]](float(row["wavelength_nm"]))
        found = ground_beam(medium, np.radians(float(row["sza_deg"]))).irradiance[0]
        assert found == pytest.approx(float(row["E_direct"]), rel=1e-8, abs=1e-16)
    assert len(table) == 45
