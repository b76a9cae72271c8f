"""Columns towards a high sun as polynomials, beside the quadrature; none for a low sun."""

from __future__ import annotations

import numpy as np
import pytest

from aomc_sky.atmosphere.eclipse import sun_series
from aomc_sky.atmosphere.optical_depth import columns_to_top, density_profile
from aomc_sky.atmosphere.order_one import widest_angle
from tests.support.atmospheres import full

PROFILE = density_profile(full([450.0]))
ALTITUDE = np.concatenate([[0.0, 1.0], np.linspace(50.0, PROFILE.top_m, 200)])


@pytest.mark.parametrize(
    ("sun_deg", "has_series"), [(0.0, True), (40.0, True), (60.0, True), (80.0, False), (95.0, False)]
)
def test_columns_are_those_of_the_quadrature(sun_deg: float, has_series: bool) -> None:
    """Everywhere between the ends of the cosines that rays from the ground have at an altitude."""
    sun = np.radians(sun_deg)
    series = sun_series(PROFILE, ALTITUDE, sun)
    assert (series.coefficient is not None) == has_series
    which = np.arange(ALTITUDE.size) % 3 != 0
    width = widest_angle(PROFILE, ALTITUDE[which])
    for share in np.linspace(-1.0, 1.0, 9):
        mu = np.cos(np.abs(sun + share * width))
        np.testing.assert_allclose(
            series.columns(which, mu), columns_to_top(PROFILE, ALTITUDE[which], mu), rtol=3e-7, atol=1e-300
        )
