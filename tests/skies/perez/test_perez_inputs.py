"""The Perez sky over its whole input space: a sky of finite numbers, or an error in words."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aomc_sky.errors import SceneError
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.perez import functions as perez
from aomc_sky.skies.perez.sky import PerezSky

GRID = PatchGrid.regular(3, 4)
pytestmark = pytest.mark.filterwarnings("ignore::aomc_sky.errors.ModelLimitWarning")

zeniths = st.one_of(st.floats(0, np.nextafter(np.pi / 2, 0)), st.sampled_from([0.0, 5e-324, 1e-9, 1.5707963]))
limits = st.sampled_from(["radiance", "paper"])
directions = st.tuples(st.floats(0, np.pi / 2), st.floats(-10, 10))


def checked(arguments, direction):
    """A sky keeps its promises, or the error says that nothing shines or which number is too large."""
    try:
        sky = PerezSky(**arguments)
    except SceneError as error:
        words = str(error)
        assert any(part in words for part in ("nowhere positive", "overflows", "finite", "more than any sky")), words
        return
    value = sky.radiance(*direction, 500.0)
    assert np.isfinite(value)
    assert value >= 0
    if sky.is_dark:
        assert sky.lower([500.0]) == ()
        return
    mass = sky.patch_mass(GRID)
    assert np.all(np.isfinite(mass))
    assert mass.min() >= 0
    assert abs(mass.sum() - 1) < 1e-12
    assert sky.relative_integral > 0


@given(zeniths, st.floats(-7, 7), st.floats(0, 1e9), st.floats(0, 2), limits, directions)
def test_any_clearness_and_brightness(zenith, azimuth, epsilon, delta, limit, direction):
    arguments = {"epsilon": epsilon, "delta": delta, "limits": limit}
    checked({"sun_zenith_rad": zenith, "sun_azimuth_rad": azimuth, **arguments}, direction)


@given(zeniths, st.floats(0, 1500), st.floats(0, 1500), limits, directions)
def test_any_irradiances(zenith, dni, dhi, limit, direction):
    checked({"sun_zenith_rad": zenith, "dni": dni, "dhi": dhi, "limits": limit}, direction)


@given(zeniths, st.tuples(*[st.floats(-50, 50)] * 5), directions)
def test_any_coefficients(zenith, values, direction):
    checked({"sun_zenith_rad": zenith, "coefficients": values}, direction)


@given(st.floats(0, np.pi / 2), st.floats(0, np.pi / 2), st.floats(-10, 10), st.floats(1, 1e6), st.floats(0, 5))
def test_functions_give_numbers(zenith, xi, phi, epsilon, delta):
    values = perez.coefficients(epsilon, delta, zenith, limits="paper")
    assert np.all(np.isfinite(values))
    assert not np.isnan(perez.relative_radiance(xi, phi, zenith, values))
    values[1] = min(values[1], 0)
    assert np.isfinite(perez.relative_radiance(xi, phi, zenith, values))
    assert np.isfinite(perez.horizontal_integral(values, zenith))
