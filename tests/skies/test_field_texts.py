"""Texts and attributes of a field, wherever they stand, are read or asked about; none is dropped."""

import json

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main
from aomc_sky.errors import FieldError

xarray = pytest.importorskip("xarray")
read = sky.TabulatedSky.from_xarray

ZENITH, AZIMUTH = np.arange(0.0, 91.0, 10.0), np.arange(0.0, 360.0, 15.0)
UNIT = "mW m-2 nm-1 sr-1"
DEGREES = {"units": "degree"}
FROM_NORTH = DEGREES | {"long_name": "azimuth clockwise from north"}


def east(*, radiance=None, azimuth=FROM_NORTH, zenith=None, of_file=None, name="radiance", change=np.array):
    """A field that is brightest at azimuth 90 of its own; attributes as given."""
    values = 200 + 100 * np.sin(np.deg2rad(ZENITH))[:, None] * np.sin(np.deg2rad(AZIMUTH))
    return xarray.Dataset(
        {name: (("wavelength", "zenith", "azimuth"), change(values)[None], {"units": UNIT, **(radiance or {})})},
        coords={
            "wavelength": ("wavelength", [550.0], {"units": "nm"}),
            "zenith": ("zenith", ZENITH, DEGREES | (zenith or {})),
            "azimuth": ("azimuth", AZIMUTH, azimuth),
        },
        attrs=of_file or {},
    )


def cosines(units):
    field = east(zenith={"units": units, "long_name": "cosine of zenith angle"})
    return field.assign_coords(zenith=("zenith", np.cos(np.deg2rad(ZENITH)), field.zenith.attrs))


def brightest(table):
    grid = table.grid
    return float(grid.azimuth_bounds_deg.mean(axis=1)[table.values[0].reshape(grid.n_zenith, -1)[5].argmax()] % 360)


def with_pixel(value):
    return lambda values: np.where(np.arange(values.size).reshape(values.shape) == 103, value, values)


def run(field, folder, *options, **encoding):
    """The exit code of the command on this field in a file."""
    pytest.importorskip("h5netcdf")
    field.to_netcdf(folder / "field.nc", engine="h5netcdf", **encoding)
    return main(["run", str(folder / "field.nc"), *map(str, options)])


@pytest.mark.parametrize(
    "texts",
    [
        {"of_file": {"azimuth_convention": "clockwise from north"}},
        {"of_file": {"azimuth_convention": "north_clockwise"}},
        {"of_file": {"comment": "Cloudless. Azimuth is counted clockwise from north.\nMade in Kiel."}},
        {"radiance": {"comment": "azimuth clockwise from north"}},
        {"azimuth": {"units": "degree_true"}},
        {"azimuth": DEGREES | {"note": "clockwise from north"}},
        {"azimuth": DEGREES | {"azimuth_zero": "north", "sense": "clockwise"}},
        {"of_file": {"azimuth_reference": "north"}},
        {"radiance": {"azimuth_definition": "north = 0, east = 90"}},
        {"azimuth": {"units": "degree", "long_name": "azimuth (phi=0 at N, increasing through E)"}},
        {"of_file": {"comment": "North: 0 deg, East: 90 deg"}},
    ],
)
def test_azimuths_are_explained_anywhere(texts, tmp_path):
    """In memory and in a file; the east is at 0 of ours."""
    field = east(**{"azimuth": DEGREES, **texts})
    table = read(field)
    assert min(brightest(table), 360 - brightest(table)) < 1
    assert not [one for one in table.remarks if "does not say" in one]
    assert run(field, tmp_path, "--iterations", 20000, "--out", tmp_path / "out", "-q") == 0
    ux, uy, _ = np.load(tmp_path / "out" / "photons-0001.npy").mean(axis=0, dtype=float)
    assert ux < -0.05
    assert abs(uy) < 0.01


@pytest.mark.parametrize(
    ("field", "remark"),
    [
        (east(azimuth=DEGREES, of_file={"comment": "Towards the north there was haze."}), "does not say from where az"),
        (east().isel(zenith=[4]), "one zenith angle, so its sky is the same from the zenith to the horizon"),
        (east(radiance={"ancillary_variables": "quality"}), "'quality' of the file, on the quality of the radiances"),
    ],
)
def test_what_is_taken_for_granted_is_said(field, remark):
    assert any(remark in one for one in read(field).remarks)


@pytest.mark.parametrize("name", ["unit", "Units", "UNITS"])
def test_the_unit_has_other_spellings(name):
    field = east()
    field.radiance.attrs = {name: UNIT}
    assert read(field).radiance_unit == pytest.approx(1e-3)
    field.radiance.attrs = {name: "relative", "long_name": "sun-normalised radiance"}  # a factor changes nothing
    assert read(field).radiance_unit == 0
    field.radiance.attrs = {"long_name": f"sky radiance in {UNIT}"}
    assert read(field).radiance_unit == pytest.approx(1e-3)


@pytest.mark.parametrize("fill", [-99.0, 7777.0, 1e20])
@pytest.mark.parametrize("name", ["missing_value", "_FillValue", "fill_value", "FillValue", "nodata", "MissingValue"])
def test_fill_values_as_text_or_under_another_name(name, fill, tmp_path):
    """The gap has no light, also where the attribute is text, which the netCDF library does not compare."""
    field = east(radiance={name: str(fill)}, change=with_pixel(fill))
    if name != "_FillValue":  # xarray writes no text under this name
        options = ("--iterations", 1000, "--out", tmp_path / "out", "--format", "none", "-q")
        assert run(field, tmp_path, *options, encoding={"radiance": {"_FillValue": None}}) == 0
        band = json.loads((tmp_path / "out" / "manifest.json").read_text())["bands"][0]
        assert band["irradiance_W_m2_nm"] == pytest.approx(0.2 * np.pi, rel=0.01)
    assert read(field).values.max() < 310


NO_SKY = [
    "Lu", "L_w", "upwelling_radiance", "toa_radiance", "stokes_Q", "dolp", "brf", "L_up", "direct_radiance", "I_dir",
    "water_radiance", "radiance_error", "sky_radiance_uncertainty", "radiance_std",
]  # fmt: skip


@pytest.mark.parametrize("name", NO_SKY)
def test_a_variable_that_is_no_light_of_the_sky(name):
    with pytest.raises(FieldError, match=f"'{name}' is not the light of the sky by its name") as error:
        read(east(name=name))
    assert f"--variable {name}" in error.value.advice
    read(east(name=name), variable=name)


@pytest.mark.parametrize("text", ["0 is backscattering", "0 = backward scattering"])
def test_a_relative_azimuth_that_counts_from_the_antisun_is_no_other(text):
    """0 is the sun for relative azimuths; a comment that says the contrary was not read."""
    field = east(azimuth=DEGREES | {"comment": text}).rename(azimuth="relative_azimuth")
    with pytest.raises(FieldError, match="contradict each other"):
        read(field, sun_azimuth_deg=30.0)
    field.relative_azimuth.attrs["comment"] = "0 is the direction of forward scattering"
    assert brightest(read(field, sun_azimuth_deg=30.0)) == pytest.approx(120, abs=1)
    alone = east(azimuth=DEGREES | {"comment": text})
    assert brightest(read(alone, sun_azimuth_deg=30.0)) == pytest.approx(300, abs=1)


@pytest.mark.parametrize("attributes", [{"units": "m"}, {"units": "km", "standard_name": "altitude"}, {}])
def test_an_altitude_in_metres_is_no_elevation(attributes):
    field = east()
    with_height = field.expand_dims(altitude=[0.0]).assign_coords(altitude=("altitude", [0.0], attributes))
    np.testing.assert_array_equal(read(field).values, read(with_height).values)
    three = xarray.concat([field] * 3, "altitude").assign_coords(altitude=("altitude", [0.0, 1.0, 2.0], attributes))
    with pytest.raises(FieldError, match="dimension 'altitude' of 3"):
        read(three)


def test_the_sense_of_azimuths_is_read_under_any_name():
    """From north and counterclockwise: the west at 90."""
    for name in ("sense", "rotation", "orientation", "handedness"):
        azimuth = {"units": "degree", "origin": "north", name: "counterclockwise"}
        assert brightest(read(east(azimuth=azimuth))) == pytest.approx(180, abs=1)


@pytest.mark.parametrize("words", ["ln ", "north east ", "azimuth from north east "])
def test_long_texts_of_a_stranger_take_no_time(words):
    text = words * (1_000_000 // len(words))
    assert min(brightest(read(east(radiance={"comment": text}, of_file={"summary": text}))), 1.0) == 0.0


def changed(name, change):
    """The field with another coordinate under the attributes of this one."""
    field = east()
    return field.assign_coords({name: (name, change(field[name].values), field[name].attrs)})


def without_end(values):
    return np.append(values[:-1], np.nan)


FACTORS = ("scale", "Scale", "multiplier", "slope", "offset", "scaling_factor", "Scale_Factor", "radiance_scales")
ABOVE, BELOW_90 = east().isel(zenith=slice(0, 9)), 180 - ZENITH[:9]


@pytest.mark.parametrize(
    ("field", "why"),
    [
        *(
            (east(radiance={name: value}), f"attribute '{name}' of the field is 0.001, besides its unit")
            for name in FACTORS
            for value in (0.001, "0.001")
        ),
        *((changed(name, without_end), f"coordinate '{name}' has .*finite") for name in ("zenith", "wavelength")),
        (changed("zenith", np.deg2rad), "coordinate 'zenith' has values up to .* degrees; are they radians"),
        (changed("azimuth", np.deg2rad), "coordinate 'azimuth' has values up to .* degrees; are they radians"),
        (east(azimuth=DEGREES | {"long_name": "Azimut, im Uhrzeigersinn von Nord"}), "is not understood"),
        (east(azimuth=DEGREES, of_file={"comment": "azimut (depuis le nord, sens horaire)"}), "is not understood"),
        (east(of_file={"comment": "viewing angles are nadir angles"}), "speaks of 'nadir'"),
        (east(radiance={"note": "zenith angles are measured from the horizon"}), "speaks of 'from the horizon'"),
        (east(of_file={"comment": "radiances multiplied by 1000"}), "says 'multiplied' besides its unit"),
        (east(zenith={"units": "gon"}), "units = 'gon'"),
        (east(zenith={"long_name": "elevation angle above the horizon"}), "speaks of 'elevation'"),
        (east(azimuth={"units": "radian"}), "goes to 19767 degrees; are its units radians"),
        (east(radiance={"comment": "scale factor 0.01"}), "says 'scale' besides its unit"),
        (east(radiance={"valid_range": "0 to 500"}), "valid_range of the field is '0 to 500', and no numbers"),
        (east(radiance={"long_name": "log10 of radiance"}), "says 'log10'"),
        (east(radiance={"long_name": "radiance x 1000"}), "says 'radiance x 1000'"),
        (east(name="L", radiance={"long_name": "water-leaving radiance"}), "not the light of the sky"),
        (east(change=np.negative), "negative or infinite: 240, such as -300"),
        (east(change=lambda values: values > 200), "holds bool instead of real numbers"),
        # the sky was left out with a remark, and the horizon took its place
        (east().assign_coords(zenith=("zenith", 180 - ZENITH, DEGREES)), "no angles below 90 degrees; are they those"),
        (east(zenith={"long_name": "zenith angle"}).rename(zenith="elevation"), "its text says 'zenith angle'"),
        *((cosines(units), "its text speaks of a cosine") for units in ("1", "degree")),
        (east(radiance={"comment": "radiance times cos(theta)"}), "says 'radiance times cos'"),
        (east(radiance={"long_name": "radiance, weighted by solid angle"}), "says 'weighted by solid angle'"),
        (east(radiance={"long_name": "sky radiance per 10 nm"}), "says 'radiance per 10 nm' besides its unit"),
        (east(radiance={"long_name": "sun-normalised radiance"}), "says 'sun-normalised' besides its unit"),
        (east(radiance={"long_name": "radiance [W m-2 nm-1 sr-1]"}), "is 'mW m-2 nm-1 sr-1', and its text says 'W m-2"),
        (east(of_file={"comment": "All radiances are in uW/(cm^2 nm sr)."}), "its text says 'uW/.cm"),
        (east(radiance={"unit": "W m-2 nm-1 sr-1"}), "its text says 'W m-2 nm-1 sr-1'"),
        (east(azimuth=DEGREES | {"long_name": "azimuth N-E-S-W"}), "does not say clearly|contradict"),
        (east(azimuth=DEGREES | {"long_name": "azimuth, pvlib convention"}), "'pvlib' is not understood"),
        (east().isel(zenith=4), "one zenith angle, and its coordinate 'zenith' has no dimension; give it one"),
    ],
)
def test_what_would_be_another_sky_is_refused(field, why):
    with pytest.raises(FieldError, match=why):
        read(field)


@pytest.mark.parametrize(
    ("field", "why", "advice"),
    [
        (
            east(zenith={"long_name": "zenith angle of the direction of propagation"}),
            "'propagation'.*goes to",
            "the zenith",
        ),
        (east(zenith={"comment": "the photons travel to"}), "'travel'.*goes to", "the zenith angle"),
        (
            east(of_file={"comment": "All directions are directions of propagation."}),
            "'propagation'.*goes to",
            "the zenith",
        ),
        (ABOVE.assign_coords(zenith=("zenith", BELOW_90, DEGREES)), "no angles below 90", "them"),
        (
            ABOVE.assign_coords(zenith=("zenith", BELOW_90, DEGREES)).rename(zenith="nadir_angle"),
            "from the nadir|nadir",
            "the angles from",
        ),
    ],
)
def test_directions_that_light_goes_to_are_refused(field, why, advice):
    with pytest.raises(FieldError, match=why) as error:
        read(field)
    assert f"180 degrees minus {advice}" in error.value.advice


@pytest.mark.parametrize(
    "texts",
    [
        {"radiance": {"scale": 1.0, "offset": 0}},
        {"radiance": {"comment": "catalogue of skies, image of 1000 x 1000 pixels"}},
        {"radiance": {"long_name": "sky radiance, quality controlled, uncertainty 3 %", "nodata": ""}},
        {"of_file": dict.fromkeys(("title", "comment"), "Monte Carlo model of light propagation")},
        {"of_file": dict.fromkeys(("title", "comment"), "photons travel through the sea")},
        {"zenith": {"long_name": "zenith angle, 0 = overhead, 90 = horizon"}},
        {"zenith": {"long_name": "mu = cos(zenith angle) is 1 overhead"}},
        {"unit": "unit"},
        {"unit": "Units"},
        {"unit": "UNITS"},
    ],
)
def test_texts_that_are_no_doubt(texts):
    field = east(**{part: text for part, text in texts.items() if part != "unit"})
    if "unit" in texts:  # another spelling of its name
        field.radiance.attrs = {texts["unit"]: UNIT}
    table = read(field)
    assert table.radiance_unit == pytest.approx(1e-3)
    assert min(brightest(table), 360 - brightest(table)) < 1


@pytest.mark.parametrize("fill", [-999.9, 0.3333])
def test_a_fill_value_of_float64_is_that_of_float32(fill, tmp_path):
    pytest.importorskip("h5netcdf")
    field = east(radiance={"missing_value": fill}, change=with_pixel(fill))
    field.assign(radiance=field.radiance.astype("f4")).to_netcdf(tmp_path / "field.nc", engine="h5netcdf")
    with xarray.open_dataset(tmp_path / "field.nc", engine="h5netcdf") as stored:
        table = read(stored)
    assert any("1 of 240 directions have no value" in one for one in table.remarks)


def test_what_stands_beside_the_radiances(tmp_path, capsys):
    field = east(radiance={"cell_measures": "area: omega"}, name="I").squeeze("wavelength", drop=True)
    field["omega"] = (("zenith", "azimuth"), np.ones((10, 24)))
    assert run(field, tmp_path, "--wavelengths", 550, "--dry-run") == 0
    field = east()
    field["pixel_quality"] = (field.radiance.dims, np.zeros(field.radiance.shape, "i1"))
    field["cloud"] = (field.radiance.dims, np.zeros(field.radiance.shape, "i1"), {"flag_meanings": "clear cloudy"})
    field["ship_flag"] = ("station", [1, 2])
    assert run(field, tmp_path, "--dry-run") == 0
    shown = capsys.readouterr()
    assert "'pixel_quality cloud' of the file, on the quality of the radiances, is not used" in shown.out + shown.err


@pytest.mark.parametrize(("nines", "is_asked"), [(999.9, True), (9999.9, True), (9999.0, True), (99.9, False)])
@pytest.mark.parametrize("dtype", ["f4", "f8"])
def test_nines_far_beyond_all_other_radiances_are_a_question(nines, is_asked, dtype):
    """At one of two wavelengths, with larger radiances at the other one."""
    bright = east(change=lambda values: values * 100).assign_coords(wavelength=[440.0])
    nine = east(change=lambda values: np.where(np.arange(values.size).reshape(values.shape) == 50, nines, values / 10))
    both = xarray.concat([bright, nine], "wavelength").astype(dtype)
    both.wavelength.attrs["units"] = "nm"
    if not is_asked:
        assert read(both).values[1].max() > 60
        return
    shown = f"{nines:g}"
    with pytest.raises(FieldError, match=f"1 radiance is {shown}, and the next one is 30; is {shown} a gap") as error:
        read(both)
    assert error.value.advice.startswith("write NaN for a gap, or ")
    assert read(east(change=lambda one: one + 9999.0 - one.max())).values.max() > 9900


@pytest.mark.parametrize("name", ["cos_theta", "cosine_of_zenith_angle", "cos_vza", "cos_zenith"])
def test_cosines_have_names(name):
    field = east().isel(zenith=slice(None, None, -1))
    cosine = np.cos(np.deg2rad(field.zenith.values))
    made = field.assign_coords(zenith=("zenith", cosine, {"units": "1"})).rename(zenith=name)
    expected, table = (read(one) for one in (field, made))
    np.testing.assert_allclose(table.values, expected.values, rtol=1e-12)
    with pytest.raises(FieldError, match="no coordinate of zenith angles"):
        read(made.rename({name: "cos_solar_zenith"}))


def test_texts_of_c_and_of_latin_1_are_read(tmp_path):
    """C writes the NUL at the end of its texts, and old programs a degree sign in one byte."""
    pytest.importorskip("h5netcdf")
    h5py = pytest.importorskip("h5py")
    from aomc_sky.formats.netcdf import read_field

    ends = east(
        azimuth={"units": "deg\0", "long_name": "azimuth clockwise from north\0"}, radiance={"units": f"{UNIT}\0"}
    )
    ends.to_netcdf(tmp_path / "c.nc", engine="scipy")
    east().to_netcdf(tmp_path / "latin.nc", engine="h5netcdf")
    with h5py.File(tmp_path / "latin.nc", "a") as file:
        file["zenith"].attrs["units"] = np.bytes_(b"\xb0")
    expected = read(east())
    for name in ("c.nc", "latin.nc"):
        table = read(read_field(tmp_path / name))
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
    table = read(points)
    assert not [one for one in table.remarks if "left out" in one]
    assert float(table.radiance(0.0, 0.0, 550.0)) * table.radiance_unit == pytest.approx(0.130, rel=1e-3)
