"""What the air scatters at its altitudes: closed forms, linearity, and the radiance that follows from it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import trapezoid

from aomc_sky.atmosphere.scattering_orders.diffuse import source_functions
from aomc_sky.atmosphere.sky.solve import solve
from tests.support import atmospheres

SUN = np.deg2rad(40.0)
ZENITH = np.deg2rad([0.0, 60.0, 90.0, 120.0, 180.0])
AZIMUTH = np.deg2rad([0.0, 90.0, 180.0])


@pytest.mark.parametrize("phase", [atmospheres.isotropic_phase, atmospheres.rayleigh_phase])
def test_thin_flat_air_above_a_bright_ground(phase: atmospheres.Phase) -> None:
    """Half of what the ground sends up, A F0 mu0 / pi, is scattered into every direction: its law is even in mu."""
    medium = atmospheres.exponential(
        1e-5, albedo=0.6, scale_height_m=40.0, earth_radius_m=1e14, top_m=100.0, phase=phase
    )
    found = source_functions(medium, SUN, ZENITH, AZIMUTH, n_orders=2)
    density = medium.constituents[0].number_density(found.altitude_m)
    extinction = medium.constituents[0].scattering_m2[0] * density
    expected = 0.5 * 0.6 / np.pi * np.cos(SUN) * extinction
    np.testing.assert_allclose(found.from_ground[0], np.repeat(expected[:, None], ZENITH.size, axis=1), rtol=2e-4)
    # order 2 has besides what the air itself sends, which is thinner still
    assert np.all(found.by_order[0, 0] >= found.from_ground[0][:, :, None] * (1 - 1e-9))


def test_light_of_the_ground_is_what_its_albedo_adds() -> None:
    white, black = (atmospheres.full([450.0, 700.0], albedo) for albedo in (0.4, 0.0))
    with_ground = source_functions(white, SUN, ZENITH, AZIMUTH, n_orders=2)
    without = source_functions(black, SUN, ZENITH, AZIMUTH, n_orders=2)
    assert np.all(without.from_ground == 0.0)
    added = with_ground.by_order[:, 0] - without.by_order[:, 0]
    scale = with_ground.by_order[:, 0].max()
    np.testing.assert_allclose(
        added, np.broadcast_to(with_ground.from_ground[..., None], added.shape), atol=1e-12 * scale
    )


def test_radiance_overhead_is_the_integral_of_the_source() -> None:
    """L(zenith) = int S exp(-tau) dh, order by order, with another quadrature than the solver's."""
    medium = atmospheres.molecules_only(450.0, 0.3)
    found = source_functions(medium, SUN, ZENITH[:1], AZIMUTH[:1], n_orders=4)
    altitude = np.linspace(0.0, 90e3, 20001)
    gas = medium.constituents[0]
    extinction = gas.scattering_m2[0] * gas.number_density(altitude)
    step = altitude[1]
    depth = np.concatenate([[0.0], np.cumsum(0.5 * (extinction[1:] + extinction[:-1]) * step)])
    radiance = solve(
        medium, sun_zenith_rad=SUN, sky_zenith_rad=[0.0], azimuth_from_sun_rad=[0.0], method="sos", n_orders=4
    ).radiance_by_order[0, :, 0, 0]
    for k in range(3):
        logarithm = np.interp(altitude, found.altitude_m[::-1], np.log(found.by_order[0, k, ::-1, 0, 0]))
        whole = trapezoid(np.exp(logarithm - depth), altitude)
        assert whole == pytest.approx(radiance[k + 1], rel=2e-3)
