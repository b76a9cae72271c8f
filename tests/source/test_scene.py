"""Light that no sky has."""

import warnings

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.skies.direct_beam import solar_irradiance


def scene_of(nm, irradiance):
    uniform = sky.UniformSky(irradiance_W_m2_nm=irradiance)
    return sky.Scene(wavebands=[nm], n_photons=10, components=uniform)


SUN = {300.0: 0.52535, 412.0: 1.73114, 550.0: 1.86684, 900.0: 0.91535, 3000.0: 0.025255}
"""Wavelength -> the sun outside the atmosphere of ASTM G173-03, mean over 10 nm. [W m-2 nm-1]"""


@pytest.mark.parametrize("nm", SUN)
def test_twice_the_sun_is_the_limit(nm):
    sun = float(solar_irradiance(np.array(nm)))
    assert sun == pytest.approx(SUN[nm], rel=0.05)
    scene_of(nm, 1.99 * sun)
    with pytest.warns(sky.InputWarning, match=rf"waveband 1 at {nm:g} nm has .* 2 times the sun .*a unit may be wrong"):
        scene_of(nm, 2.01 * sun)


def test_the_sun_is_within_5_percent_of_its_spectrum():
    pvlib = pytest.importorskip("pvlib")
    spectrum = pvlib.spectrum.get_reference_spectra(standard="ASTM G173-03")["extraterrestrial"]
    nm, values = spectrum.index.to_numpy(float), spectrum.to_numpy()
    integral = np.concatenate([[0.0], np.cumsum(np.diff(nm) * (values[1:] + values[:-1]) / 2)])
    middle = np.arange(300.0, 3996.0)
    mean = (np.interp(middle + 5, nm, integral) - np.interp(middle - 5, nm, integral)) / 10
    assert np.abs(solar_irradiance(middle) / mean - 1).max() < 0.0505  # the table has 4 digits


@pytest.mark.parametrize("nm", [121.0, 299.9, 4001.0, 11_000.0])
def test_other_light_than_the_suns_has_no_limit(nm):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene_of(nm, 1e6)
