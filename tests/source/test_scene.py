"""Light that no sky has."""

import warnings

import numpy as np
import pytest
from scipy import constants

import aomc_sky as sky


def scene_of(nm, irradiance):
    uniform = sky.UniformSky(irradiance_W_m2_nm=irradiance)
    return sky.Scene(wavebands=[nm], n_photons=10, components=uniform)


@pytest.mark.parametrize("nm", [300.0, 412.0, 550.0, 900.0, 3000.0])
def test_twice_the_sun_is_the_limit(nm):
    """Planck's law at 6000 K from the disc of the sun at 1 au; by scipy's constants."""
    metres, kt = nm * 1e-9, constants.k * 6000.0
    radiance = 2 * constants.h * constants.c**2 / metres**5 / np.expm1(constants.h * constants.c / (metres * kt))
    sun = np.pi * (6.957e8 / constants.au) ** 2 * radiance * 1e-9
    scene_of(nm, 1.99 * sun)
    with pytest.warns(sky.InputWarning, match=rf"waveband 1 at {nm:g} nm has .* 2 times the sun .*a unit may be wrong"):
        scene_of(nm, 2.01 * sun)


@pytest.mark.parametrize("nm", [121.0, 299.9, 3001.0, 11_000.0])
def test_other_light_than_the_suns_has_no_limit(nm):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene_of(nm, 1e6)
