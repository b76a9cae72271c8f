"""What a field says of its angles, bounds and missing values is used as it stands, or is one sentence."""

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.fields import field_of, through_a_file

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
    ring_values = np.arange(1.0, 7.0)
    values = ring_values[:, None] * np.where((AZIMUTH >= 60) & (AZIMUTH < 150), 2.0, 1.0)
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
        {"to_unit": lambda angle: np.cos(np.deg2rad(angle)), "name": "mu"},
        {"to_unit": lambda angle: 90 - angle, "name": "elevation"},
        {"flip": True},
        {"wrap": True},
    ],
    ids=["degrees", "radians", "float32", "cosines", "elevations", "descending", "wrapped"],
)
def test_bounds_are_the_edges_of_patches(how):
    """Cap and unequal rings in any unit, order and turn: the irradiance of the bounds, not of half-way edges."""
    table = read(quads(**how))
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
    remarks = read(quads().isel(zenith=slice(1, 5), azimuth=[0, 1, 2, 4, 5, 6, 7, 8, 9, 10, 11])).remarks
    assert any("no radiance from 0 to 5 degrees from the zenith" in one for one in remarks)
    assert any("no radiance from 85 to 90 degrees from the zenith" in one for one in remarks)
    assert any("no radiance at azimuths 75 to 105 degrees" in one for one in remarks)
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
    assert error.value.advice


RINGS_OF_FOUR = sky.TabulatedSky(
    wavelength_nm=[550.0],
    values=[[5.0, 5.0, 5.0, 5.0, 1.0, 2.0, 3.0, 4.0, 1.0, 1.0, 1.0, 1.5]],
    grid=sky.PatchGrid(
        zenith_bounds_deg=[[0, 10], [10, 30], [30, 90]], azimuth_bounds_deg=[[0, 90], [90, 180], [180, 270], [270, 360]]
    ),
    weighting=sky.Weighting.PROJECTED,
)


@pytest.mark.parametrize("name", ["rings", "inputs/sparse_sky degrees", "inputs/clear_day"])
def test_export_and_read_give_the_same_photons(name, tmp_path):
    """Through netCDF: the radiances, the bounds and the convention are those of the scene, and so are its photons."""
    if name == "rings":
        scene = sky.Scene(wavebands=[550.0], n_photons=100_000, components=RINGS_OF_FOUR)
    else:
        folder, _, bins = name.partition(" ")
        scene = sky.read_scene(folder, iterations=100_000, bins=bins or None)
    source = scene.source(seed=1)
    table = read(through_a_file(sky.to_xarray(source), tmp_path / "run.nc"))
    assert not any("azimuth" in remark for remark in table.remarks)
    bands = scene.wavebands.wavelength_nm
    again = sky.Scene(wavebands=bands, n_photons=100_000, components=table).source(seed=1)
    for band in range(len(bands)):
        one, other = source.photons(band), again.photons(band)
        differing = (one.patch != other.patch).mean()  # a mass one ulp off moves a photon at the edge of a patch
        assert differing < 1e-4
        same = one.patch == other.patch
        np.testing.assert_array_equal(one.uz[same], other.uz[same])
        np.testing.assert_allclose(one.ux[same], other.ux[same], atol=2e-7)


def packed(values, **attributes):
    """A field of equal steps, of as many rings and columns as there are values."""
    n_zenith, n_azimuth = np.shape(values)
    zenith, azimuth = (np.arange(n_zenith) + 0.5) * 90.0 / n_zenith, np.arange(n_azimuth) * 360.0 / n_azimuth
    made = field_of(values, zenith, azimuth, azimuth={"azimuth_convention": "from east"})
    return made.assign_attrs(units="mW m-2 nm-1 sr-1", **attributes)


MISSING = {
    "default-f8": (9.969209968386869e36, {}),
    "default-f4": (np.float32(9.969209968386869e36), {}),
    "1e35": (1e35, {}),
    "valid_range": (9999.0, {"valid_range": [0.0, 500.0]}),
    "valid_max": (501.0, {"valid_max": 500.0}),
    "valid_min": (0.25, {"valid_min": 0.5}),
    "_FillValue": (777.0, {"_FillValue": 777.0}),
    "missing_value": (777.0, {"missing_value": 777.0}),
    "missing_values": (777.0, {"missing_value": [888.0, 777.0]}),
    "-999": (-999.0, {}),
    "nan": (np.nan, {}),
}


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


@pytest.mark.parametrize(
    ("attributes", "brightest"),
    [
        ({"long_name": "azimuth clockwise from north"}, 0.0),
        ({"standard_name": "sensor_azimuth_angle", "comment": "the reference direction is south"}, 180.0),
        ({"long_name": "azimuth clockwise from north", "comment": "direction into which the light goes"}, None),
        ({"long_name": "azimuth relative to the sun"}, 130.0),
        ({"long_name": "azimuth relative to the sun, clockwise"}, 310.0),
        ({"comment": "measured from magnetic north"}, None),
        ({"long_name": "azimuth clockwise from north", "azimuth_convention": "enu_from_east"}, None),
    ],
    ids=str,
)
def test_azimuths_by_their_attributes(attributes, brightest):
    """A sky that is brightest at 90 of the field, with the sun at 40; tests/formats/test_azimuth_words.py has words."""
    azimuth = np.arange(0.0, 360.0, 10.0)
    made = packed(np.tile(2.0 + np.cos(np.deg2rad(azimuth - 90)), (18, 1)))
    made.azimuth.attrs = {"units": "deg"} | attributes
    if brightest is None:
        with pytest.raises(sky.SceneError, match=r"azimuth 'azimuth': .*; write --azimuth-convention \(azimuth_conv"):
            read(made)
        return
    with_sun = {"sun_azimuth_deg": 40.0} if "sun" in str(attributes) else {}
    table = read(made, **with_sun)
    assert table.radiance(1.0, np.deg2rad(brightest), 550.0) == pytest.approx(3.0, rel=0.01)
    assert any("counts" in remark for remark in table.remarks) == bool(with_sun)
    if with_sun:
        with pytest.raises(sky.SceneError, match="write --sun-azimuth"):
            read(made)


ZENITH_NAMES = {
    "altitude": True, "alt": True, "el": True, "elevation_deg": True, "view_altitude_angle": True, "zenith_deg": False,
    "theta": False, "view_zenith_angle": False,
}  # fmt: skip
"""Names of zenith angles, and whether they are elevations."""


@pytest.mark.parametrize("name", ZENITH_NAMES)
def test_elevations_by_their_name(name):
    """A sky that is 3 at the zenith and 1 at the horizon."""
    angle = np.arange(2.5, 90.0, 5.0)
    made = packed(np.tile((1.0 + 2.0 * np.cos(np.deg2rad(angle)) ** 2)[:, None], (1, 36)))
    made = made.assign_coords(zenith=("zenith", 90.0 - angle if ZENITH_NAMES[name] else angle, {"units": "degree"}))
    table = read(made.rename(zenith=name))
    assert table.radiance([0.04, 1.5], [1.0, 1.0], 550.0) == pytest.approx([3.0, 1.0], abs=0.03)


def test_cosines_of_both_signs_and_texts_in_the_place_of_angles():
    mu = np.array([-0.9, -0.5, 0.5, 0.9])
    values = np.array([5.0, 5.0, 1.0, 1.0])[:, None] * np.ones(36)
    coords = {"azimuth": ("azimuth", np.arange(0.0, 360.0, 10.0), {"units": "deg"})}
    for name in ("mu", "umu"):
        made = xarray.DataArray(values, dims=(name, "azimuth"), coords={name: mu, **coords})
        if name == "umu":
            assert read(made).radiance(0.5, 0.0, 550.0) == pytest.approx(5.0)
        else:
            with pytest.raises(sky.SceneError, match="cosines of both signs; which of them are of the sky"):
                read(made)
    with pytest.raises(sky.SceneError, match="coordinate 'azimuth' holds no numbers"):
        read(packed(np.ones((18, 36))).assign_coords(azimuth=[f"N{k}" for k in range(36)]))


@pytest.mark.parametrize(
    ("values", "attributes", "why"),
    [
        ([4400.0, 5500.0], {}, "are they angstroms"), ([4400.0, 5500.0], {"unit": "angstrom"}, None),
        ([18181.0, 20000.0], {"long_name": "wavenumber (cm-1)"}, "has the unit 'wavenumbers'"),
        ([0.44, 0.55], {}, "are they micrometres"), ([440.0, 550.0], {}, None),
        ([4000.0, 8000.0], {"units": "nm"}, None), ([4.4e5, 5.5e5], {"units": "um"}, "20 to 100000 are read"),
    ],
)  # fmt: skip
def test_wavelengths_of_other_units(values, attributes, why):
    made = packed(np.ones((18, 36))).expand_dims(wavelength=np.array(values))
    made = made.assign_coords(wavelength=("wavelength", np.array(values), attributes))
    if why is None:
        expected = np.array(values) * (0.1 if "unit" in attributes else 1.0)
        np.testing.assert_allclose(read(made).wavelength_nm, expected)
    else:
        with pytest.raises(sky.SceneError, match=why):
            read(made)


def closed(zenith, azimuth, unit):
    """Samples of 1 + sin(zenith) with both ends of the hemisphere and of the turn."""
    values = 1 + np.sin(np.linspace(0, np.pi / 2, zenith.size))[:, None] * np.ones(azimuth.size)
    return field_of(values, zenith, azimuth, zenith={"units": unit}, azimuth={"units": unit})


@pytest.mark.parametrize("digits", [np.array, np.float32, lambda a: a.round(4), lambda a: np.float32(a).astype(float)])
def test_rounded_ends_of_closed_grids(digits):
    """float32 and four digits of a radian: no ring is lost at the horizon, no column is gained at 2 pi."""
    zenith, azimuth = np.linspace(0, np.pi / 2, 19), np.linspace(0, 2 * np.pi, 37)
    table = read(closed(digits(zenith), digits(azimuth), "rad"))
    assert (table.grid.n_zenith, table.grid.n_azimuth) == (19, 36)
    assert table.grid.zenith_bounds_deg[-1, 1] == 90.0
    np.testing.assert_allclose(table.grid.azimuth_bounds_deg[[0, -1]], [[-5, 5], [345, 355]], atol=2e-3)
    assert irradiance(table) == pytest.approx(np.pi * 5 / 3, rel=4e-5)  # of samples 5 degrees apart
    assert not any("below the horizon" in remark for remark in table.remarks)


def test_directions_of_float32_radians_are_above_the_horizon():
    angles = np.array([0.0, 0.5, 1.0, np.pi / 2, np.pi / 2, np.pi / 2], np.float32)
    points = {"sky_zenith_rad": angles, "sky_azimuth_rad": np.arange(6.0), "radiance": np.ones(6)}
    assert len(sky.RadianceField.from_points(**points, wavelength_nm=550.0).values[0]) == 6


@pytest.mark.parametrize("name", ["netcdf4", "classic"])
def test_bounds_come_with_a_file(name, tmp_path):
    made = through_a_file(quads(), tmp_path / "quads.nc", "scipy" if name == "classic" else "h5netcdf")
    assert irradiance(read(made)) == pytest.approx(EXACT, rel=1e-12)


@pytest.mark.parametrize("kind", ["relative_azimuth", "raa", "azimuth_from_sun"])
def test_names_of_relative_azimuths(kind):
    made = packed(np.tile(2.0 + np.cos(np.deg2rad(np.arange(0.0, 360.0, 10.0))), (18, 1)))
    made.azimuth.attrs = {"units": "deg"}
    table = read(made.rename(azimuth=kind), sun_azimuth_rad=np.deg2rad(40.0))
    assert table.radiance(1.0, np.deg2rad(40.0), 550.0) == pytest.approx(3.0, rel=0.01)
    assert f"azimuth '{kind}' counts counterclockwise from the sun; the sun is at 40" in table.remarks
