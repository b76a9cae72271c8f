"""The smallest solar discs: every disc that is accepted has photons, and what is refused is named."""

import numpy as np
import pytest

import aomc_sky as sky


@pytest.mark.parametrize("zenith_deg", [0.0, 50.0, 89.0, 89.9999, 89.99995, 90.0])
@pytest.mark.parametrize("radius_deg", [1e-4, 1.23e-4, 0.0077])
def test_small_discs_have_photons(zenith_deg, radius_deg):
    beam = sky.DirectBeam(sun_zenith_deg=zenith_deg, radius_deg=radius_deg)
    batch = sky.Scene(wavebands=[550.0], n_photons=1000, components=beam).source(precision="float64").photons(0)
    assert np.all(batch.uz < 0)
    found = np.rad2deg(np.arctan2(-batch.ux, -batch.uz))
    assert abs(found - zenith_deg).max() < 1.001 * radius_deg + 1e-12


@pytest.mark.parametrize(("zenith_deg", "radius_deg"), [(90, 1e-6), (89.9999999, 1e-6), (90, 9.9e-5)])
def test_a_disc_that_is_too_small_for_the_horizon_to_cut(zenith_deg, radius_deg):
    with pytest.raises(sky.SceneError, match=f"0.0001 degrees or more, got radius_deg {radius_deg:g} at the zenith"):
        sky.DirectBeam(sun_zenith_deg=zenith_deg, radius_deg=radius_deg)
