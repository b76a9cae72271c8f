"""Where is the sun, how bright are beam and sky, which sky: every answer at every entrance, beside values of pvlib."""

import itertools
import shutil
import warnings

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.formats.aomc.amc import LightSource
from aomc_sky.skies.direct_beam import SOLAR_BOUND, solar_irradiance
from tests.support.scenes import change_config, copy_scene
from tests.support.shared import INPUTS

pvlib = pytest.importorskip("pvlib")
scipy_optimize = pytest.importorskip("scipy.optimize")

NM = [443.0, 555.0]
ZENITH = 40.0
COSINE = float(np.cos(np.radians(ZENITH)))
SUN = {"sun_zenith_deg": ZENITH, "sun_azimuth_deg": 30.0}
OWN = np.array([0.11, 0.12])
"""Irradiance of the sky in absolute units. [W m-2 nm-1]"""


def spectra(turbidity, zenith_deg=ZENITH, pressure=101_325.0, water=1.416, ozone=0.344):
    """SPCTRL2 of pvlib at the sun's mean distance: wavelengths, direct normal and diffuse horizontal irradiance."""
    zenith, day = np.array([zenith_deg]), 80
    air_mass = float(pvlib.atmosphere.get_relative_airmass(zenith_deg, model="kastenyoung1989"))
    found = pvlib.spectrum.spectrl2(
        apparent_zenith=zenith, aoi=zenith, surface_tilt=0.0, ground_albedo=0.06, surface_pressure=pressure,
        relative_airmass=air_mass, precipitable_water=water, ozone=ozone, aerosol_turbidity_500nm=turbidity,
        dayofyear=day,
    )  # fmt: skip
    factor = float(pvlib.irradiance.get_extra_radiation(day, solar_constant=1.0, method="spencer"))
    return np.ravel(found["wavelength"]), found["dni"][:, 0] / factor, found["dhi"][:, 0] / factor


def of_irradiances(dni, dhi, nm, zenith_deg=ZENITH):
    """Beam and sky of wavelengths: spectra of the turbidity that has this ratio, scaled to dni and dhi."""

    def excess(turbidity):
        grid, normal, diffuse = spectra(turbidity, zenith_deg)
        return np.trapezoid(diffuse, grid) / np.trapezoid(normal, grid) - dhi / dni

    turbidity = 0.0 if excess(0.0) > 0 else scipy_optimize.brentq(excess, 0.0, 0.5, xtol=1e-10)
    grid, normal, diffuse = spectra(turbidity, zenith_deg)
    cosine = np.cos(np.radians(zenith_deg))
    beam = np.interp(nm, grid, normal) * dni * cosine / np.trapezoid(normal, grid)
    return beam, np.interp(nm, grid, diffuse) * dhi / np.trapezoid(diffuse, grid)


def of_clear_sky(nm, zenith_deg=ZENITH, pressure=101_325.0):
    grid, normal, diffuse = spectra(0.1, zenith_deg, pressure, water=1.4, ozone=0.3)
    return np.interp(nm, grid, normal) * np.cos(np.radians(zenith_deg)), np.interp(nm, grid, diffuse)


def light(scene):
    """Irradiance of the beam and of the sky for each band, or None; and the share of the beam."""
    names = [component.name == "direct" for component in scene.components]
    strength = np.array([component.strength[scene.row_of_band] for component in scene.components])
    share = strength[names].sum(axis=0) / strength.sum(axis=0)
    if scene.irradiance is None:
        return None, None, share
    known = scene.irradiance.of_component
    return known[:, names].sum(axis=1), known[:, [not one for one in names]].sum(axis=1), share


@pytest.fixture(autouse=True)
def _levels_of_the_test():
    """The sky in absolute units is not that of dhi, which is warned of and tested below."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "the diffuse irradiance of the sky", sky.InputWarning)
        yield


# The table of what went wrong in version 0.4.


def scene_of_csv(zenith_deg, nm, **light_of_sun):
    field = sky.read_radiance_csv(INPUTS / "measured" / "sky.csv", sun_zenith_deg=zenith_deg)
    place = {"sun_zenith_deg": zenith_deg, "sun_azimuth_deg": 135.0}
    return sky.weather_scene(wavebands=nm, **place, sky=field, **light_of_sun), field


@pytest.mark.parametrize("spectrum", [None, "spectrl2"])
@pytest.mark.parametrize(("zenith", "nm", "dni", "dhi"), [(35.0, 443.0, 850, 60), (40.0, 440.0, 900, 20)])
@pytest.mark.filterwarnings("ignore:spectrum 'spectrl2'. dhi:aomc_sky.ModelLimitWarning")
def test_a_measured_sky_keeps_its_light_and_the_beam_is_dni_times_its_spectrum(spectrum, zenith, nm, dni, dhi):
    scene, field = scene_of_csv(zenith, [nm], dni=dni, dhi=dhi, spectrum=spectrum)
    beam, diffuse, share = light(scene)
    np.testing.assert_array_equal(diffuse, field.irradiance(np.array([nm])))
    np.testing.assert_allclose(beam, of_irradiances(dni, dhi, [nm], zenith)[0], rtol=2e-5)  # 6 digits of a turbidity
    np.testing.assert_allclose(share, beam / (beam + diffuse), rtol=1e-12)


def test_the_pressure_of_a_cloudless_sky_is_that_of_the_altitude():
    """At 3000 m a sky of sea level would be 14 % brighter at 412 nm with this sun."""
    for how in ({"sun_zenith_deg": ZENITH}, {"time": "2026-03-21T12:00Z", "latitude_deg": 0.0, "longitude_deg": 0.0}):
        high = sky.weather_scene(wavebands=[412.0], **how, altitude_m=3000.0, sky="uniform", spectrum="spectrl2")
        zenith = high.options["sun"]["zenith_deg"]
        low = sky.weather_scene(wavebands=[412.0], **how, sky="uniform", spectrum="spectrl2")
        pressure = float(pvlib.atmosphere.alt2pres(3000.0))
        expected = of_clear_sky([412.0], zenith, pressure)[1] / of_clear_sky([412.0], zenith)[1]
        assert light(high)[1] / light(low)[1] == pytest.approx(expected, rel=1e-5)  # the refraction of the altitude
        assert 0.8 < expected < 0.9
    given = {"pressure_hPa": 1013.25}
    same = sky.weather_scene(
        wavebands=[412.0], sun_zenith_deg=ZENITH, altitude_m=3000.0, sky="uniform", spectrum="spectrl2", clear_sky=given
    )
    assert light(same)[1] == pytest.approx(of_clear_sky([412.0])[1], rel=1e-8)


def test_the_caller_comes_first_and_then_the_finest_file(tmp_path):
    amc = copy_scene("perez_sky", tmp_path)
    flat = {"dni": 500.0, "dhi": 250.0, "spectrum": "flat"}
    of_caller = 500 * np.cos(np.radians(32.4)) / (500 * np.cos(np.radians(32.4)) + 250)
    difcol = [0.72, 0.94, 1.0, 0.88]
    toml = (amc.parent / "sky.toml").read_text()
    both = "[sky]\ndirect_irradiance = [0.8, 0.9, 0.7, 0.5]\ndiffuse_irradiance = [0.4, 0.3, 0.2, 0.5]\n"
    of_sky = [2 / 3, 3 / 4, 7 / 9, 1 / 2]
    (amc.parent / "difcol.inp").write_text("4\n" + "".join(f"{share} 0.9\n" for share in difcol))
    for files, expected in (("", difcol), (both, of_sky)):
        (amc.parent / "sky.toml").write_text(toml + files)
        of_files = sky.read_scene(amc)
        np.testing.assert_allclose(light(of_files)[2], expected, rtol=1e-12)
        assert any("difcol.inp: its direct fractions" in note for note in of_files.notes) == (files == both)
        of_options = sky.read_scene(amc, perez=flat)
        np.testing.assert_allclose(light(of_options)[2], of_caller, rtol=1e-12)
        for scene in (of_files, of_options):  # the intensities of difcol.inp stay
            assert scene.n_photons.tolist() == [450_000] * 4
        said = " ".join(of_options.notes)
        assert "difcol.inp: its direct fractions are not used: the light is that of" in said
        assert ("direct_irradiance and diffuse_irradiance are not used" in said) == (files == both)
    (amc.parent / "difcol.inp").unlink()
    (amc.parent / "sky.toml").write_text(toml.replace("[sun]", 'spectrum = "flat"\n[sun]'))
    cosine = np.cos(np.radians(32.4))
    np.testing.assert_allclose(light(sky.read_scene(amc))[2], 850 * cosine / (850 * cosine + 95), rtol=1e-12)
    scene = sky.read_scene(amc, perez={"spectrum": "spectrl2"})
    expected = of_irradiances(850.0, 95.0, scene.wavebands.wavelength_nm, 32.4)[0]
    np.testing.assert_allclose(light(scene)[0], expected, rtol=2e-5)


@pytest.mark.parametrize("place", [{}, {"time": "2026-03-21T12:00Z", "latitude_deg": 0.0, "longitude_deg": 0.0}])
def test_a_model_says_where_its_sun_is_and_another_one_is_an_error(place, tmp_path):
    model = sky.HarrisonCoombesSky(sun_zenith_deg=30.0, sun_azimuth_deg=80.0)
    amounts = {"dni": 700.0, "dhi": 120.0, "wavebands": NM, "sky": model}
    of_model = sky.weather_scene(**amounts).options["sun"]
    assert (of_model["zenith_deg"], of_model["azimuth_deg"]) == pytest.approx((30.0, 80.0))
    other = place or {"sun_zenith_deg": 60.0, "sun_azimuth_deg": 80.0}
    with pytest.raises(
        sky.UsageError, match=r"where is the sun[?] the model .* at a zenith angle of 30 and an azimuth of 80"
    ):
        sky.weather_scene(**amounts, **other)
    with pytest.raises(sky.UsageError, match=r"where is the sun[?] the model"):  # one angle says it, too
        sky.weather_scene(**amounts, sun_azimuth_deg=20.0)
    sky.weather_scene(**amounts, sun_zenith_deg=30.2, sun_azimuth_deg=80.0)  # within the disc
    alone = sky.weather_scene(wavebands=NM, sky=model, diffuse_only=True)
    assert [one.name for one in alone.components] == ["harrison-coombes"]
    amc = copy_scene("sun_and_sky", tmp_path)
    assert sky.read_scene(amc, sky=model).options["sun"]["zenith_deg"] == pytest.approx(30.0)  # before amc.inp


def test_names_of_others_in_braces_stay_as_they_are():
    class Braces:
        name = "a{b}{dhi}c{"

        def radiance(self, zenith, azimuth, nm):
            return 1.0 + 0.0 * zenith

    with pytest.warns(sky.InputWarning, match=r"the direct beam .* beside the model 'a\{b\}"):
        sky.weather_scene(wavebands=NM, sun_zenith_deg=30.0, sky=Braces())
    with pytest.raises(sky.UsageError, match=r"\{x\}"):
        sky.weather_scene(wavebands=NM, sun_zenith_deg=30.0, sky="perez", sky_options={"{x}": 1})


def test_every_input_belongs_to_one_question():
    """An input of no question would be accepted without use."""
    from aomc_sky.options import INPUTS as ROWS
    from aomc_sky.source.light import unused

    questions = [*unused._PLACE, "disc", "diffuse_only", *unused._LIGHT, *unused._SKY]
    assert sorted(questions) == sorted(set(ROWS) - {"sky", "sky_options"})


# No beam is brighter than the sun.


def test_the_solar_spectrum_is_that_of_astm_g173():
    spectrum = pvlib.spectrum.get_reference_spectra(standard="ASTM G173-03")["extraterrestrial"]
    fine = np.linspace(-5.0, 5.0, 201)
    every = np.arange(300.0, 4001.0, 1.0)
    every_mean = [np.interp(one + fine, spectrum.index.to_numpy(float), spectrum.to_numpy()).mean() for one in every]
    np.testing.assert_allclose(solar_irradiance(every), every_mean, rtol=0.0501)
    assert np.all(np.isinf(solar_irradiance(np.array([299.9, 4000.1]))))


@pytest.mark.parametrize("too_much", [False, True])
def test_a_beam_brighter_than_the_sun_is_an_error(tmp_path, too_much):
    """Of a sky in relative units: [sky] says the irradiances."""
    amc = copy_scene("sun_and_sky", tmp_path)
    nm = np.array([400.0, 487.5, 575.0, 662.5, 700.0])
    most = float(solar_irradiance(nm[:1])[0]) * SOLAR_BOUND * np.cos(np.radians(40.0))
    first = most * (1.001 if too_much else 0.999)
    (amc.parent / "sky.toml").write_text(
        f"[sky]\ndirect_irradiance = [{first}, 0.9, 0.9, 0.8, 0.7]\ndiffuse_irradiance = [0.3, 0.3, 0.2, 0.2, 0.1]\n"
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sky.InputWarning)  # of the clearness
        if not too_much:
            assert light(sky.read_scene(amc))[0][0] == pytest.approx(first)
            return
        with pytest.raises(sky.SceneError, match=r"the beam of waveband 1 at 400 nm .* outside the atmosphere"):
            sky.read_scene(amc)


def test_a_level_that_is_not_that_of_dhi_gets_a_warning():
    beam, diffuse = of_irradiances(800.0, 100.0, NM)
    for factor in (0.75, 0.85, 1.15, 1.25):
        model = sky.UniformSky(irradiance_W_m2_nm=(factor * diffuse).tolist())
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            scene = sky.weather_scene(wavebands=NM, **SUN, dni=800, dhi=100, sky=model)
        said = [one for one in caught if "the diffuse irradiance of the sky" in str(one.message)]
        assert len(said) == (abs(factor - 1) > 0.2)
        np.testing.assert_allclose(light(scene)[0], beam, rtol=2e-5)


def test_a_sky_in_absolute_units_is_no_share(tmp_path):
    """A level in sky.toml let the broadband share in again, and solid angles lost the level."""
    amc = amc_with(tmp_path, "level", by_file=False)
    with pytest.raises(sky.UsageError, match="one share in all wavebands"):
        sky.read_scene(amc, sky=model_of("absolute"), perez=SAID["flat"])
    field = xarray_field(tmp_path)
    with pytest.raises(sky.UsageError, match=r"solid-angle.* is for a sky in relative units"):
        sky.read_scene(amc_with(tmp_path / "field", "difcol", by_file=False, table=field), weighting="solid-angle")


def test_the_sky_of_dhi_0_gets_a_warning():
    with pytest.warns(sky.InputWarning, match="is not 0, as is that of dni 800 and dhi 0"):
        sky.weather_scene(wavebands=NM, **SUN, dni=800, dhi=0, sky=model_of("absolute"))


def test_clear_mountain_air_has_a_warning_and_no_error():
    """The South Pole in December: the spectrum of moist air at the sea is too bright at 865 nm."""
    place = {"time": "2026-12-21T12:00Z", "latitude_deg": -89.98, "longitude_deg": 0.0, "altitude_m": 2835.0}
    with pytest.warns(sky.ModelLimitWarning) as caught:
        scene = sky.weather_scene(wavebands=[443.0, 865.0], **place, dni=1080, dhi=35, spectrum="spectrl2")
    assert "at 865 nm has 1.15 W m-2 nm-1" in " ".join(str(one.message) for one in caught)
    assert [one.name for one in scene.components] == ["direct", "perez"]


def test_dark_wavebands_that_nobody_wants_are_no_error(tmp_path):
    amc = amc_with(tmp_path, "nothing", by_file=False)
    toml = amc.parent / "sky.toml"
    toml.write_text(toml.read_text() + "[sky]\ndirect_irradiance = [0.5, 0]\ndiffuse_irradiance = [0.5, 0]\n")
    assert light(sky.read_scene(amc, sky="uniform", wavebands=[1]))[2][0] == 0.5
    with pytest.raises(sky.SceneError, match="waveband 2 at 555 nm has no light, 0 W m-2 nm-1"):
        sky.read_scene(amc, sky="uniform")


def test_a_measured_sky_says_where_its_sun_is_at_every_entrance():
    field = sky.read_radiance_csv(INPUTS / "measured" / "sky.csv")
    sun = sky.weather_scene(wavebands=[443.0], sky=field, dni=850, dhi=95).options["sun"]
    assert (sun["zenith_deg"], sun["azimuth_deg"]) == (40.0, pytest.approx(135.0))


def test_a_model_in_place_of_the_sun_of_files_leaves_a_note():
    scene = sky.read_scene(INPUTS / "perez_sky", sky=sky.HarrisonCoombesSky(sun_zenith_deg=60, sun_azimuth_deg=0))
    note = next(note for note in scene.notes if "its sun at" in note)
    assert note.startswith("sky.toml: its sun at a zenith angle of 32.4 and an azimuth of 121.25 degrees is not used")
    assert note.endswith("the sun is at 60.0000 and 0.0000 (the model 'HarrisonCoombesSky')")


# The matrix of answers, skies and entrances.

FLAT = 800 * COSINE / (800 * COSINE + 120)
DIFCOL = np.array([0.6, 0.7])
DIRECT, DIFFUSE = np.array([0.7, 0.8]), np.array([0.3, 0.25])
SAID = {
    "nothing": {},
    "flat": {"dni": 800.0, "dhi": 120.0, "spectrum": "flat"},
    "spectra": {"dni": 800.0, "dhi": 120.0, "spectrum": "spectrl2"},
    "amounts": {"dni": 800.0, "dhi": 120.0},
    "cloudless": {"spectrum": "spectrl2"},
    "difcol": {},
    "per band": {},
    "level": {"dni": 800.0, "dhi": 120.0, "spectrum": "spectrl2"},
}
OF_FILES = ("difcol", "per band", "level")
"""Answers that files alone can give."""


def expected_light(answer, *, is_absolute):
    """Beam, sky and share of the beam, by light.md; None where it is an error."""
    beam, diffuse = of_irradiances(800.0, 120.0, NM)
    own = OWN if is_absolute else None
    if answer == "nothing":
        return (np.zeros(2), own, np.zeros(2)) if is_absolute else (None, None, np.zeros(2))
    if answer == "flat" or (answer == "amounts" and not is_absolute):
        return None if is_absolute else (None, None, np.full(2, FLAT))
    if answer in ("spectra", "amounts"):
        diffuse = OWN if is_absolute else diffuse
        return beam, diffuse, beam / (beam + diffuse)
    if answer == "cloudless":
        beam, diffuse = of_clear_sky(NM)
        diffuse = OWN if is_absolute else diffuse
        return beam, diffuse, beam / (beam + diffuse)
    if answer == "difcol":
        return (OWN * DIFCOL / (1 - DIFCOL), OWN, DIFCOL) if is_absolute else (None, None, DIFCOL)
    if answer == "per band":
        return DIRECT, DIFFUSE, DIRECT / (DIRECT + DIFFUSE)
    level, share = np.full(2, 0.1), beam / (beam + diffuse)
    return (beam, level, beam / (beam + level)) if is_absolute else (level * share / (1 - share), level, share)


def model_of(kind):
    return sky.UniformSky(irradiance_W_m2_nm=OWN.tolist()) if kind == "absolute" else "uniform"


def xarray_field(folder):
    """A field of radiances in absolute units."""
    from tests.support.fields import field_of

    zenith, azimuth = np.arange(5.0, 90.0, 10.0), np.arange(15.0, 360.0, 30.0)
    field = field_of((1 + np.cos(np.radians(zenith)))[:, None] * np.ones((1, azimuth.size)), zenith, azimuth)
    field.attrs["units"] = "10 mW m-2 nm-1 sr-1"
    field.to_netcdf(folder / "field.nc", engine="h5netcdf")
    return folder / "field.nc"


def amc_with(folder, answer, *, by_file, table=None):
    """A scene of two bands whose files give the answer."""
    amc = copy_scene("sun_and_sky", folder)
    (amc.parent / "lambbot.inp").write_text("2\n443.0 0.05 0.0\n555.0 0.05 0.0\n")
    change_config(amc, n_wavebands=2, light_source=LightSource.MODEL)
    (amc.parent / "difcol.inp").unlink()
    keys = {name: f'"{value}"' if name == "spectrum" else value for name, value in SAID[answer].items()}
    lines = ["[sun]", f"zenith_deg = {ZENITH}", "azimuth_deg = 30"]
    lines += ["[perez]", *(f"{name} = {value}" for name, value in keys.items())] if by_file and keys else []
    if answer == "difcol":
        (amc.parent / "difcol.inp").write_text("2\n0.6 1\n0.7 1\n")
    if answer == "per band":
        lines += ["[sky]", f"direct_irradiance = {DIRECT.tolist()}", f"diffuse_irradiance = {DIFFUSE.tolist()}"]
    if table is not None:
        shutil.copy(table, amc.parent)
        lines += ["[sky]", f'table = "{table.name}"']
    if answer == "level":
        lines += ["[sky]", "diffuse_irradiance = [0.1, 0.1]"]
    (amc.parent / "sky.toml").write_text("\n".join([*lines, ""]))
    return amc


def by_weather_scene(answer, kind, _):
    alone = {"diffuse_only": True} if answer == "nothing" else SUN
    return sky.weather_scene(wavebands=NM, n_photons=1000, **alone, **SAID[answer], sky=model_of(kind))


def by_read_scene(answer, kind, folder):
    amc = amc_with(folder, answer, by_file=False)
    return sky.read_scene(amc, sky=model_of(kind), perez=SAID[answer], diffuse_only=answer == "nothing")


def by_sky_toml(answer, kind, folder):
    return sky.read_scene(amc_with(folder, answer, by_file=True), sky=model_of(kind), diffuse_only=answer == "nothing")


def by_a_file(answer, kind, folder):
    """A table of radiances: a uniform sky, named alone."""
    from aomc_sky.formats.sky_toml.sections import FieldSection
    from aomc_sky.source.light.said import said_by_caller
    from aomc_sky.source.read.radiance_scene import measured_scene

    rows = [f"{z},{a},{0.11 / np.pi},{0.12 / np.pi}" for z in (0, 20, 40, 60, 80, 89) for a in range(0, 360, 30)]
    unit = "W m-2 nm-1 sr-1" if kind == "absolute" else "relative"
    head = ["# azimuth: counterclockwise from east", f"# radiance unit: {unit}", "zenith_deg,azimuth_deg,L_443,L_555"]
    path = folder / "sky.csv"
    path.write_text("\n".join([*head, *rows, ""]))
    sun = {} if answer == "nothing" else {"zenith_deg": ZENITH, "azimuth_deg": 30.0}
    return measured_scene(FieldSection(file=str(path)), said_by_caller(perez=SAID[answer], sun=sun))


ENTRANCES = {
    "weather_scene": by_weather_scene, "read_scene": by_read_scene, "sky.toml": by_sky_toml, "sky.csv": by_a_file,
}  # fmt: skip
CASES = [
    (answer, kind, entrance)
    for answer, kind, entrance in itertools.product(SAID, ("relative", "absolute"), ENTRANCES)
    if not (answer in OF_FILES and entrance in ("weather_scene", "sky.csv"))
]


@pytest.mark.parametrize(("answer", "kind", "entrance"), CASES)
@pytest.mark.filterwarnings("ignore:every waveband has the broadband:aomc_sky.InputWarning")
def test_every_answer_beside_every_kind_of_sky_at_every_entrance(answer, kind, entrance, tmp_path):
    expected = expected_light(answer, is_absolute=kind == "absolute")
    if expected is None:
        with pytest.raises(sky.UsageError, match="one share in all wavebands"):
            ENTRANCES[entrance](answer, kind, tmp_path)
        return
    scene = ENTRANCES[entrance](answer, kind, tmp_path)
    within = 2e-3 if entrance == "sky.csv" else 2e-5  # an interpolated table, and 6 digits of a turbidity
    for found, wanted in zip(light(scene), expected, strict=True):
        assert (found is None) == (wanted is None)
        if wanted is not None:
            np.testing.assert_allclose(found, wanted, rtol=within, atol=1e-12)
    shutil.rmtree(tmp_path / "sun_and_sky", ignore_errors=True)
