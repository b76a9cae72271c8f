"""Radiance fields with coordinates: conventions give one sky, gaps are reported, fields of real programs are read."""

import dataclasses
import itertools

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.skies.radiance_field import _between_samples
from tests.support.fields import FROM_EAST, NM, angles_of, field_of, radiance, through_a_file

xarray = pytest.importorskip("xarray")
read = sky.TabulatedSky.from_xarray

ZENITH_DEG = np.array([4.0, 15.0, 30.0, 42.0, 55.0, 70.0, 86.0])
AZIMUTH_DEG = np.arange(0.0, 360.0, 30.0)


def field(*, radians=False, descending=False, north=False, order=("wavelength", "zenith", "azimuth"), attributes=True):
    zenith, azimuth = ZENITH_DEG, np.mod(90 - AZIMUTH_DEG, 360) if north else AZIMUTH_DEG
    values = radiance(ZENITH_DEG[:, None], AZIMUTH_DEG, NM[:, None, None])
    to_unit = np.deg2rad if radians else np.asarray
    units = {"units": "radian" if radians else "degree"} if attributes else {}
    convention = ({"azimuth_convention": "north_clockwise"} if north else FROM_EAST) if attributes else {}
    made = xarray.DataArray(
        values,
        dims=("wavelength", "zenith", "azimuth"),
        coords={
            "wavelength": ("wavelength", NM, {"units": "nm"} if attributes else {}),
            "zenith": ("zenith", to_unit(zenith), units),
            "azimuth": ("azimuth", to_unit(azimuth), units | convention),
        },
        attrs={"units": "relative"},
    )
    if descending:
        made = made.isel(zenith=slice(None, None, -1), azimuth=slice(None, None, -1))
    return made.transpose(*order)


def test_a_regular_field_becomes_patches_around_its_points():
    table = read(field())
    edges = [0, 9.5, 22.5, 36, 48.5, 62.5, 78, 90]
    np.testing.assert_allclose(table.grid.zenith_bounds_deg, np.column_stack([edges[:-1], edges[1:]]))
    np.testing.assert_allclose(table.grid.azimuth_bounds_deg[[0, -1]], [[-15, 15], [315, 345]])
    assert table.weighting is sky.Weighting.PROJECTED
    assert table.remarks == ("brightest sky: zenith angle 84, azimuth 90 (north); Ed 4.983 (relative) at 440 nm",)
    for zenith, azimuth in ((15, 60), (86, 330)):
        seen = table.radiance(np.deg2rad(zenith), np.deg2rad(azimuth), NM)
        np.testing.assert_allclose(seen, radiance(zenith, azimuth, NM), rtol=0.02)


PEREZ = sky.PerezSky(epsilon=3.0, delta=0.2, sun_zenith_deg=40.0, sun_azimuth_deg=100.0)


def samples(step_deg, **attributes):
    """A Perez sky in directions `step_deg` apart, the first half a step from the zenith."""
    zenith, azimuth = np.arange(step_deg / 2, 90.0, step_deg), np.arange(0.0, 360.0, step_deg)
    values = PEREZ.radiance(np.deg2rad(zenith)[:, None], np.deg2rad(azimuth), 550.0)
    return field_of(values, zenith, azimuth, zenith=attributes, azimuth=attributes)


def means(directions, flux):
    """Mean cosine, and mean component towards azimuth 50 degrees."""
    x, y, mu = directions
    return np.array([(mu * flux).sum(), ((x * np.cos(0.9) + y * np.sin(0.9)) * flux).sum()]) / flux.sum()


def errors(table):
    """Irradiance (relative) and the means of photons, less those of a dense quadrature of the Perez sky."""
    sin2, azimuth = (np.arange(2000) + 0.5) / 2000, (np.arange(1440) + 0.5) * np.pi / 720
    sine, mu = np.sqrt(sin2)[:, None], np.sqrt(1 - sin2)[:, None]
    flux = PEREZ.radiance(np.arcsin(sine), azimuth, 550.0)
    exact = means((sine * np.cos(azimuth), sine * np.sin(azimuth), mu), flux)
    irradiance = table.values[0] @ table.grid.projected_solid_angle_sr / (np.pi * flux.mean()) - 1
    photons = sky.Scene(wavebands=[550.0], n_photons=200_000, components=table).source(seed=1).photons()
    return np.array([irradiance, *means((-photons.ux, -photons.uy, -photons.uz), np.ones(200_000)) - exact])


def test_samples_of_a_smooth_sky_make_its_light():
    """Errors of samples: of 5 degrees a fifth of those of constant patches at most, of 2 degrees a tenth of these."""
    coarse, fine = (errors(read(samples(step))) for step in (5.0, 2.0))
    assert np.all(np.abs(coarse) < [2e-4, 1e-5, 8e-5])
    assert np.all(np.abs(fine) < [2e-5, 3e-6, 8e-6])
    flat = errors(read(samples(5.0, bounds="bounds")))
    assert np.all(np.abs(flat[1:]) > 5 * np.abs(coarse[1:]))


def test_a_defect_of_slopes_is_seen():
    """Root mean square error of the radiance in random directions, away from the sun."""
    rng, table = np.random.default_rng(2), read(samples(5.0))
    zenith, azimuth = np.arcsin(np.sqrt(rng.uniform(0, 1, 4000))), rng.uniform(2.7, 6.2, 4000)
    exact = PEREZ.radiance(zenith, azimuth, 550.0)

    def error(slope):
        return np.std(dataclasses.replace(table, slope=slope).radiance(zenith, azimuth, 550.0) / exact)

    right = error(table.slope)
    for defect in (-table.slope, table.slope[..., ::-1], table.slope * [0, 1], table.slope * [1, 0]):
        assert error(defect) > 2 * right


def test_no_radiance_is_negative():
    """Noise from 0 to 1000: the monotone cubic has no extremes of its own. One zenith angle has nothing to join."""
    made = field()
    made[:] = np.random.default_rng(3).lognormal(0, 3, made.shape) * (made > 1.3)
    table = read(made)
    assert table.values.min() >= 0
    assert table.values.max() <= float(made.max()) * (1 + 1e-12)
    assert read(made.isel(zenith=[3])).slope is None


@pytest.mark.parametrize("order", list(itertools.permutations(("wavelength", "zenith", "azimuth"))), ids="-".join)
def test_conventions_and_orders_of_one_field_are_one_sky(order, tmp_path):
    """Degrees or radians, up or down, from north or from east, through a file: the same masses, to the bit."""
    expected = read(field()).lower(NM)[0]
    for radians, descending, north in itertools.product((False, True), repeat=3):
        made = field(radians=radians, descending=descending, north=north, order=order)
        if order[0] == "azimuth":
            made = through_a_file(made.rename("radiance"), tmp_path / "field.nc")
        (component,) = read(made).lower(NM)
        np.testing.assert_array_equal(component.mass, expected.mass)
        np.testing.assert_array_equal(component.cell, expected.cell)


def test_what_is_given_and_what_is_taken_for_granted():
    """An argument wins over what the field states, and stands for what it does not state."""
    given = read(field(north=True), azimuth_convention=sky.directions.AzimuthConvention.ENU_FROM_EAST)
    assert abs(given.radiance(0.5, np.deg2rad(90), 440) - radiance(30, 0, 440)) < 0.02
    how = {"angle_unit": "rad", "wavelength_unit": "nm", **FROM_EAST}
    np.testing.assert_array_equal(read(field(radians=True, attributes=False), **how).values, read(field()).values)
    even = read(field().isel(azimuth=0, wavelength=0, drop=True).assign_attrs(units=""))
    assert even.grid.n_azimuth == 1
    said = " ".join(even.remarks)
    assert all(one in said for one in ("same all around", "no wavelength", "no unit of radiance is stated"))
    made = field().assign_coords(solar_zenith_angle=40.0, sza=("wavelength", [40.0, 40.0]), saa=10.0)
    np.testing.assert_array_equal(read(made).values, read(field()).values)
    assert "not used: variables solar_zenith_angle, sza, saa" in read(made).remarks


def test_both_ends_of_the_turn_and_directions_below_the_horizon():
    made = field()
    closed = xarray.concat([made, made.isel(azimuth=[0]).assign_coords(azimuth=[360.0])], "azimuth", join="outer")
    closed.azimuth.attrs.update(made.azimuth.attrs)
    table = read(closed)
    np.testing.assert_array_equal(table.lower(NM)[0].mass, read(made).lower(NM)[0].mass)
    near, far = (closed.copy(data=np.where(closed.azimuth == 360, one, 1.0) * closed) for one in (1.005, 2.0))
    assert "radiances differ by up to 0.5 %" in " ".join(read(near).remarks)
    with pytest.raises(sky.SceneError, match="radiances differ by up to 50 %"):
        read(far)
    below = xarray.concat([made, made.isel(zenith=[0]).assign_coords(zenith=[120.0])], "zenith", join="outer")
    below.zenith.attrs.update(made.zenith.attrs)
    assert "1 zenith angles below the horizon" in read(below).remarks[1]
    assert "no radiance from 48 to 90 degrees" in read(made.isel(zenith=slice(0, 4))).remarks[1]
    assert "no azimuths between 270 and 0 degrees" in read(made.isel(azimuth=slice(0, 10))).remarks[1]
    with pytest.raises(sky.SceneError, match="no azimuths between 180 and 0 degrees"):
        read(made.isel(azimuth=slice(0, 7)))
    assert "one azimuth" in " ".join(read(made.isel(azimuth=[0])).remarks)


def test_scattered_directions_are_interpolated_on_the_sphere():
    rng = np.random.default_rng(4)
    mu, azimuth = np.sqrt(rng.uniform(0.0005, 1, 3000)), rng.uniform(0, 360, 3000)
    zenith = np.rad2deg(np.arccos(mu))
    coords = angles_of("los", zenith, azimuth) | {"wavelength": ("wavelength", NM, {"units": "nm"})}
    made = xarray.DataArray(radiance(zenith, azimuth, NM[:, None]), dims=("wavelength", "los"), coords=coords)
    table = read(made, grid=sky.PatchGrid.regular(18, 36))
    seen = table.radiance(np.deg2rad(42.5), np.deg2rad([5.0, 105.0, 245.0]), 440.0)
    np.testing.assert_allclose(seen, radiance(42.5, np.array([5.0, 105.0, 245.0]), 440.0), rtol=2e-3)
    with pytest.warns(sky.InputWarning, match="% of the light comes from beyond"):
        remarks = read(made.where(made.zenith < 60)).remarks
    assert any("directions have no value" in remark for remark in remarks)
    assert any("a radiance is off by" in remark for remark in remarks)
    # A table of 300 directions as a field of 300 x 300 with gaps: the grid is the usual one, and the gaps are said.
    rng = np.random.default_rng(5)
    zenith, azimuth = np.rad2deg(np.arccos(rng.uniform(0.02, 1, 300))).round(3), rng.uniform(0, 360, 300).round(3)
    (rows, row), (columns, column) = (np.unique(angle, return_inverse=True) for angle in (zenith, azimuth))
    values = np.full((rows.size, columns.size), np.nan)
    values[row, column] = radiance(zenith, azimuth, 550.0)
    table = read(field_of(values, rows, columns))
    assert table.grid == sky.PatchGrid.regular(90, 180)
    assert any(f"{values.size - 300} of {values.size} directions have no value" in r for r in table.remarks)
    assert not any("no photon comes" in r or "neighbours fill" in r for r in table.remarks)
    exact = sky.FunctionSky(lambda z, a, nm: radiance(np.rad2deg(z), np.rad2deg(a), 550.0)).irradiance(550.0)
    assert table.values[0] @ table.grid.projected_solid_angle_sr == pytest.approx(exact[0], rel=3e-3)


NOT_SAID = {"angle_unit": "deg", "wavelength_unit": "nm", **FROM_EAST}
DEGREES = {"units": "degree"}
SHARED = {
    "zenith": (("a", "b"), np.full((3, 4), 30.0), DEGREES),
    "azimuth": ("b", np.arange(4) * 90.0, DEGREES | FROM_EAST),
}


@pytest.mark.parametrize(
    ("change", "options", "message"),
    [
        (lambda f: f.rename(zenith="height"), {}, "no coordinate zenith among .*'height'"),
        (lambda f: f.isel(zenith=4), {}, "coordinate 'zenith' has no dimension; give it one"),
        (lambda f: f.assign_coords(zenith=180 - ZENITH_DEG), NOT_SAID, "below 90 degrees; are they those that light"),
        (lambda f: f, {"zenith": "vza"}, "no coordinate 'vza'"),
        (lambda f: f.assign_coords(zenith_rad=("zenith", ZENITH_DEG)), {}, "2 coordinates that may be its zenith"),
        (lambda f: f.assign_coords(elevation=("zenith", ZENITH_DEG)), {}, "2 coordinates that may be its zenith"),
        (lambda f: f.assign_coords(zenith=np.deg2rad(ZENITH_DEG)), {}, "write --angle-unit deg or rad"),
        (lambda f: f.expand_dims(stokes=3), {}, r"'stokes' of 3 .* field.isel\(stokes=0\)"),
        (lambda f: -f, {}, "negative or infinite"),
        (lambda f: 0 * f, {}, "no positive value"),
        (lambda f: f.astype(complex), {}, "complex128"),
        (lambda f: f.isel(zenith=[0, 1, 1]), {}, "zenith angle twice"),
        (lambda f: f.assign_coords(azimuth=np.append(np.nan, AZIMUTH_DEG[1:])), NOT_SAID, "not finite"),
        (lambda f: f.assign_coords(azimuth=[f"N{k}" for k in range(12)]), NOT_SAID, "a dimension 'azimuth' of 12"),
        (lambda f: f.assign_coords(wavelength=[440.0, np.nan]), NOT_SAID, "not finite"),
        (lambda f: xarray.Dataset({"L": f}), {"variable": "M"}, "no variable 'M' of numbers"),
        (lambda f: f.isel(zenith=slice(0)), {}, "'zenith' has length 0"),
        (lambda f: f.isel(wavelength=[1, 0, 1]) * [[[1]], [[1]], [[2]]], {}, "550 nm stands .* twice"),
        (lambda f: xarray.Dataset({"L": f, "M": f}), {}, "none of 2 .* the name radiance: 'L', 'M'; .*--variable"),
        (lambda f: f.values, {}, "got ndarray"),
        (lambda f: f > 1, {}, "holds bool instead of real numbers"),
        (lambda f: xarray.DataArray(np.ones((3, 4)), SHARED, ("a", "b")), {}, "share a part of their dimensions"),
    ],
)
def test_refusals_say_what_to_write(change, options, message):
    with pytest.raises(sky.SceneError, match=message) as caught:
        read(change(field()), **options)
    assert "\n" not in str(caught.value)


def test_wavelengths_beyond_those_of_a_table_are_warned_of():
    with pytest.warns(sky.InputWarning, match=r"warning\[E310\]: 1 of 2 .* 440 to 550 nm; waveband 2 at 660 nm"):
        sky.Scene(wavebands=[500.0, 660.0], n_photons=10, components=read(field()))
    one = field().isel(wavelength=0)
    with pytest.warns(sky.InputWarning, match=r"outside the sky's wavelength 440 nm; waveband 2 at 660 nm takes 440"):
        sky.Scene(wavebands=[440.0005, 660.0], n_photons=10, components=read(one))
    sky.Scene(wavebands=[440.0, 660.0], n_photons=10, components=read(one.drop_vars("wavelength")))


GAPS = np.ma.masked_greater(np.where(np.eye(1, 6) > 0, 1e20, 1.0), 1e10)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"wavelength_nm": [500.0] * 2, "values": [[1.0] * 6, [2.0] * 6]}, "500 nm stands in it twice with different"),
        ({"values": GAPS}, "are masked; give them a radiance, 0 where no light comes from"),
        ({"values": np.ones((1, 3, 2))}, "2 rings and 3 columns: the axes are wavelength, zenith, azimuth; swap"),
        ({"radiance_unit": 1.0}, "radiance_unit wants weighting PROJECTED"),
        ({"weighting": "projected", "slope": np.full((1, 6, 2), 2.0)}, "slope"),
        ({"weighting": "projected", "slope": np.full((1, 6, 2), np.nan)}, "slope"),
        ({"weighting": "listed", "slope": np.zeros((1, 6, 2))}, "slope"),
    ],
)
def test_a_table_in_doubt_is_refused(given, message):
    """Rows of one wavelength are equal, and no fill value of a masked array becomes a radiance."""
    good = {"wavelength_nm": [500.0], "values": np.ma.ones((1, 6)), "grid": sky.PatchGrid.regular(2, 3)}
    sky.TabulatedSky(**good)
    with pytest.raises((sky.SceneError, ValueError), match=message):
        sky.TabulatedSky(**good | given)


@pytest.mark.parametrize("shape", [(4, 3, 1), (4, 3)])
def test_a_table_whose_wavelengths_stand_last_is_refused(shape):
    with pytest.raises(sky.SceneError, match=r"radiances of shape \(1, n_zenith, n_azimuth\), got "):
        sky.files.SkyTable(wavelength_nm=np.array([500.0]), radiance=np.ones(shape))


def test_gaps_of_a_regular_field_are_filled_by_neighbours_and_reported():
    made = field()
    made[0, 2, 3] = np.nan
    table = read(made)
    assert any("1 of 84 directions have no value" in remark for remark in table.remarks)
    seen = table.radiance(np.deg2rad(30.0), np.deg2rad(90.0), 440.0)
    assert abs(seen / radiance(30, 90, 440.0) - 1) < 0.03


def points(nm=NM, unit="100 mW m-2 nm-1 sr-1", n=150):
    """Directions of one dimension, each with a wavelength; those of one wavelength are not those of another."""
    rng = np.random.default_rng(6)
    zenith = np.rad2deg(np.arccos(rng.uniform(0.035, 1, n * len(nm))))
    azimuth, point_nm = rng.uniform(0, 360, zenith.size), rng.permutation(np.repeat(nm, n))
    coords = angles_of("point", zenith, azimuth) | {"wavelength": ("point", point_nm, {"units": "nm"})}
    return xarray.DataArray(radiance(zenith, azimuth, point_nm), dims=("point",), coords=coords, attrs={"units": unit})


def test_points_of_their_own_wavelengths_are_the_sky_of_the_same_table(tmp_path):
    made = points()
    table = read(made)
    np.testing.assert_array_equal(table.wavelength_nm, NM)
    path = tmp_path / "sky.csv"
    rows = zip(made.zenith.values, made.azimuth.values, made.wavelength.values, made.values, strict=True)
    head = ["# azimuth: counterclockwise from east", "# radiance unit: 100 mW m-2 nm-1 sr-1"]
    head = "\n".join([*head, "zenith_deg,azimuth_deg,wavelength_nm,radiance", ""])
    path.write_text(head + "\n".join(",".join(map(repr, map(float, row))) for row in rows))
    csv = sky.read_radiance_csv(path)
    ours, theirs = (sky.Scene(wavebands=NM, n_photons=10, components=one).irradiance for one in (table, csv))
    np.testing.assert_allclose(ours.of_component, theirs.of_component, rtol=1e-4)
    zenith, azimuth = np.deg2rad([20.0, 55.0]), np.deg2rad([100.0, 250.0])
    for nm in NM:
        want = csv.radiance(zenith, azimuth, nm)
        np.testing.assert_allclose(table.radiance(zenith, azimuth, nm) * table.radiance_unit, want, rtol=3e-3)
    two = [field.assign_coords(wavelength=nm) for nm, field in made.groupby("wavelength")]
    each = xarray.concat([one.drop_vars("wavelength") for one in two], "band")
    each = each.assign_coords(wavelength=("band", NM, {"units": "nm"}))
    np.testing.assert_array_equal(read(each).values, table.values)
    made = points()
    with pytest.raises(sky.SceneError, match="1 direction at 400 nm; a measured sky needs 3 or more"):
        read(made.assign_coords(wavelength=("point", np.linspace(400, 700, made.size), {"units": "nm"})))
    with pytest.raises(sky.SceneError, match="'wavelength' has the dimension 'point' of an angle; then zenith"):
        read(made.drop_vars("azimuth"))


def test_units_of_the_field_make_absolute_irradiances():
    """Scattered or regular, with any spelling that the tables of radiances know; without a unit it is relative."""
    regular = field().assign_attrs(units="mW/m2/nm/sr")
    for made, unit in ((points(), 0.1), (points(unit="mW m-2 nm-1 sr-1"), 1e-3), (regular, 1e-3)):
        table = read(made)
        exact = np.array([float(np.sum(row * table.grid.projected_solid_angle_sr)) for row in table.values]) * unit
        scene = sky.Scene(wavebands=NM, n_photons=10, components=table)
        np.testing.assert_allclose(scene.irradiance.of_component[:, 0], exact, rtol=1e-12)
        share = dataclasses.replace(table, strength=1.0)
        assert sky.Scene(wavebands=NM, n_photons=10, components=share).irradiance is None
    for unit in ("", "relative"):
        table = read(field().assign_attrs(units=unit))
        assert sky.Scene(wavebands=NM, n_photons=10, components=table).irradiance is None
    with pytest.raises(sky.SceneError, match="is none of spectral radiance"):
        read(field().assign_attrs(units="cd m-2"))
    read(field().assign_attrs(units="cd m-2"), radiance_unit="relative")


def test_scans_beyond_the_zenith_and_the_sun():
    made = points(nm=NM[:1])
    across = made.assign_coords(angles_of("point", -made.zenith.values, (made.azimuth.values + 180) % 360))
    np.testing.assert_allclose(read(across).values, read(made).values, rtol=1e-5)
    sun = {"sun_zenith_deg": 40.0, "sun_azimuth_deg": 100.0}
    cap = made.where(made.zenith < 60, drop=True)
    with pytest.warns(sky.InputWarning, match=r"say where the sun is \(--sun-zenith .* sun_zenith_deg= and"):
        read(cap)
    with pytest.warns(sky.InputWarning, match=r"extrapolated and may be off by [\d.]+ %$"):
        remarks = read(cap, **sun).remarks
    assert any("on a trend around the sun" in remark for remark in remarks)


SUN = {"sun_zenith_deg": 25.0, "sun_azimuth_deg": 100.0}
NORTH_SUN = {"sun_zenith_deg": 25.0, "sun_azimuth_deg": -10.0}
EAST, NORTH, FROM_SUN = "counterclockwise from east", "clockwise from north", "counterclockwise from the sun"


def sky_of_the_sun(numbers=EAST, words=None):
    """A Perez sky in azimuths that count as `numbers` says, and that are said to be `words`."""
    zenith, azimuth = np.arange(5.0, 90.0, 10.0), np.arange(0.0, 360.0, 10.0)
    values = sky.PerezSky(epsilon=3.0, delta=0.2, **SUN).radiance(
        np.deg2rad(zenith)[:, None], np.deg2rad(azimuth), 550.0
    )
    azimuth = {EAST: azimuth, NORTH: (90 - azimuth) % 360, FROM_SUN: (azimuth - 100) % 360}[numbers]
    return field_of(values, zenith, azimuth, azimuth={"azimuth_convention": words or numbers}).to_dataset()


@pytest.mark.parametrize("words", [NORTH, "counterclockwise from south", "clockwise from the antisun"])
def test_light_that_is_not_where_the_sun_is_gets_a_warning(words):
    """By an argument or by the file; the sky stays the one that is stated."""
    plain, wrong = read(sky_of_the_sun()), sky_of_the_sun(words=words)
    assert read(sky_of_the_sun(), **SUN) == read(sky_of_the_sun().assign_attrs(SUN)) == plain
    for made, given in ((wrong, {}), (sky_of_the_sun(), {"azimuth_convention": words})):
        with pytest.warns(sky.InputWarning, match=f"with azimuths .*{EAST}.* the light would lie around"):
            assert read(made, **SUN, **given).values.max() == pytest.approx(plain.values.max(), rel=1e-9)
    low = sky_of_the_sun().assign_coords(zenith=("zenith", 90 - sky_of_the_sun().zenith.values, DEGREES))
    with pytest.warns(sky.InputWarning, match="are the zenith angles elevations"):
        read(low, **SUN)
    assert read(low, **SUN, elevation="zenith") == plain


@pytest.mark.parametrize("place", ["file", "radiance", "coordinates"])
def test_the_sun_of_a_file(place):
    """Its azimuth counts as the others, or as its own words say; an argument wins."""

    def placed(made, sun):
        if place == "coordinates":
            return made.assign_coords(sun)
        return made.assign(radiance=made.radiance.assign_attrs(sun)) if place == "radiance" else made.assign_attrs(sun)

    made = sky_of_the_sun(NORTH).stack(point=("zenith", "azimuth")).reset_index("point")
    found = read(placed(made, NORTH_SUN))
    assert found == read(made, **SUN) != read(placed(made, NORTH_SUN), sun_zenith_deg=26.0)
    turned = sky_of_the_sun(FROM_SUN)
    with pytest.raises(sky.SceneError, match="nothing says from where sun_azimuth_deg of the file counts"):
        read(placed(turned, NORTH_SUN))
    own = turned.assign_coords(sun_azimuth_deg=((), -10.0, {"azimuth_convention": NORTH}))
    assert read(own) == read(turned, sun_azimuth_deg=100.0)


NO_SUNS = {
    "below": (lambda f: f.assign_attrs({**SUN, "sun_zenith_deg": 200.0}), "sun_zenith_deg of the file is 200"),
    "word": (lambda f: f.assign_attrs({**SUN, "sun_zenith_deg": "low"}), "sun_zenith_deg of the file is not one num"),
    "nan": (lambda f: f.assign_attrs({**SUN, "sun_azimuth_deg": np.nan}), "sun_azimuth_deg of the file is nan"),
    "unit": (lambda f: f.assign_coords({**SUN, "sun_zenith_deg": ((), 0.44, {"units": "rad"})}), "sun_zenith_deg"),
    "two": (lambda f: f.assign_attrs(SUN).assign_coords({**SUN, "sun_azimuth_deg": 280.0}), "sun_azimuth_deg"),
}


@pytest.mark.parametrize("name", NO_SUNS)
def test_a_sun_of_a_file_that_is_none_or_two(name):
    change, why = NO_SUNS[name]
    with pytest.raises(sky.SceneError, match=why):
        read(change(sky_of_the_sun()))


def test_the_zenith_of_points_needs_no_azimuth():
    rings, around = np.meshgrid([15.0, 30, 45, 60, 75, 88], np.arange(0.0, 360, 30))
    zenith, azimuth = np.append(0.0, rings), np.append(np.nan, around)
    made = xarray.DataArray(130 - zenith / 3, dims="point", coords=angles_of("point", zenith, azimuth))
    table = read(made)
    assert not [one for one in table.remarks if "left out" in one]
    assert float(table.radiance(0.0, 0.0, 550.0)) == pytest.approx(130, rel=1e-3)


RINGS_DEG = np.arange(5.0, 90.0, 20.0)


def smooth(zenith_deg, azimuth_deg):
    return 2.0 + 1.9 * np.sin(np.deg2rad(zenith_deg)) * np.cos(np.deg2rad(azimuth_deg))


def field_like(zenith_deg, azimuth_deg, function):
    values = function(*np.meshgrid(zenith_deg, azimuth_deg, indexing="ij"))
    return read(field_of(values, zenith_deg, azimuth_deg))


@pytest.mark.parametrize(("n", "first", "error"), [(4, 0.1, 0.4), (24, 0.25, 0.02), (80, 0.5, 0.01), (120, 0.25, 0.01)])
def test_radiance_beside_the_edges_of_patches(n, first, error):
    table = field_like(RINGS_DEG, first + np.arange(n) * 360.0 / n, smooth)
    edges = table.grid.azimuth_bounds_deg.ravel()
    beside = [np.nextafter(edges, end) for end in (-np.inf, np.inf)]
    azimuth_deg = np.concatenate([edges, *beside, edges + 360.0, edges - 720.0])
    found = table.radiance(np.deg2rad(65.0), np.deg2rad(azimuth_deg), 550.0)
    assert np.abs(found - smooth(65.0, azimuth_deg)).max() < error


@pytest.mark.parametrize("zenith_deg", [[0.0, 45.0, 90.0 - 1e-9, 90.0], [40.0, 41.0]])
def test_a_constant_field_has_no_slope(zenith_deg):
    table = field_like(np.array(zenith_deg), np.arange(0.0, 360.0, 30.0), lambda zenith, _: np.ones(zenith.shape))
    assert np.all(table.slope == 0)
    np.testing.assert_allclose(table.values, 1.0, rtol=1e-14)


@pytest.mark.parametrize("scale", [5e-324, 1e-310, 9e29])
def test_fields_of_any_magnitude(scale):
    table = field_like(
        RINGS_DEG, np.arange(0.0, 360.0, 30.0), lambda zenith, _: np.where(zenith < 40, scale, 0.5 * scale)
    )
    assert np.all(np.isfinite(table.values))
    assert table.values.max() == pytest.approx(scale, rel=0.01, abs=0.0)
    assert np.all(np.abs(table.slope) <= 1)


@pytest.mark.parametrize("first_zenith_deg", [0.0, 10.0])
@pytest.mark.parametrize("turn_deg", [-100.0, 7.0, 190.0])
def test_turned_samples_give_turned_patches(turn_deg, first_zenith_deg):
    """Across the zenith, too, where the sky goes on on the other side."""
    zenith, azimuth = first_zenith_deg + np.arange(0.0, 81.0, 20.0), np.arange(0.0, 360.0, 45.0)
    values = np.random.default_rng(4).uniform(1.0, 2.0, (zenith.size, azimuth.size))
    edges = np.concatenate([[0.0], zenith[:-1] + 10.0, [90.0]])
    rings = np.stack([edges[:-1], edges[1:]], axis=1)

    def patches(turn):
        columns = np.stack([azimuth - 22.5, azimuth + 22.5], axis=1) + turn
        grid = sky.PatchGrid(zenith_bounds_deg=rings, azimuth_bounds_deg=columns)
        return _between_samples(zenith, azimuth + turn, values, grid)

    for found, expected in zip(patches(turn_deg), patches(0.0), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
