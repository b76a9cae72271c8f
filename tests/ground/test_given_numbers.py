"""Numbers of a caller that numpy would take for others: those under a mask, infinite angles, None, dates and texts."""

import datetime
import fractions
import warnings

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.shared import INPUTS

GRID = sky.PatchGrid.regular(1, 2)
HIDDEN = np.ma.masked_array([1.0, 9.97e36], mask=[False, True])  # as netCDF4 gives a missing value
UP = np.array([1.0, 0.0, 0.0, 0.0])
BANDS = np.array([440.0, 550.0])
LOBE = {"name": "town", "kind": "hg", "param0": 0.8, "param1": 0.0, "quaternion": UP, "wavelength_nm": BANDS}
MASKED = {
    "allocate": lambda: sky.allocate(HIDDEN, 10),
    "verify_counts": lambda: sky.verify_counts([5, 5], HIDDEN),
    "n_photons": lambda: sky.Scene(wavebands=BANDS, n_photons=HIDDEN, components="uniform"),
    "strength": lambda: sky.UniformSky(strength=HIDDEN),
    "wavelengths of a table": lambda: sky.TabulatedSky(wavelength_nm=HIDDEN, values=np.ones((2, 2)), grid=GRID),
    "values_q": lambda: sky.TabulatedSky(
        wavelength_nm=[550.0], values=[[1.0, 1.0]], values_q=HIDDEN[None] * 0, values_u=[[0.0, 0.0]], grid=GRID
    ),
    "spectrum": lambda: sky.lobes.WeightedLobe(**LOBE, spectrum=HIDDEN),
    "lobe": lambda: sky.lobes.background_of_lobes(
        {"town": sky.lobes.SkyLobe(kind="hg", width=0.8, spectrum=HIDDEN)}, BANDS
    ),
    "grid": lambda: sky.PatchGrid(zenith_bounds_deg=[[0.0, 90.0]], azimuth_bounds_deg=HIDDEN[None]),
    "directions": lambda: sky.RadianceField.from_points(HIDDEN, [0.0, 0.0], [1.0, 1.0]),
    "phase function": lambda: sky.rayleigh.pdf_mu(HIDDEN, 0.0),
    "perez": lambda: sky.perez.sky_clearness(HIDDEN, 100.0, 0.5),
    "in a list": lambda: sky.OvercastSky().radiance([0.1, np.ma.masked], 0.0, 550.0),
    "in rows": lambda: sky.directions.sky_from_travel([[0.0, np.ma.masked_array(0.6, mask=True), -0.8]]),
}


def test_a_masked_radiance_of_points_is_a_gap():
    zenith, azimuth = [0.0, 30.0, 60.0, 60.0, 60.0, 80.0], [0.0, 90.0, 0.0, 120.0, 240.0, 45.0]
    values = np.array([0.3, 0.25, 0.2, 0.2, np.nan, 0.1])
    hidden = np.ma.masked_array(np.nan_to_num(values, nan=9.97e36), mask=np.isnan(values))
    gap, masked = (sky.RadianceField.from_points(zenith, azimuth, one) for one in (values, hidden))
    assert masked == gap
    square = [np.reshape(one, (2, 3)) for one in (zenith, azimuth, values)]
    assert sky.RadianceField.from_points(*square) == gap  # as numpy.meshgrid gives directions
    assert hidden.data[4] == 9.97e36


INFINITE = {
    "travel": lambda x: sky.directions.travel_from_sky(30.0, x),
    "azimuth": lambda x: sky.directions.to_enu_azimuth_deg(x, sky.directions.AzimuthConvention.NORTH_CLOCKWISE),
    "perez": lambda x: sky.perez.relative_radiance(0.5, x, 0.5, [-1.0, -0.3, 5.0, -3.0, 0.4]),
    "air mass": sky.perez.relative_air_mass,
    "brightness": lambda x: sky.perez.sky_brightness(100.0, 0.5, extraterrestrial_normal=x),
    "pattern": lambda x: sky.RayleighPattern().stokes(0.5, x, sun_zenith_rad=0.5),
    "overcast": lambda x: sky.OvercastSky().radiance(x, 0.0, 550.0),
    "cie": lambda x: sky.CIESky(type=12, sun_zenith_deg=40.0).radiance(x, 0.0, 550.0),
    "clouds": lambda x: sky.HarrisonCoombesSky(sun_zenith_deg=40.0, cloud_cover=0.5).radiance(0.5, x, 550.0),
    "sun": lambda x: sky.HarrisonCoombesSky(sun_zenith_deg=np.max(x)),
    "cross section": lambda x: sky.atmosphere.rayleigh_cross_section(1.0003, 288.0, 1.0 / x),
}


@pytest.mark.parametrize("value", [np.inf, [0.1, np.inf]])
@pytest.mark.parametrize("name", INFINITE)
def test_infinite_angles_are_refused_without_a_warning_of_numpy(name, value):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(sky.AomcSkyError):
            INFINITE[name](np.asarray(value))


def test_what_overflows_and_what_is_no_wavelength():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(sky.SceneError, match="from 0 to below 96"):
            sky.perez.relative_air_mass(1.7e308)
        with pytest.raises(sky.SceneError, match="overflows"):
            sky.perez.sky_brightness(1.7e308, 1.0)
        with pytest.raises(sky.UsageError, match="overflows"):
            sky.atmosphere.rayleigh_cross_section(1.5, 288.0, 1e-300)
    model = sky.FunctionSky(lambda z, a, w: 1.0 + 0.0 * z)  # memory without a value was returned for NaN
    for wavelength in (np.nan, [550.0, np.nan], np.inf):
        with pytest.raises(sky.SceneError, match="wavelength_nm must be finite"):
            model.radiance(0.5, 0.0, wavelength)


def test_nan_stays_nan_and_nothing_shines_below_the_horizon():
    sun = {"sun_zenith_deg": 40.0}
    models = (
        sky.UniformSky(),
        sky.OvercastSky(),
        sky.CIESky(type=12, **sun),
        sky.HarrisonCoombesSky(**sun, cloud_cover=0.5),
    )
    for model in (*models, sky.UniformSky(), sky.PerezSky(**sun, epsilon=5.0, delta=0.1)):
        assert np.isnan(model.radiance(np.nan, 0.0, 550.0))
        assert model.radiance(2.5, 0.0, 550.0) == 0.0
        assert model.radiance(np.pi / 2, 0.0, 550.0) > 0.0


def rough(a, b):
    changed = {"kind": "ggx", "param0": a, "param1": b, "quaternion": [0.7071, 0.0, 0.7071, 0.01]}
    return sky.lobes.WeightedLobe(**{**LOBE, **changed}, spectrum=[1e-8, 1e-8])


@pytest.mark.parametrize("roughness", [(3e38, 1.0), (1e-14, 1e14), (1e-45, 1e-45)])
def test_a_roughness_whose_photons_overflow_is_refused(roughness):
    with pytest.raises(sky.SceneError, match="from 1e-30 to 1e"):
        rough(*roughness)


@pytest.mark.parametrize("roughness", [(1e-30, 1e-30), (1e30, 1e30), (1e-10, 1e10), (1e20, 1.0)])
@pytest.mark.parametrize("as_stored", [np.float64, np.float32])
def test_photons_of_the_roughest_and_the_smoothest_lobes_travel_downward(roughness, as_stored):
    glow = sky.LobeSky(lobes=(rough(*np.array(roughness, as_stored).tolist()),))
    photons = sky.Scene(wavebands=[550.0], n_photons=1000, components=glow).source(seed=1).photons(0, 0, 1000)
    assert np.all(photons.uz <= 0)
    assert np.all(np.isfinite(photons.ux + photons.uy))


AIR = "inputs/atmosphere_sky/clear.atmo"


def solved(**changed):
    right = {"wavelength_nm": 500.0, "sun_zenith_deg": 30.0, "sky_zenith_deg": 0.0, "azimuth_from_sun_deg": 0.0}
    return sky.solve_atmosphere(AIR, **{**right, **changed})


NO_NUMBERS = {
    "None": None, "a None in a row": [0.1, None], "complex": 0.1 + 0j, "digits": "0.1", "text": ["0.1", "x"],
    "date": np.datetime64("2026-01-01"), "time of Python": datetime.datetime(2026, 1, 1),
    "duration": np.timedelta64(1, "s"), "durations": [np.timedelta64(1, "s"), 0.1],
    "record": np.zeros(1, dtype=[("zenith", "f8")]), "ragged": [[0.1], [0.1, 0.2]], "mapping": {},
    "too large": 10**400,
}  # fmt: skip
NUMBERS = {
    "uniform": lambda x: sky.UniformSky().radiance(x, 0.0, 550.0),
    "azimuth": lambda x: sky.OvercastSky().radiance(0.1, x, 550.0),
    "wavelength": lambda x: sky.HarrisonCoombesSky(sun_zenith_deg=40.0).radiance(0.1, 0.0, x),
    "lowered": lambda x: sky.FunctionSky(lambda z, a, w: 1.0 + 0.0 * z).lower(x),
    "travel": lambda x: sky.directions.travel_from_sky(x, 0.0),
    "convention": lambda x: sky.directions.to_enu_azimuth_deg(x, sky.directions.AzimuthConvention.NORTH_CLOCKWISE),
    "perez": lambda x: sky.perez.relative_radiance(x, 0.0, 0.5, [-1.0, -0.3, 5.0, -3.0, 0.4]),
    "clearness": lambda x: sky.perez.limited(x, 0.1),
    "pattern": lambda x: sky.RayleighPattern().stokes(x, 0.0, sun_zenith_rad=0.5),
    "scene": lambda x: sky.Scene(wavebands=[550.0], n_photons=1, components="uniform").radiance(0, x, 0.0),
    "patch": lambda x: GRID.patch_of(x, 0.0),
    "wavebands": sky.Wavebands,
    "wavelength of air": lambda x: solved(wavelength_nm=x),
    "direction in air": lambda x: solved(sky_zenith_deg=x),
    "orders": lambda x: solved(orders=x),
    "table": lambda x: sky.TabulatedSky(wavelength_nm=[550.0], values=x, grid=GRID),
}
ONE_NUMBER = {
    "sun over air": lambda x: solved(sun_zenith_deg=x).radiance.tolist(),
    "sun in radians": lambda x: sky.CIESky(type=12, sun_zenith_rad=x),
    "sun in degrees": lambda x: sky.PerezSky(sun_zenith_deg=x, epsilon=5.0, delta=0.1),
    "epsilon": lambda x: sky.PerezSky(sun_zenith_deg=40.0, epsilon=x, delta=0.1),
    "disc": lambda x: sky.DirectBeam(sun_zenith_deg=40.0, radius_deg=x),
    "cover": lambda x: sky.HarrisonCoombesSky(sun_zenith_deg=40.0, cloud_cover=x),
    "degree": lambda x: sky.RayleighPattern(max_degree=x),
    "Moon": lambda x: sky.atmosphere.Moon(zenith_deg=40.0, distance_m=x),
    "sun of points": lambda x: sky.RadianceField.from_points(
        [0.0, 50.0, 60.0], [0.0, 90.0, 180.0], UP[[0, 0, 0]], sun_zenith_deg=x, sun_azimuth_deg=0.0
    ),
    "sun of a table": lambda x: sky.read_radiance_csv(INPUTS / "measured" / "sky.csv", sun_zenith_rad=x),
    "own azimuth": lambda x: sky.directions.to_enu_azimuth_deg(1.0, sky.directions.AzimuthConvention.FROM_SUN, x),
}
#: Where None means that nothing is given.
DEFAULTS = {"epsilon", "disc", "own azimuth", "orders", "sun of points", "sun of a table"}


@pytest.mark.parametrize("name", sorted({*MASKED, *NUMBERS} - {"table", "orders"}))
def test_masked_numbers_are_refused(name):
    with pytest.raises(sky.SceneError, match="has masked values; leave these entries out"):
        MASKED[name]() if name in MASKED else NUMBERS[name](HIDDEN)


@pytest.mark.parametrize("what", NO_NUMBERS)
@pytest.mark.parametrize("name", NUMBERS | ONE_NUMBER)
def test_what_is_no_number_is_one_sentence(name, what):
    if what == "None" and name in DEFAULTS:
        pytest.skip("None is allowed")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(sky.AomcSkyError, match=r"must be|give s"):
            (NUMBERS | ONE_NUMBER)[name](NO_NUMBERS[what])


@pytest.mark.parametrize("value", [True, [0.5], np.array([0.5, 0.6])])
@pytest.mark.parametrize("name", ONE_NUMBER)
def test_one_number_is_no_array_and_no_truth(name, value):
    with pytest.raises(sky.UsageError, match="must be one number, got"):
        ONE_NUMBER[name](value)


@pytest.mark.parametrize("value", [fractions.Fraction(1, 2), np.float32(0.5), np.array(0.5), np.ma.masked_array(0.5)])
@pytest.mark.parametrize("name", sorted(set(ONE_NUMBER) - {"epsilon", "Moon"}))
def test_numbers_of_other_libraries_are_those_of_python(name, value):
    assert ONE_NUMBER[name](value) == ONE_NUMBER[name](0.5)


@pytest.mark.parametrize("direction", [0.5, [0.0, -1.0], [[0.0, 0.0, 0.0]], [0.0, 0.0, np.inf], []])
def test_a_travel_direction_is_three_finite_numbers(direction):
    with pytest.raises(sky.UsageError, match="direction must be"):
        sky.directions.sky_from_travel(direction)


@pytest.mark.parametrize("coefficients", [0.5, [1.0, -1.0], np.ones((5, 2))])
def test_coefficients_are_five(coefficients):
    for function in (sky.perez.horizontal_integral, lambda c, s: sky.perez.relative_radiance(0.5, 0.0, s, c)):
        with pytest.raises(sky.SceneError, match="five numbers a, b, c, d, e"):
            function(coefficients, 0.5)


@pytest.mark.parametrize("grid", [5, [[0.0, 90.0]], "regular"])
def test_a_grid_is_a_grid(grid):
    for model in (
        lambda: sky.PerezSky(sun_zenith_deg=40.0, epsilon=5.0, delta=0.1, grid=grid),
        lambda: sky.FunctionSky(lambda z, a, w: 1.0 + 0.0 * z, grid=grid).lower(550.0),
        lambda: sky.OvercastSky(grid=grid).lower(550.0),
        lambda: sky.TabulatedSky(wavelength_nm=[550.0], values=[[1.0]], grid=grid),
        lambda: sky.RadianceField.from_points([0.0, 50.0, 60.0], [0.0, 90.0, 180.0], [1.0, 1.0, 1.0], grid=grid),
    ):
        with pytest.raises(sky.UsageError, match=r"expected a PatchGrid, got .*; write grid=sky.PatchGrid"):
            model()


def test_a_picture_takes_one_wavelength_and_two_angles():
    pytest.importorskip("matplotlib")
    with pytest.raises(sky.UsageError, match="wavelength_nm must be one number"):
        sky.plot(sky.OvercastSky(), wavelength_nm=[440.0, 550.0])
    for sun in (40.0, [40.0], [[40.0, 0.0]]):
        with pytest.raises(sky.UsageError, match="sun_deg must be two numbers, zenith angle and azimuth, got"):
            sky.plot(sky.OvercastSky(), sun_deg=sun)
    with pytest.raises(sky.SceneError, match="masked"):
        sky.plot(np.ma.masked_array(np.ones((2, 4)), mask=np.eye(2, 4)))
