"""Texts and attributes of a field, wherever they stand, are read or asked about; none is dropped."""

import json

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main
from aomc_sky.errors import FieldError

xarray = pytest.importorskip("xarray")

ZENITH, AZIMUTH = np.arange(0.0, 91.0, 10.0), np.arange(0.0, 360.0, 15.0)
UNIT = "mW m-2 nm-1 sr-1"
FROM_NORTH = {"units": "degree", "long_name": "azimuth clockwise from north"}


def east(*, radiance=None, azimuth=None, zenith=None, of_file=None, name="radiance", change=lambda values: values):
    """A field that is brightest at azimuth 90 of its own; attributes as given."""
    values = 200 + 100 * np.sin(np.deg2rad(ZENITH))[:, None] * np.sin(np.deg2rad(AZIMUTH))
    return xarray.Dataset(
        {name: (("wavelength", "zenith", "azimuth"), change(values)[None], {"units": UNIT, **(radiance or {})})},
        coords={
            "wavelength": ("wavelength", [550.0], {"units": "nm"}),
            "zenith": ("zenith", ZENITH, {"units": "degree", **(zenith or {})}),
            "azimuth": ("azimuth", AZIMUTH, azimuth or {"units": "degree"}),
        },
        attrs=of_file or {},
    )


def brightest(table):
    grid = table.grid
    return float(grid.azimuth_bounds_deg.mean(axis=1)[table.values[0].reshape(grid.n_zenith, -1)[5].argmax()] % 360)


@pytest.mark.parametrize(
    "texts",
    [
        {"of_file": {"azimuth_convention": "clockwise from north"}},
        {"of_file": {"comment": "Cloudless. Azimuth is counted clockwise from north.\nMade in Kiel."}},
        {"radiance": {"comment": "azimuth clockwise from north"}},
        {"azimuth": {"units": "degree_true"}},
        {"azimuth": {"units": "degree", "note": "clockwise from north"}},
        {"azimuth": {"units": "degree", "azimuth_zero": "north", "sense": "clockwise"}},
        {"of_file": {"azimuth_reference": "north"}},
        {"radiance": {"azimuth_definition": "north = 0, east = 90"}},
        {"azimuth": {"units": "degree", "long_name": "azimuth (phi=0 at N, increasing through E)"}},
        {"of_file": {"comment": "North: 0 deg, East: 90 deg"}},
    ],
)
def test_azimuths_are_explained_anywhere(texts, tmp_path):
    """In memory and in a file; the east is at 0 of ours."""
    pytest.importorskip("h5netcdf")
    field = east(**texts)
    table = sky.TabulatedSky.from_xarray(field)
    assert min(brightest(table), 360 - brightest(table)) < 1
    assert not [one for one in table.remarks if "does not say" in one]
    field.to_netcdf(tmp_path / "field.nc", engine="h5netcdf")
    run = ["run", tmp_path / "field.nc", "--iterations", 20000, "--out", tmp_path / "out", "-q"]
    assert main([str(word) for word in run]) == 0
    ux, uy, _ = np.load(tmp_path / "out" / "photons-0001.npy").mean(axis=0, dtype=float)
    assert ux < -0.05
    assert abs(uy) < 0.01


def test_a_comment_on_something_else_explains_no_azimuth():
    table = sky.TabulatedSky.from_xarray(east(of_file={"comment": "Towards the north there was haze."}))
    assert [one for one in table.remarks if "does not say from where azimuths count" in one]


@pytest.mark.parametrize(
    ("texts", "word"),
    [
        ({"zenith": {"long_name": "zenith angle of the direction of propagation"}}, "propagation"),
        ({"zenith": {"comment": "the photons travel to"}}, "travel"),
        ({"radiance": {"comment": "Angles are those of the direction of photon travel."}}, "travel"),
        ({"of_file": {"comment": "Calm sea. All directions are directions of propagation."}}, "propagation"),
    ],
)
def test_directions_that_light_goes_to_are_refused(texts, word):
    with pytest.raises(FieldError, match=f"speaks of '{word}'.*light goes to") as error:
        sky.TabulatedSky.from_xarray(east(azimuth=FROM_NORTH, **texts))
    assert "180 degrees minus the zenith angle" in error.value.advice


def test_a_horizon_is_no_sky():
    """Angles from 90 to 180 degrees: the sky was left out with a remark, and the horizon took its place."""
    with pytest.raises(FieldError, match="no angles below 90 degrees; are they those that light goes to"):
        sky.TabulatedSky.from_xarray(east().assign_coords(zenith=("zenith", 180 - ZENITH, {"units": "degree"})))


def test_one_zenith_angle_is_said():
    table = sky.TabulatedSky.from_xarray(east(azimuth=FROM_NORTH).isel(zenith=[4]))
    assert "the field has one zenith angle, so its sky is the same from the zenith to the horizon" in table.remarks


@pytest.mark.parametrize("name", ["unit", "Units", "UNITS"])
def test_the_unit_has_other_spellings(name):
    field = east(azimuth=FROM_NORTH)
    field.radiance.attrs = {name: UNIT}
    assert sky.TabulatedSky.from_xarray(field).radiance_unit == pytest.approx(1e-3)


@pytest.mark.parametrize(
    "name", ["scale", "Scale", "multiplier", "slope", "offset", "scaling_factor", "Scale_Factor", "radiance_scales"]
)
def test_a_factor_under_another_name_is_refused(name):
    for value in (0.001, "0.001"):
        with pytest.raises(FieldError, match=f"attribute '{name}' of the field is 0.001, besides its unit"):
            sky.TabulatedSky.from_xarray(east(radiance={name: value}))
    sky.TabulatedSky.from_xarray(east(radiance={"scale": 1.0, "offset": 0}))


def test_logarithms_and_factors_in_words():
    for text, why in (("log10 of radiance", "says 'log10'"), ("radiance x 1000", "says 'radiance x 1000'")):
        with pytest.raises(FieldError, match=why):
            sky.TabulatedSky.from_xarray(east(radiance={"long_name": text}))
    sky.TabulatedSky.from_xarray(east(radiance={"comment": "catalogue of skies, image of 1000 x 1000 pixels"}))


@pytest.mark.parametrize("fill", [-99.0, 7777.0, 1e20])
@pytest.mark.parametrize("name", ["missing_value", "_FillValue", "fill_value", "FillValue", "nodata", "MissingValue"])
def test_fill_values_as_text_or_under_another_name(name, fill, tmp_path):
    """The gap has no light, also where the attribute is text, which the netCDF library does not compare."""
    pytest.importorskip("h5netcdf")

    def with_gap(values):
        values = values.copy()
        values[4, 7] = fill
        return values

    field = east(azimuth=FROM_NORTH, radiance={name: str(fill)}, change=with_gap)
    if name != "_FillValue":  # xarray writes no text under this name
        field.to_netcdf(tmp_path / "field.nc", engine="h5netcdf", encoding={"radiance": {"_FillValue": None}})
        run = ["run", tmp_path / "field.nc", "--iterations", 1000, "--out", tmp_path / "out", "--format", "none", "-q"]
        assert main([str(word) for word in run]) == 0
        band = json.loads((tmp_path / "out" / "manifest.json").read_text())["bands"][0]
        assert band["irradiance_W_m2_nm"] == pytest.approx(0.2 * np.pi, rel=0.01)
    table = sky.TabulatedSky.from_xarray(field)
    assert table.values.max() < 310


def test_nines_far_beyond_all_other_radiances_are_a_question():
    def with_nines(values):
        return np.where(np.arange(values.size).reshape(values.shape) == 50, 9999.0, values)

    with pytest.raises(FieldError, match="1 radiance is 9999, and the next one is 300; is 9999 a gap") as error:
        sky.TabulatedSky.from_xarray(east(azimuth=FROM_NORTH, change=with_nines))
    assert error.value.advice == "write NaN for a gap, or 9998 for a radiance"
    bright = sky.TabulatedSky.from_xarray(east(azimuth=FROM_NORTH, change=lambda one: one + 9999.0 - one.max()))
    assert bright.values.max() > 9900


@pytest.mark.parametrize(
    "name",
    [
        "Lu",
        "L_w",
        "radiance_error",
        "sky_radiance_uncertainty",
        "radiance_std",
        "toa_radiance",
        "dolp",
        "brf",
        "L_up",
        "direct_radiance",
        "I_dir",
        "water_radiance",
    ],
)
def test_a_variable_that_is_no_light_of_the_sky(name):
    with pytest.raises(FieldError, match=f"'{name}' is not the light of the sky by its name"):
        sky.TabulatedSky.from_xarray(east(azimuth=FROM_NORTH, name=name))
    sky.TabulatedSky.from_xarray(east(azimuth=FROM_NORTH, name=name), variable=name)


def test_a_hyphen_hides_no_light_of_the_water():
    with pytest.raises(FieldError, match="not the light of the sky"):
        sky.TabulatedSky.from_xarray(east(name="L", radiance={"long_name": "water-leaving radiance"}))


def test_a_negative_value_is_shown():
    with pytest.raises(FieldError, match="negative or infinite: 240, such as -300"):
        sky.TabulatedSky.from_xarray(east(azimuth=FROM_NORTH, change=lambda values: -values))


@pytest.mark.parametrize("text", ["0 is backscattering", "0 = backward scattering"])
def test_a_relative_azimuth_that_counts_from_the_antisun_is_no_other(text):
    """0 is the sun for relative azimuths; a comment that says the contrary was not read."""
    field = east(azimuth={"units": "degree", "comment": text}).rename(azimuth="relative_azimuth")
    with pytest.raises(FieldError, match="contradict each other"):
        sky.TabulatedSky.from_xarray(field, sun_azimuth_deg=30.0)
    field.relative_azimuth.attrs["comment"] = "0 is the direction of forward scattering"
    forward = sky.TabulatedSky.from_xarray(field, sun_azimuth_deg=30.0)
    assert brightest(forward) == pytest.approx(120, abs=1)
    alone = east(azimuth={"units": "degree", "comment": text})
    assert brightest(sky.TabulatedSky.from_xarray(alone, sun_azimuth_deg=30.0)) == pytest.approx(300, abs=1)


@pytest.mark.parametrize("name", ["zenith", "azimuth"])
def test_radians_that_say_degrees_are_a_question(name):
    field = east(azimuth=FROM_NORTH)
    attributes = field[name].attrs
    wrong = field.assign_coords({name: (name, np.deg2rad(field[name].values), attributes)})
    with pytest.raises(FieldError, match=f"coordinate '{name}' has values up to .* degrees; are they radians"):
        sky.TabulatedSky.from_xarray(wrong)
    near = field.isel(zenith=[0, 1, 2]).assign_coords(zenith=("zenith", [0.0, 0.5, 1.0], {"units": "degree"}))
    sky.TabulatedSky.from_xarray(near)


def test_elevations_whose_text_is_of_zenith_angles():
    field = east(azimuth=FROM_NORTH, zenith={"long_name": "zenith angle"}).rename(zenith="elevation")
    with pytest.raises(FieldError, match="an elevation by its name, but its text says 'zenith angle'"):
        sky.TabulatedSky.from_xarray(field)


@pytest.mark.parametrize("attributes", [{"units": "m"}, {"units": "km", "standard_name": "altitude"}, {}])
def test_an_altitude_in_metres_is_no_elevation(attributes):
    field = east(azimuth=FROM_NORTH)
    with_height = field.expand_dims(altitude=[0.0]).assign_coords(altitude=("altitude", [0.0], attributes))
    plain, other = (sky.TabulatedSky.from_xarray(one) for one in (field, with_height))
    np.testing.assert_array_equal(plain.values, other.values)
    three = xarray.concat([field] * 3, "altitude").assign_coords(altitude=("altitude", [0.0, 1.0, 2.0], attributes))
    with pytest.raises(FieldError, match="dimension 'altitude' of 3"):
        sky.TabulatedSky.from_xarray(three)


def test_a_mask_is_no_radiance_and_flags_are_said():
    with pytest.raises(FieldError, match="holds bool instead of real numbers"):
        sky.TabulatedSky.from_xarray(east(azimuth=FROM_NORTH, change=lambda values: values > 200))
    table = sky.TabulatedSky.from_xarray(east(azimuth=FROM_NORTH, radiance={"ancillary_variables": "quality"}))
    assert "'quality' of the file, on the quality of the radiances, is not used" in table.remarks


@pytest.mark.parametrize("name", ["zenith", "wavelength"])
def test_a_coordinate_that_is_not_finite_is_named(name):
    field = east(azimuth=FROM_NORTH)
    values = field[name].values.copy()
    values[-1] = np.nan
    with pytest.raises(FieldError, match=f"coordinate '{name}' has (values that are not|no) finite"):
        sky.TabulatedSky.from_xarray(field.assign_coords({name: (name, values, field[name].attrs)}))


def test_the_sense_of_azimuths_is_read_under_any_name():
    """From north and counterclockwise: the west at 90."""
    for name in ("sense", "rotation", "orientation", "handedness"):
        azimuth = {"units": "degree", "origin": "north", name: "counterclockwise"}
        assert brightest(sky.TabulatedSky.from_xarray(east(azimuth=azimuth))) == pytest.approx(180, abs=1)


@pytest.mark.parametrize("text", ["Monte Carlo model of light propagation", "photons travel through the sea"])
def test_propagation_without_directions_is_no_doubt(text):
    sky.TabulatedSky.from_xarray(east(azimuth=FROM_NORTH, of_file={"title": text, "comment": text}))


def test_words_on_quality_in_a_long_name_are_no_doubt():
    text = {"long_name": "sky radiance, quality controlled, uncertainty 3 %", "nodata": ""}
    assert sky.TabulatedSky.from_xarray(east(azimuth=FROM_NORTH, radiance=text)).radiance_unit == pytest.approx(1e-3)


@pytest.mark.parametrize("words", ["ln ", "north east ", "azimuth from north east "])
def test_long_texts_of_a_stranger_take_no_time(words):
    text = words * (1_000_000 // len(words))
    field = east(azimuth=FROM_NORTH, radiance={"comment": text}, of_file={"summary": text})
    assert min(brightest(sky.TabulatedSky.from_xarray(field)), 1.0) == 0.0


@pytest.mark.parametrize(
    ("texts", "why"),
    [
        ({"azimuth": {"units": "degree", "long_name": "Azimut, im Uhrzeigersinn von Nord"}}, "is not understood"),
        ({"of_file": {"comment": "azimut (depuis le nord, sens horaire)"}}, "is not understood"),
        ({"of_file": {"comment": "viewing angles are nadir angles"}}, "speaks of 'nadir'"),
        ({"radiance": {"note": "zenith angles are measured from the horizon"}}, "speaks of 'from the horizon'"),
        ({"of_file": {"comment": "radiances multiplied by 1000"}}, "says 'multiplied' besides its unit"),
        ({"zenith": {"units": "gon"}}, "units = 'gon'"),
    ],
)
def test_texts_of_the_file_that_change_the_light_are_refused(texts, why):
    with pytest.raises(FieldError, match=why):
        sky.TabulatedSky.from_xarray(east(**texts))


@pytest.mark.parametrize("text", ["zenith angle, 0 = overhead, 90 = horizon", "mu = cos(zenith angle) is 1 overhead"])
def test_texts_that_explain_zenith_angles_are_no_doubt(text):
    sky.TabulatedSky.from_xarray(east(zenith={"long_name": text}, azimuth=FROM_NORTH))


@pytest.mark.parametrize("units", ["1", "degree"])
def test_cosines_by_their_text_are_no_degrees(units):
    field = east(zenith={"units": units, "long_name": "cosine of zenith angle"}, azimuth=FROM_NORTH)
    cosines = ("zenith", np.cos(np.deg2rad(ZENITH)), field.zenith.attrs)
    with pytest.raises(FieldError, match="its text speaks of a cosine"):
        sky.TabulatedSky.from_xarray(field.assign_coords(zenith=cosines))


def test_an_azimuth_that_has_the_name_of_the_cf_conventions_counts_as_they_do():
    table = sky.TabulatedSky.from_xarray(east().rename(azimuth="sensor_azimuth_angle"))
    assert min(brightest(table), 360 - brightest(table)) < 1


@pytest.mark.parametrize("fill", [-999.9, 0.3333])
def test_a_fill_value_of_float64_is_that_of_float32(fill, tmp_path):
    pytest.importorskip("h5netcdf")
    field = east(azimuth=FROM_NORTH, radiance={"missing_value": fill})
    values = field.radiance.astype("f4")
    values[0, 4, 6] = np.float32(fill)
    field.assign(radiance=values).to_netcdf(tmp_path / "field.nc", engine="h5netcdf")
    with xarray.open_dataset(tmp_path / "field.nc", engine="h5netcdf") as read:
        table = sky.TabulatedSky.from_xarray(read)
    assert any("1 of 240 directions have no value" in one for one in table.remarks)


def test_gaps_of_coordinates_are_no_angles():
    """The corners of an all-sky image."""
    y, x = np.mgrid[-1:1:31j, -1:1:31j]
    is_sky = np.hypot(x, y) <= 1
    zenith = np.where(is_sky, 90 * np.hypot(x, y), -999.0)
    azimuth = np.where(is_sky, np.rad2deg(np.arctan2(x, y)) % 360, -999.0)
    field = xarray.DataArray(
        np.where(is_sky, 1.0, 0.0),
        dims=("y", "x"),
        coords={"zenith": (("y", "x"), zenith, {"units": "degree"}), "azimuth": (("y", "x"), azimuth, FROM_NORTH)},
    )
    table = sky.TabulatedSky.from_xarray(field)
    assert f"{np.sum(~is_sky)} values without a direction were left out" in table.remarks
    assert table.radiance(0.5, 1.0, 550.0) == pytest.approx(1.0)


def test_bounds_that_the_file_lost_are_asked_for(tmp_path, capsys):
    """Half-way between 5, 20 and 60 degrees is no edge of rings 0-10-30-90."""
    pytest.importorskip("h5netcdf")
    zenith = ("zenith", [5.0, 20.0, 60.0], {"units": "degree", "bounds": "zenith_bnds"})
    field = east(azimuth=FROM_NORTH).isel(zenith=slice(3)).assign_coords(zenith=zenith)
    field.to_netcdf(tmp_path / "field.nc", engine="h5netcdf")
    assert main(["run", str(tmp_path / "field.nc"), "--dry-run"]) == 3
    assert "has the bounds 'zenith_bnds', which are not in this field" in capsys.readouterr().err


def test_solid_angles_beside_the_radiances_are_no_second_field(tmp_path):
    pytest.importorskip("h5netcdf")
    field = east(azimuth=FROM_NORTH, radiance={"cell_measures": "area: omega"}, name="I").squeeze(
        "wavelength", drop=True
    )
    field["omega"] = (("zenith", "azimuth"), np.ones((10, 24)))
    field.to_netcdf(tmp_path / "field.nc", engine="h5netcdf")
    assert main(["run", str(tmp_path / "field.nc"), "--wavelengths", "550", "--dry-run"]) == 0


@pytest.mark.parametrize(("nines", "is_asked"), [(999.9, True), (9999.9, True), (99.9, False)])
@pytest.mark.parametrize("dtype", ["f4", "f8"])
def test_nines_with_decimals_are_a_question_too(nines, is_asked, dtype):
    """At one of two wavelengths, with larger radiances at the other one."""

    def with_nines(values):
        return np.where(np.arange(values.size).reshape(values.shape) == 50, nines, values / 10)

    bright = east(azimuth=FROM_NORTH, change=lambda values: values * 100).assign_coords(wavelength=[440.0])
    both = xarray.concat([bright, east(azimuth=FROM_NORTH, change=with_nines)], "wavelength").astype(dtype)
    both.wavelength.attrs["units"] = "nm"
    if not is_asked:
        assert sky.TabulatedSky.from_xarray(both).values[1].max() > 60
        return
    with pytest.raises(FieldError, match=f"1 radiance is {nines}, and the next one is 30; is {nines} a gap"):
        sky.TabulatedSky.from_xarray(both)


def test_flags_beside_the_radiances_are_said(tmp_path, capsys):
    pytest.importorskip("h5netcdf")
    field = east(azimuth=FROM_NORTH)
    field["pixel_quality"] = (field.radiance.dims, np.zeros(field.radiance.shape, "i1"))
    field["cloud"] = (field.radiance.dims, np.zeros(field.radiance.shape, "i1"), {"flag_meanings": "clear cloudy"})
    field["ship_flag"] = ("station", [1, 2])
    field.to_netcdf(tmp_path / "field.nc", engine="h5netcdf")
    assert main(["run", str(tmp_path / "field.nc"), "--dry-run"]) == 0
    shown = capsys.readouterr()
    assert "'pixel_quality cloud' of the file, on the quality of the radiances, is not used" in shown.out + shown.err


@pytest.mark.parametrize("name", ["cos_theta", "cosine_of_zenith_angle", "cos_vza", "cos_zenith"])
def test_cosines_have_names(name):
    field = east(azimuth=FROM_NORTH).isel(zenith=slice(None, None, -1))
    cosine = np.cos(np.deg2rad(field.zenith.values))
    made = field.assign_coords(zenith=("zenith", cosine, {"units": "1"})).rename(zenith=name)
    expected, table = (sky.TabulatedSky.from_xarray(one) for one in (field, made))
    np.testing.assert_allclose(table.values, expected.values, rtol=1e-12)
    with pytest.raises(FieldError, match="no coordinate of zenith angles"):
        sky.TabulatedSky.from_xarray(made.rename({name: "cos_solar_zenith"}))


def test_angles_of_travel_and_of_the_nadir_have_their_advice():
    travel = east(azimuth=FROM_NORTH).isel(zenith=slice(0, 9))
    travel = travel.assign_coords(zenith=180 - travel.zenith.values)
    for made in (travel.assign_coords(zenith=("zenith", travel.zenith.values, {"units": "degree"})),):
        with pytest.raises(FieldError) as error:
            sky.TabulatedSky.from_xarray(made)
        assert "180 degrees minus them" in error.value.advice
        with pytest.raises(FieldError) as error:
            sky.TabulatedSky.from_xarray(made.rename(zenith="nadir_angle"))
        assert "180 degrees minus the angles from the nadir" in error.value.advice


def test_texts_of_c_and_of_latin_1_are_read(tmp_path):
    """C writes the NUL at the end of its texts, and old programs a degree sign in one byte."""
    pytest.importorskip("h5netcdf")
    h5py = pytest.importorskip("h5py")
    from aomc_sky.formats.netcdf import read_field

    ends = east(
        azimuth={"units": "deg\0", "long_name": "azimuth clockwise from north\0"}, radiance={"units": f"{UNIT}\0"}
    )
    ends.to_netcdf(tmp_path / "c.nc", engine="scipy")
    east(azimuth=FROM_NORTH).to_netcdf(tmp_path / "latin.nc", engine="h5netcdf")
    with h5py.File(tmp_path / "latin.nc", "a") as file:
        file["zenith"].attrs["units"] = np.bytes_(b"\xb0")
    expected = sky.TabulatedSky.from_xarray(east(azimuth=FROM_NORTH))
    for name in ("c.nc", "latin.nc"):
        table = sky.TabulatedSky.from_xarray(read_field(tmp_path / name))
        assert table.radiance_unit == 1e-3
        np.testing.assert_array_equal(table.values, expected.values)


def test_the_zenith_of_points_needs_no_azimuth():
    rings, around = np.meshgrid([15.0, 30, 45, 60, 75, 88], np.arange(0.0, 360, 30))
    zenith, azimuth = np.append(0.0, rings), np.append(np.nan, around)
    points = xarray.DataArray(
        130 - zenith / 3,
        dims="point",
        coords={"zenith": ("point", zenith, {"units": "degree"}), "azimuth": ("point", azimuth, FROM_NORTH)},
        attrs={"units": UNIT},
    )
    table = sky.TabulatedSky.from_xarray(points)
    assert not [one for one in table.remarks if "left out" in one]
    assert float(table.radiance(0.0, 0.0, 550.0)) * table.radiance_unit == pytest.approx(0.130, rel=1e-3)


@pytest.mark.parametrize(
    ("attribute", "text", "why"),
    [
        ("comment", "radiance times cos(theta)", "says 'radiance times cos'"),
        ("long_name", "sky radiance, weighted by solid angle", "says 'weighted by solid angle'"),
        ("remarks", "cosine-weighted", "says 'cosine-weighted'"),
        ("note", "multiply by 0.1", "says 'multiply' besides its unit"),
        ("long_name", "sky radiance per 10 nm", "says 'radiance per 10 nm' besides its unit"),
    ],
)
def test_texts_of_weights_and_factors_are_refused(attribute, text, why):
    with pytest.raises(FieldError, match=why):
        sky.TabulatedSky.from_xarray(east(azimuth=FROM_NORTH, radiance={attribute: text}))
