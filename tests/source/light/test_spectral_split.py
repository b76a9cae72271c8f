"""Beam and sky of each waveband by the spectra of SPCTRL2: what stays as given, what physics asks, what is refused."""

import shutil

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.errors import ModelLimitWarning, SceneError
from aomc_sky.formats.sky_toml.sections import PerezSection
from aomc_sky.source.light.brightness import Broadband
from aomc_sky.source.light.place import Sun
from aomc_sky.source.light.spectral_split import LARGEST_TURBIDITY, REFERENCE, spectral_split
from tests.support.scenes import copy_scene
from tests.support.shared import INPUTS

pvlib = pytest.importorskip("pvlib")

VISIBLE = np.linspace(400.0, 700.0, 61)
NARROW = [(850.0, 95.0, 32.4), (900.0, 95.0, 32.4), (750.0, 90.0, 60.0), (600.0, 200.0, 45.0), (400.0, 60.0, 80.0)]
"""dni, dhi and the sun's zenith angle, of skies that SPCTRL2 has a turbidity for."""
SPECTRL2 = {"spectrum": "spectrl2"}
WEATHER = {"dni": 850.0, "dhi": 95.0}


def split(dni, dhi, zenith_deg, wavelength_nm=VISIBLE):
    return spectral_split(dni, dhi, Sun(zenith_deg=zenith_deg, azimuth_deg=0.0), np.asarray(wavelength_nm, np.float64))


def model(zenith_deg, turbidity):
    """SPCTRL2 called by itself, on another day and with pvlib's air mass."""
    air = {"precipitable_water": 1.416, "ozone": 0.344, "aerosol_turbidity_500nm": turbidity, "dayofyear": 200}
    ground = {"surface_tilt": 0, "ground_albedo": 0.06, "surface_pressure": 101325.0}
    zenith, airmass = np.array([zenith_deg]), pvlib.atmosphere.get_relative_airmass(zenith_deg)
    found = pvlib.spectrum.spectrl2(apparent_zenith=zenith, aoi=zenith, relative_airmass=airmass, **ground, **air)
    return np.ravel(found["wavelength"]), found["dni"][:, 0], found["dhi"][:, 0]


def integral(wavelength_nm, values):
    return float(np.sum(np.diff(wavelength_nm) * (values[1:] + values[:-1])) / 2)


@pytest.mark.parametrize(("dni", "dhi", "zenith_deg"), [*NARROW, (300.0, 400.0, 30.0), (0.0, 120.0, 50.0)])
@pytest.mark.filterwarnings("ignore:spectrum 'spectrl2':aomc_sky.ModelLimitWarning")
def test_the_broadband_irradiances_stay_what_was_given(dni, dhi, zenith_deg):
    wavelength, _, _ = model(zenith_deg, 0.1)
    found = split(dni, dhi, zenith_deg, wavelength)
    # fractions have 9 decimals and irradiances 9 digits
    cosine = np.cos(np.radians(zenith_deg))
    assert integral(wavelength, found.direct_irradiance) == pytest.approx(dni * cosine, rel=1e-8, abs=1e-6)
    assert integral(wavelength, found.diffuse_irradiance) == pytest.approx(dhi, rel=1e-8, abs=1e-6)


@pytest.mark.parametrize(("dni", "dhi", "zenith_deg"), NARROW)
def test_the_turbidity_is_the_one_whose_spectra_have_the_ratio(dni, dhi, zenith_deg):
    found = split(dni, dhi, zenith_deg)
    wavelength, normal, diffuse = model(zenith_deg, found.turbidity)
    # 6 decimals of the turbidity; the ratio rises by at most a factor of 1e1 over 0.1
    assert integral(wavelength, diffuse) / integral(wavelength, normal) == pytest.approx(dhi / dni, rel=1e-4)
    share = np.interp(VISIBLE, wavelength, diffuse) / integral(wavelength, diffuse)
    np.testing.assert_allclose(found.diffuse_irradiance, dhi * share, rtol=1e-7)
    assert 0.0 < found.turbidity < LARGEST_TURBIDITY


@pytest.mark.parametrize(
    ("dni", "dhi", "zenith_deg"), [pytest.param(900.0, 95.0, 32.4, marks=pytest.mark.slow), (800.0, 75.0, 60.0)]
)
def test_the_diffuse_fraction_is_that_of_a_solved_atmosphere(dni, dhi, zenith_deg):
    # light scattered by molecules, sea salt of optical depth 0.08 and ozone, by solution; 10 % of molecules and
    # aerosol are what two models differ by, 22 % in the red, where the aerosol is all
    bands = [400.0, 500.0, 560.0, 700.0]
    sun = {"sun_zenith_deg": zenith_deg, "sky_zenith_deg": [0.0], "azimuth_from_sun_deg": [0.0]}
    air = sky.solve_atmosphere(INPUTS / "atmosphere" / "clear_marine.atmo", wavelength_nm=bands, **sun)
    solved = air.diffuse_irradiance / (air.diffuse_irradiance + air.direct_irradiance)
    found = split(dni, dhi, zenith_deg, np.array(bands))
    assert found.turbidity == pytest.approx(0.1, abs=0.01)
    ratio = (1.0 - found.direct_fraction) / solved
    assert np.all(np.abs(ratio[:3] - 1.0) < 0.10)
    assert np.all(np.abs(ratio - 1.0) < 0.23)
    flat = dhi / (dhi + dni * np.cos(np.radians(zenith_deg)))
    assert np.abs(flat / solved - 1.0).max() > 0.5  # the broadband fraction does not pass


@pytest.mark.parametrize(("dni", "dhi", "zenith_deg"), NARROW)
def test_the_diffuse_fraction_falls_with_wavelength_and_dni_and_rises_with_dhi(dni, dhi, zenith_deg):
    diffuse = 1.0 - split(dni, dhi, zenith_deg, np.linspace(310.0, 1800.0, 500)).direct_fraction
    assert np.all(np.diff(diffuse) < 0)
    at = np.array([412.0, 550.0, 670.0])
    base = split(dni, dhi, zenith_deg, at).direct_fraction
    assert np.all(split(dni, dhi * 1.05, zenith_deg, at).direct_fraction < base)
    assert np.all(split(dni * 1.05, dhi, zenith_deg, at).direct_fraction > base)


def test_without_beam_or_without_sky_one_is_all():
    overcast, dark = split(0.0, 120.0, 40.0), split(900.0, 0.0, 40.0)
    assert not overcast.direct_fraction.any()
    assert not overcast.direct_irradiance.any()
    assert np.all(overcast.diffuse_irradiance > 0)
    assert np.all(dark.direct_fraction == 1.0)
    assert not dark.diffuse_irradiance.any()
    assert (overcast.turbidity, overcast.cloud) == (0.5, 1.0)
    assert (dark.turbidity, dark.cloud) == (REFERENCE.aod_500nm, 0.0)


def test_what_is_said_of_clear_skies_of_clouds_and_of_no_light():
    with pytest.warns(ModelLimitWarning, match="less than a cloudless sky has"):
        found = split(1000.0, 20.0, 30.0)
    assert (found.turbidity, found.cloud) == (0.0, 0.0)
    assert str(split(0.0, 300.0, 50.0)).endswith("turbidity 0.5, 100 % of the diffuse light as white as a cloud's")
    assert str(split(850.0, 95.0, 50.0)).count("cloud") == 0
    dark = Broadband(amounts=PerezSection(epsilon=3.0, delta=0.0, origin="options"), spectrum="spectrl2")
    with pytest.raises(SceneError, match=r"epsilon 3 and Delta 0 \(options\) leave no light at all"):
        dark.in_bands(Sun(zenith_deg=30.0, azimuth_deg=0.0), VISIBLE, None)


OCEAN_NM = np.array([412.0, 443.0, 490.0, 555.0, 670.0])


def test_light_below_a_cloud_is_white():
    """PythonicDISORT, optical depths 10 to 40, suns at 30 to 70 degrees (bench/cloud_spectrum.py); 0.3.0 had 2.94."""
    light = split(0.0, 300.0, 50.0, OCEAN_NM).diffuse_irradiance
    found = light[:-1] / light[-1]
    np.testing.assert_allclose(found, [1.164, 1.285, 1.277, 1.217], rtol=1e-3)
    least, most = np.array([1.053, 1.194, 1.222, 1.176]), np.array([1.156, 1.287, 1.279, 1.215])
    assert np.all((0.99 * least < found) & (found < 1.02 * most))


def test_from_haze_to_cloud_nothing_jumps():
    """A little beam changes little; the share of cloud rises from 0 where turbidity 0.5 is reached."""

    def blue(dni):
        found = split(dni, 300.0, 50.0, OCEAN_NM)
        return float(found.diffuse_irradiance[0] / found.diffuse_irradiance[-1]), found.cloud

    at = np.linspace(0.0, 1000.0, 401)
    ratios, clouds = np.array([blue(dni) for dni in at.tolist()]).T
    assert np.abs(np.diff(ratios)).max() < 0.03
    assert np.all(np.diff(clouds) <= 0)
    assert clouds[0] == 1.0
    assert clouds[-1] == 0.0
    assert abs(blue(0.1)[0] / blue(0.0)[0] - 1) < 1e-3


@pytest.mark.parametrize("wavelength_nm", [299.9, 4000.0001])
def test_a_waveband_outside_the_spectra_is_refused(wavelength_nm):
    with pytest.raises(SceneError, match=rf"waveband 2 at {wavelength_nm!r} nm is outside .* 300 to 4000 nm"):
        split(850.0, 95.0, 30.0, np.array([550.0, wavelength_nm]))


# In a scene


@pytest.fixture
def amc(tmp_path):
    """The scene perez_sky without difcol.inp; its sky.toml says dni 850, dhi 95 and the sun."""
    amc = copy_scene("perez_sky", tmp_path)
    (amc.parent / "difcol.inp").unlink()
    return amc


def test_a_scene_has_the_split_its_photons_and_its_units(amc):
    scene = sky.read_scene(amc, perez=SPECTRL2)
    bands = scene.wavebands.wavelength_nm
    found = split(850.0, 95.0, 32.4, bands)
    source = scene.source()
    direct = source.counts[:, 0] / source.counts.sum(axis=1)
    np.testing.assert_allclose(direct, found.direct_fraction, rtol=0, atol=1 / scene.n_photons.min())
    flat = sky.read_scene(amc, perez={"spectrum": "flat"})
    np.testing.assert_array_equal(scene.n_photons, flat.n_photons)  # the iterations of amc.inp in every band
    assert flat.irradiance is None
    expected = np.column_stack([found.direct_irradiance, found.diffuse_irradiance])
    np.testing.assert_allclose(scene.irradiance.of_component, expected, rtol=1e-12)
    assert scene.options["spectrum"]["turbidity_500nm"] == found.turbidity
    assert "spectra of SPCTRL2 at turbidity 0.112" in scene.notes[0]


def test_one_fraction_for_all_wavebands_is_warned_of_unless_it_is_asked_for(amc):
    with pytest.warns(sky.InputWarning, match="every waveband has the broadband direct fraction 0.883"):
        warned = sky.read_scene(amc)
    asked = sky.read_scene(amc, perez={"spectrum": "flat"})
    beam = sky.read_scene(amc, perez={"dni": 900.0, "dhi": 0.0})
    cloud = sky.read_scene(amc, perez={"dni": 0.0, "dhi": 100.0})
    np.testing.assert_array_equal(warned.source().counts, asked.source().counts)
    assert [c.name for c in beam.components] == ["direct"]
    assert [c.name for c in cloud.components] == ["perez"]


def test_epsilon_and_delta_have_irradiances_too(amc):
    one = sky.read_scene(amc, perez=WEATHER | SPECTRL2)
    shape = {name: one.options["perez"][name] for name in ("epsilon", "delta")}
    two = sky.read_scene(amc, perez=shape | SPECTRL2)
    np.testing.assert_allclose(two.irradiance.of_component, one.irradiance.of_component, rtol=1e-8)


def test_light_of_the_night_adds_to_it_and_irradiances_of_sky_toml_win(amc):
    pytest.importorskip("h5py")
    toml = amc.parent / "sky.toml"
    shutil.copy(INPUTS / "night_sky" / "night.h5", amc.parent)
    text = toml.read_text()
    toml.write_text(text + '\n[[background]]\nfile = "night.h5"\ntime = 2026-02-14T21:30:00Z\n')
    scene = sky.read_scene(amc, perez=SPECTRL2)
    found = split(850.0, 95.0, 32.4, scene.wavebands.wavelength_nm)
    np.testing.assert_allclose(scene.irradiance.of_component[:, 0], found.direct_irradiance, rtol=1e-12)
    assert scene.irradiance.of_component.shape[1] > 2
    toml.write_text(text + "\n[sky]\ndiffuse_irradiance = [0.1, 0.1, 0.1, 0.1]\n")
    given = sky.read_scene(amc, perez=SPECTRL2)
    np.testing.assert_allclose(given.irradiance.of_component[:, 1], 0.1, rtol=1e-12)
    beam = 0.1 * found.direct_fraction / (1.0 - found.direct_fraction)
    np.testing.assert_allclose(given.irradiance.of_component[:, 0], beam, rtol=1e-9)
    toml.write_text(text + "\n[sky]\ndiffuse_irradiance = [0.1, 0.1, 0.1, 0.25]\n")
    with pytest.raises(SceneError, match=r"beam of waveband 4 at 650 nm has 2\.5\d .* which has 1\.5\d outside"):
        sky.read_scene(amc, perez=SPECTRL2)


@pytest.mark.parametrize("name", ["aod_500nm", "water_cm", "ozone_cm", "aerosol"])
def test_only_the_pressure_of_a_clear_sky_may_be_left_open(name):
    assert sky.ClearSky(pressure_hPa=None) == sky.ClearSky()
    with pytest.raises(sky.UsageError, match=name):
        sky.ClearSky(**{name: None})
