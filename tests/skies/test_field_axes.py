"""What a field states of its angles, wavelengths, bounds and missing values is used as it stands, or is asked."""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.errors import FieldError
from aomc_sky.formats.netcdf import open_netcdf
from tests.support.fields import FROM_EAST, field_of, through_a_file

xarray = pytest.importorskip("xarray")
read = sky.TabulatedSky.from_xarray

EDGES = np.array([0.0, 5.0, 15.0, 35.0, 60.0, 85.0, 90.0])
RINGS = np.column_stack([EDGES[:-1], EDGES[1:]])
AZIMUTH = np.arange(0.0, 360.0, 30.0)


def quads(*, to_unit=np.array, units="degree", name="zenith", flip=False, convention="enu_from_east", wrap=False):
    """Means of patches as HydroLight has them: a cap, unequal rings, and a last ring of 5 degrees; brighter outside.

    The centre of the cap is the zenith, of the others the middle; bounds are those of the CF conventions.
    """
    centre = RINGS.mean(axis=1)
    centre[0] = 0.0
    values = np.arange(1.0, 7.0)[:, None] * np.where((AZIMUTH >= 60) & (AZIMUTH < 150), 2.0, 1.0)
    columns = np.column_stack([AZIMUTH - 15, AZIMUTH + 15])
    columns = np.mod(columns, 360.0) if wrap else columns
    zenith, rings = to_unit(centre), to_unit(RINGS)
    if flip:
        zenith, rings, values = zenith[::-1], rings[::-1, ::-1], values[::-1]
    return xarray.Dataset(
        {"L": (("zenith", "azimuth"), values, {"units": "W m-2 nm-1 sr-1"})},
        coords={
            name: ("zenith", zenith, {"units": units, "bounds": "zenith_bnds"}),
            "azimuth": ("azimuth", AZIMUTH, {"units": "degree", "bounds": "a_bnds", "azimuth_convention": convention}),
        },
    ).assign(zenith_bnds=(("zenith", "nv"), rings), a_bnds=(("azimuth", "nv"), columns))


def irradiance(table):
    return float(table.values[0] @ table.grid.projected_solid_angle_sr)


# pi (sin^2 b - sin^2 a) L of each ring, times the mean 1.25 over the azimuths
EXACT = 1.25 * np.pi * np.sum(np.diff(np.sin(np.deg2rad(EDGES)) ** 2) * np.arange(1.0, 7.0))


@pytest.mark.parametrize(
    "how",
    [
        {},
        {"to_unit": np.deg2rad, "units": "radian"},
        {"to_unit": lambda angle: np.deg2rad(angle).astype(np.float32), "units": "rad"},
        {"to_unit": lambda angle: 90 - angle, "name": "elevation"},
        {"flip": True},
        {"wrap": True},
    ],
    ids=["degrees", "radians", "float32", "elevations", "descending", "wrapped"],
)
def test_bounds_are_the_edges_of_patches(how, tmp_path):
    """Cap and unequal rings in any unit, order and turn: the irradiance of the bounds, not of half-way edges."""
    table = read(quads(**how))
    for engine in ("h5netcdf", "scipy"):
        assert read(through_a_file(quads(**how), tmp_path / "quads.nc", engine)) == table
    np.testing.assert_allclose(table.grid.zenith_bounds_deg, RINGS, atol=1e-5)
    assert table.grid.zenith_bounds_deg[[0, -1], [0, 1]].tolist() == [0.0, 90.0]
    assert np.array_equal(table.grid.zenith_bounds_deg[1:, 0], table.grid.zenith_bounds_deg[:-1, 1])
    assert irradiance(table) == pytest.approx(EXACT, rel=1e-6)
    assert table.slope is None
    half_way = quads(**how).drop_vars(["zenith_bnds", "a_bnds"])
    for axis in half_way.coords.values():
        axis.attrs.pop("bounds")
    assert irradiance(read(half_way)) != pytest.approx(EXACT, rel=1e-3)


@pytest.mark.parametrize(("convention", "brightest"), [("enu_from_east", 90.0), ("north_clockwise", 0.0)])
@pytest.mark.parametrize("wrap", [False, True])
def test_bounds_turn_with_the_azimuths(convention, brightest, wrap):
    """Columns of 45 to 135 degrees are twice as bright."""
    table = read(quads(convention=convention, wrap=wrap))
    for offset, value in ((0.0, 2.0), (44.0, 2.0), (-44.0, 2.0), (46.0, 1.0), (-46.0, 1.0), (180.0, 1.0)):
        at = np.deg2rad((brightest + offset) % 360.0)
        assert table.radiance(np.deg2rad(2.0), at, 550.0) == value, offset
    assert np.ptp(table.grid.azimuth_bounds_deg) == pytest.approx(360.0)


def test_bounds_that_leave_something_out_are_said():
    remarks = " ".join(read(quads().isel(zenith=slice(1, 5), azimuth=[0, 1, 2, 4, 5, 6, 7, 8, 9, 10, 11])).remarks)
    assert "no radiance from 0 to 5 degrees from the zenith" in remarks
    assert "no radiance from 85 to 90 degrees from the zenith" in remarks
    assert "no radiance at azimuths 75 to 105 degrees" in remarks
    even = quads().interp(zenith=np.arange(2.5, 90.0, 5.0))["L"]
    even.zenith.attrs = quads().zenith.attrs
    assert read(even).grid.n_zenith == 18


def with_one_bound(name, place, value):
    made = quads()
    made[name][place] = value
    return made


@pytest.mark.parametrize(
    ("made", "why"),
    [
        (lambda: quads().assign(zenith_bnds=quads().zenith_bnds + 10.0), "'zenith' are not around it"),
        (lambda: quads().assign(a_bnds=quads()["a_bnds"] + 20.0), "'azimuth' are not around it"),
        (lambda: with_one_bound("zenith_bnds", (1, 1), 20.0), "'zenith' overlap"),
        (lambda: with_one_bound("a_bnds", (3, 0), 50.0), "'azimuth' overlap"),
        (lambda: quads().assign(a_bnds=quads()["a_bnds"].T), "'azimuth' have the shape"),
        (lambda: with_one_bound("a_bnds", (3, 0), np.nan), "'azimuth' have the shape .*, or are not finite"),
        (lambda: quads()["L"], "bounds 'zenith_bnds', which are not in this field"),  # a DataArray cannot hold them
    ],
)
def test_bounds_that_are_none(made, why):
    with pytest.raises(sky.SceneError, match=why) as error:
        read(made())
    assert error.value.problems[0].advice


UNIT = "mW m-2 nm-1 sr-1"


def packed(values, **attributes):
    """A field of equal steps, of as many rings and columns as there are values."""
    n_zenith, n_azimuth = np.shape(values)
    zenith, azimuth = (np.arange(n_zenith) + 0.5) * 90.0 / n_zenith, np.arange(n_azimuth) * 360.0 / n_azimuth
    return field_of(values, zenith, azimuth).assign_attrs(units=UNIT, **attributes)


MISSING = {
    "default-f8": (9.969209968386869e36, {}), "default-f4": (np.float32(9.969209968386869e36), {}),
    "valid_range": (9999.0, {"valid_range": [0.0, 500.0]}), "valid_max": (501.0, {"valid_max": 500.0}),
    "valid_min": (0.25, {"valid_min": 0.5}), "_FillValue": (777.0, {"_FillValue": 777.0}), "nan": (np.nan, {}),
    "missing_value": (-999.0, {"missing_value": -999.0}), "missing": (777.0, {"missing_value": [888.0, 777.0]}),
    "-999.9 of float64 in f4": (np.float32(-999.9), {"missing_value": -999.9}),
    "0.3333 of float64 in f4": (np.float32(0.3333), {"missing_value": 0.3333}),
}  # fmt: skip


@pytest.mark.parametrize("name", MISSING)
@pytest.mark.parametrize("is_file", [False, True])
def test_missing_values_are_no_light(name, is_file, tmp_path):
    """One pixel of a uniform sky is missing in every way: the light is that of the others, and the note has it."""
    fill, attributes = MISSING[name]
    values = np.ones((9, 18), np.float32 if name.endswith("f4") else np.float64)
    values[4, 2] = fill
    made = packed(values, **attributes)
    if is_file:
        encoding = {} if "_FillValue" in attributes or "missing_value" in attributes else {"_FillValue": None}
        made = through_a_file(made, tmp_path / "field.nc", encoding={"radiance": encoding})
    table = read(made)
    assert irradiance(table) == pytest.approx(np.pi, rel=1e-6)
    (remark,) = [one for one in table.remarks if "have no value" in one]
    assert "1 of 162 directions" in remark
    assert "have 0.96 % of the light" in remark  # sin 90 degrees sin 10 degrees / 18 of the hemisphere


@pytest.mark.parametrize(
    ("dtype", "fill", "valid"),
    [("i2", -32767, None), ("u2", 65535, None), ("i2", 9999, [0, 5000]), ("i4", 9999, [0, 5000])],
)
def test_packed_numbers_have_their_own_fills_and_ranges(dtype, fill, valid, tmp_path):
    """scale_factor and add_offset: limits of whole numbers are those of the stored numbers."""
    stored = np.full((9, 18), 1000, dtype)
    stored[4, 2] = fill
    made = packed(stored, scale_factor=0.001, add_offset=0.5)
    if valid is not None:
        made.attrs["valid_range"] = np.array(valid, dtype)
    table = read(through_a_file(made, tmp_path / "field.nc"))
    assert irradiance(table) == pytest.approx(1.5 * np.pi, rel=1e-6)
    assert any("1 of 162 directions have no value" in remark for remark in table.remarks)
    with pytest.raises(sky.SceneError, match=r"the field is packed .*; open it with mask_and_scale=True"):
        read(made)


def test_packed_angles_are_not_taken_as_they_are_stored():
    """Rings of 10 degrees in steps of 2 degrees are no rings of 5 degrees."""
    made = packed(np.ones((9, 18)))
    stored = made.assign_coords(zenith=("zenith", made.zenith.values / 2, {"units": "degree", "scale_factor": 2.0}))
    with pytest.raises(sky.SceneError, match="mask_and_scale=True"):
        read(stored)


SLOPE = 1.0 + np.linspace(0.0, 0.9, 162).reshape(9, 18)


@pytest.mark.parametrize(
    ("value", "attributes", "why"),
    [
        (-999.0, {}, "negative or infinite: 1, such as -999; .*_FillValue that the file declares, is a gap"),
        (np.inf, {}, "negative or infinite: 1"),
        (1e35, {}, r"values up to 1e\+35, beyond all radiances; .*_FillValue"),
        (1e20, {}, "1 radiance is 1e[+]20, and the next one is 1.9; is 1e[+]20 a gap"),
        (999.9, {}, "1 radiance is 999.9, and the next one is 1.9; is 999.9 a gap.; write NaN for a gap, or "),
        (9999.0, {}, "is 9999 a gap"),
        (32767.0, {}, "is 32767 a gap"),
        (-99.0, {"missing_value": "-99"}, "missing_value of the field is '-99', and no numbers"),
        (2.0, {"valid_range": "0 to 500"}, "valid_range of the field is '0 to 500', and no numbers"),
    ],
)
@pytest.mark.parametrize("dtype", ["f4", "f8"])
def test_values_that_are_no_radiances_are_refused(value, attributes, why, dtype):
    """Undeclared fill values, infinite ones, and nines far beyond all others at one of two wavelengths."""
    other = np.where(np.arange(162).reshape(9, 18) == 103, value, SLOPE)
    both = xarray.concat([packed(other), 3e4 * packed(SLOPE)], "wavelength").assign_coords(wavelength=[440.0, 550.0])
    both.attrs, both.wavelength.attrs = {"units": UNIT, **attributes}, {"units": "nm"}
    with pytest.raises(FieldError, match=why):
        read(both.astype(dtype))
    near = other if 99 < value < 1e4 else SLOPE
    assert read(packed(np.where(near == value, 5.0, near) + 9999.0 - 5.0)).values.max() > 9900


EVEN = np.arange(0.0, 360.0, 10.0)
BRIGHT_AT_90 = np.tile(2.0 + np.cos(np.deg2rad(EVEN - 90)), (18, 1))
NORTH = "clockwise from north"


def stating(azimuth=None, of_file=None, values=BRIGHT_AT_90, **attributes):
    """A sky that is brightest at azimuth 90 of its own, with attributes of azimuth, file and radiance as given."""
    made = packed(values).assign_attrs(attributes)
    made.azimuth.attrs = {"units": "deg", **(azimuth or {})}
    return made.to_dataset().assign_attrs(of_file or {})


@pytest.mark.parametrize(
    ("azimuth", "of_file", "brightest"),
    [
        ({}, {"azimuth_convention": NORTH}, 0.0),
        ({"azimuth_convention": "north_clockwise"}, {"azimuth_convention": "counterclockwise from east"}, 0.0),
        ({"units": "degree_true"}, {"comment": "clockwise from south"}, 0.0),
        ({"standard_name": "sensor_azimuth_angle"}, {}, 0.0),
        ({"standard_name": "platform_azimuth_angle", "azimuth_convention": NORTH}, {"azimuth_convention": NORTH}, 0.0),
        ({"azimuth_convention": "0 is +x, growing towards +y"}, {}, 90.0),
        ({"long_name": "azimuth of the sky element; 0 is +x, growing towards +y"}, {}, 90.0),
        ({"azimuth_convention": "counterclockwise from the sun"}, {}, 130.0),
        ({}, {"azimuth_convention": "clockwise from the sun"}, 310.0),
    ],
    ids=str,
)
def test_azimuths_by_their_statements(azimuth, of_file, brightest, tmp_path):
    """With the sun at 40, by the argument; also through a file; an argument wins over all that a file states."""
    made = stating(azimuth, of_file)
    sun = {"sun_azimuth_deg": 40.0} if "sun" in str([azimuth, of_file]) else {}
    for field in (made, through_a_file(made, tmp_path / "field.nc")):
        table = read(field, **sun)
        assert table.radiance(1.0, np.deg2rad(brightest), 550.0) == pytest.approx(3.0, rel=0.01)
        assert any("; the sun is at 40" in remark for remark in table.remarks) == bool(sun)
    given = read(made, azimuth_convention="clockwise from south", **sun)
    assert given.radiance(1.0, np.pi, 550.0) == pytest.approx(3.0, rel=0.01)
    if sun:
        with pytest.raises(FieldError, match="write --sun-azimuth"):
            read(made)


@pytest.mark.parametrize(
    ("azimuth", "of_file", "why"),
    [
        ({"long_name": f"azimuth {NORTH}"}, {"comment": "Kiel"}, f'nothing says .*its text says "azimuth {NORTH}"; "K'),
        ({"azimuth_convention": "N to E"}, {}, "'N to E' is no convention"),
        ({"azimuth_convention": ""}, {}, "nothing says"),
        ({"standard_name": "sensor_azimuth_angle", "azimuth_convention": "clockwise from south"}, {}, "and .* differ"),
        ({"units": "degrees_true"}, {"azimuth_convention": "counterclockwise from east"}, "and .* differ"),
    ],
    ids=str,
)
def test_azimuths_that_are_asked_for(azimuth, of_file, why):
    with pytest.raises(FieldError, match=f"azimuth 'azimuth'.*{why}|{why}") as error:
        read(stating(azimuth, of_file))
    assert error.value.problems[0].advice.startswith(
        "write --azimuth-convention (azimuth_convention=) 'clockwise from north'"
    )
    assert error.value.problems[0].field == "azimuth_convention"


SKY = np.tile((1.0 + 2.0 * np.cos(np.deg2rad(np.arange(2.5, 90, 5.0))) ** 2)[:, None], (1, 36))
NAMED = {"zenith_deg": {}, "zenith_rad": {}, "ZENITH": {"units": "rad"}, "elevation_deg": {}, "Elevation_rad": {}}


@pytest.mark.parametrize("name", [*NAMED, "vza", "height"])
def test_zenith_angles_and_elevations_by_their_name_or_an_argument(name):
    """A sky that is 3 at the zenith and 1 at the horizon. Other names want an argument, and the message says so."""
    angle = np.arange(2.5, 90.0, 5.0)
    is_elevation, attributes = name[:2] in ("el", "El", "he"), NAMED.get(name, {"units": "degree"})
    angle = 90 - angle if is_elevation else angle
    angle = np.deg2rad(angle) if "rad" in name + str(attributes) else angle
    made = packed(SKY).assign_coords(zenith=("zenith", angle, attributes)).rename(zenith=name)
    argument = {} if name in NAMED else {"elevation" if is_elevation else "zenith": name}
    if argument:
        with pytest.raises(FieldError, match=r"no coordinate zenith among .*--coordinate zenith=.*or elevation=N"):
            read(made)
    assert read(made, **argument).radiance([0.04, 1.5], [1.0, 1.0], 550.0) == pytest.approx([3.0, 1.0], abs=0.03)


def test_the_name_that_is_offered_is_not_that_of_another_coordinate():
    with pytest.raises(FieldError, match="no coordinate zenith") as error:
        read(packed(SKY).rename(zenith="theta"))
    assert "zenith=azimuth" not in error.value.problems[0].advice


@pytest.mark.parametrize(
    ("values", "name", "attributes", "unit", "nm"),
    [
        ([4400.0, 5500.0], "wavelength", {"units": "angstrom"}, None, [440, 550]),
        ([0.44, 0.55], "wavelength_um", {}, None, [440, 550]),
        ([0.44, 0.55], "Wavelength", {"units": "micrometer"}, None, [440, 550]),
        ([4.4e-7, 5.5e-7], "wavelength", {"units": "m"}, None, [440, 550]),
        ([4.4, 5.5], "wavelength", {"units": "nm"}, "um", [4400, 5500]),
        ([440.0, 550.0], "wavelength_nm", {}, None, [440, 550]),
        ([440.0, 550.0], "wavelength", {}, None, "does not say in which unit it is"),
        ([440.0, 550.0], "wavelength", {"long_name": "in nm"}, None, 'does not say .*; its text says "in nm"'),
        ([440.0, 550.0], "wavelength_um", {"units": "nm"}, None, "has the units um and nm by its name"),
        ([18181.0, 20000.0], "wavelength", {"units": "cm-1"}, None, "has the unit 'cm-1', which is none"),
        ([0.44, 0.55], "wavelength", {"units": "nm"}, None, "wavelengths of 0.44 to 0.55 nm; 20 to 100000 are read"),
    ],
)
def test_units_of_wavelengths(values, name, attributes, unit, nm):
    made = packed(SKY).expand_dims({name: 2}).assign_coords({name: (name, values, attributes)})
    if isinstance(nm, list):
        np.testing.assert_allclose(read(made, wavelength_unit=unit).wavelength_nm, nm)
    else:
        with pytest.raises(FieldError, match=f"{nm}.*; write --wavelength-unit nm, um, m or angstrom"):
            read(made, wavelength_unit=unit)


@pytest.mark.parametrize("name", ["zenith", "azimuth"])
def test_units_of_angles(name):
    """Missing, unknown and contradicting ones are asked; so are degrees that are called radians."""
    made = stating(FROM_EAST, values=SKY)["radiance"]
    for attributes, why in (
        ({}, "does not say in which unit it is"),
        ({"units": "gon"}, "has the unit 'gon', which is none"),
        ({"units": "degree", "unit": "rad"}, "is in degree by its name and in rad by its attribute|degree.* rad"),
    ):
        made[name].attrs = {key: made[name].attrs[key] for key in FROM_EAST if key in made[name].attrs} | attributes
        with pytest.raises(FieldError, match=why) as error:
            read(made)
        assert error.value.problems[0].advice.startswith("write --angle-unit deg or rad (angle_unit=)")
        np.testing.assert_array_equal(read(made, angle_unit="deg").values, read(packed(SKY)).values)
    with pytest.raises(FieldError, match=r"goes to 20053\.5 degrees; are its units radians"):
        read(packed(SKY), angle_unit="rad")


def test_all_questions_of_a_field_come_together():
    made = packed(SKY).expand_dims(wavelength=[550.0], member=3).to_dataset().assign_attrs(comment="cruise 7")
    for axis in made.coords.values():
        axis.attrs.clear()
    made.radiance.attrs = {"units": "counts"}
    with pytest.raises(FieldError, match="counts") as error:
        read(made)
    asked = [one.field for one in error.value.problems]
    assert asked == ["radiance_unit", "angle_unit", "angle_unit", "azimuth_convention", "wavelength_unit", "isel"]
    assert 'its text says "cruise 7"' in error.value.problems[3].message
    how = {"radiance_unit": "relative", "angle_unit": "deg", "wavelength_unit": "nm", **FROM_EAST}
    expected = read(packed(SKY), radiance_unit="relative")
    np.testing.assert_array_equal(read(made.isel(member=0), **how).values, expected.values)


@pytest.mark.parametrize("name", ["Scale_Factor", "Missing_Value", "Units", "Azimuth_Convention", "standard_name"])
def test_an_attribute_that_states_nothing_is_quoted(name):
    """tests/formats/test_texts_change_nothing.py has sentences."""
    remarks = read(stating({**FROM_EAST, name: "toa"})).remarks
    assert (
        remarks[0] == f'the file says "{"toa" if name == "standard_name" else f"{name}: toa"}" (texts change nothing)'
    )


def test_texts_of_c_and_of_latin_1(tmp_path):
    """C writes the NUL at the end of its texts, and old programs a degree sign in one byte."""
    h5py = pytest.importorskip("h5py")
    expected = stating({"azimuth_convention": NORTH})
    ends = stating({"units": "deg\0", "azimuth_convention": f"{NORTH}\0"}, units=f"{UNIT}\0")
    ends.to_netcdf(tmp_path / "c.nc", engine="scipy")
    expected.to_netcdf(tmp_path / "latin.nc", engine="h5netcdf")
    with h5py.File(tmp_path / "latin.nc", "a") as file:
        file["zenith"].attrs["note"] = np.bytes_(b"in \xb0")
    for name, remark in (("c.nc", "brightest"), ("latin.nc", 'the file says "note: in ')):
        with open_netcdf(tmp_path / name) as (stored, _):
            table = read(stored)
        np.testing.assert_array_equal(table.values, read(expected).values)
        assert table.radiance_unit == 1e-3
        assert table.remarks[0].startswith(remark)


@pytest.mark.parametrize("digits", [np.array, np.float32, lambda a: a.round(4), lambda a: np.float32(a).astype(float)])
def test_rounded_ends_of_closed_grids(digits):
    """float32 and four digits of a radian: no ring is lost at the horizon, no column is gained at 2 pi."""
    zenith, azimuth = np.linspace(0, np.pi / 2, 19), np.linspace(0, 2 * np.pi, 37)
    values = 1 + np.sin(zenith)[:, None] * np.ones(azimuth.size)
    radians = {"units": "rad"}
    table = read(field_of(values, digits(zenith), digits(azimuth), zenith=radians, azimuth=radians))
    assert (table.grid.n_zenith, table.grid.n_azimuth) == (19, 36)
    assert table.grid.zenith_bounds_deg[-1, 1] == 90.0
    np.testing.assert_allclose(table.grid.azimuth_bounds_deg[[0, -1]], [[-5, 5], [345, 355]], atol=2e-3)
    assert irradiance(table) == pytest.approx(np.pi * 5 / 3, rel=4e-5)  # of samples 5 degrees apart
    assert not any("below the horizon" in remark for remark in table.remarks)


def test_directions_of_float32_radians_are_above_the_horizon():
    angles = np.array([0.0, 0.5, 1.0, np.pi / 2, np.pi / 2, np.pi / 2], np.float32)
    points = {"sky_zenith_rad": angles, "sky_azimuth_rad": np.arange(6.0), "radiance": np.ones(6)}
    assert len(sky.RadianceField.from_points(**points, wavelength_nm=550.0).values[0]) == 6


def test_words_on_azimuths_of_the_radiance_and_of_the_file_that_differ_are_an_error():
    made = packed(np.ones((18, 36)))
    made.azimuth.attrs.pop("azimuth_convention")
    made = made.assign_attrs(azimuth_convention="clockwise from north").to_dataset()
    assert read(made) is not None
    with pytest.raises(
        sky.SceneError, match="'clockwise from north' and azimuth_convention 'clockwise from east' differ"
    ):
        read(made.assign_attrs(azimuth_convention="clockwise from east"))
