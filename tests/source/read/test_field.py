"""A netCDF field as the sky of a scene: [sky] table of sky.toml."""

import shutil

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.fault_rows import command
from tests.support.fields import angles_of, field_of
from tests.support.shared import INPUTS

xarray = pytest.importorskip("xarray")
pytest.importorskip("h5netcdf")

ZENITH, AZIMUTH, NM = np.linspace(4.5, 85.5, 10), np.arange(10.0, 360.0, 20.0), [390.0, 460.0, 555.0, 670.0]
VALUES = np.random.default_rng(3).lognormal(size=(4, 10, 18))


def field(values=VALUES, wavelength_nm=NM):
    return field_of(values, ZENITH, AZIMUTH, wavelength_nm)


def scene_folder(folder, toml='[sky]\ntable = "field.nc"\n', made=None, scene="perez_sky"):
    shutil.copytree(INPUTS / scene, folder, dirs_exist_ok=True)
    (folder / "sky.toml").write_text(toml)
    (field() if made is None else made).to_netcdf(folder / "field.nc", engine="h5netcdf")
    return folder / "amc.inp"


def test_the_sky_of_a_scene_is_the_field_and_difcol_has_the_beam(tmp_path):
    scene = sky.read_scene(scene_folder(tmp_path))
    assert [c.name for c in scene.components] == ["direct", "sky"]
    table = sky.TabulatedSky.from_xarray(field())
    bands = scene.wavebands.wavelength_nm
    fraction = np.loadtxt(tmp_path / "difcol.inp", skiprows=1)[:, 0]
    for band in range(scene.wavebands.n_bands):
        row = scene.row_of_band[band]
        expected = table.lower(bands[band])[0]
        np.testing.assert_array_equal(scene.components[1].mass[row], expected.mass[0])
        assert scene.components[0].strength[row] == fraction[band]
        assert scene.components[1].strength[row] == 1 - fraction[band]
    np.testing.assert_array_equal(scene.sky_wavelength_nm, table.wavelength_nm[table.table_index(bands)])
    assert scene.options["field"]["file"] == "field.nc"
    assert any("the field of sky.toml the rest" in note for note in scene.notes)
    assert scene.input_files["table"] == str(tmp_path / "field.nc")


def test_a_band_takes_the_nearest_wavelength_of_two_the_longer(tmp_path):
    path = scene_folder(tmp_path, made=field(VALUES[:2], [412.0, 612.0]))
    (tmp_path / "lambbot.inp").write_text("4\n412 0.1 0\n512 0.1 0\n511 0.1 0\n700 0.1 0\n")
    with pytest.warns(sky.InputWarning, match=r"E310.*1 of 4 wavebands lie outside .* waveband 4 at 700 nm takes 612"):
        scene = sky.read_scene(path)
    assert scene.sky_wavelength_nm.tolist() == [412.0, 612.0, 412.0, 612.0]
    assert any("2 of 4 wavebands lie more than 5 nm from the wavelengths" in note for note in scene.notes)
    assert scene.components[1].mass.shape[0] == len(np.unique(scene.row_of_band))


def test_a_field_without_wavelengths_serves_all(tmp_path):
    scene = sky.read_scene(scene_folder(tmp_path, made=field().isel(wavelength=0, drop=True)))
    assert np.isnan(scene.sky_wavelength_nm).all()
    assert any("same at all wavelengths" in note for note in scene.notes)


def scattered():
    """Points around a sun at the zenith angle 35 degrees, in the azimuth 0; one comes twice."""
    rng = np.random.default_rng(1)
    zenith, azimuth = np.rad2deg(np.arccos(rng.uniform(0, 1, 300))), rng.uniform(0, 360, 300)
    zenith[0], azimuth[0] = zenith[1], azimuth[1]
    mu = sky.directions.travel_from_sky(np.deg2rad(zenith), np.deg2rad(azimuth)) @ sky.directions.travel_from_sky(
        np.deg2rad(35.0), 0.0
    )
    radiance = np.outer([0.02, 0.03, 0.04], 0.1 + np.exp(-3 * np.arccos(mu)))
    radiance[:, 0] *= 1.05
    coords = angles_of("point", zenith, azimuth) | {"wavelength": ("wavelength", [440.0, 550, 670], {"units": "nm"})}
    made = xarray.DataArray(radiance, dims=("wavelength", "point"), coords=coords, name="radiance")
    return made.assign_attrs(units="W m-2 nm-1 sr-1")


AMOUNTS = {"dni": 500.0, "dhi": 60.0}
"""About those of the sky of `scattered`."""
NORTH = {"sun_zenith_deg": 36.0, "sun_azimuth_deg": 89.0, "azimuth_convention": "clockwise from north"}


def to_north(made):
    """The same with azimuths clockwise from north, and the sun that the file states."""
    made = made.assign_coords(azimuth=(made.azimuth.dims, np.mod(90 - made.azimuth.values, 360), {"units": "degree"}))
    return made.assign_attrs(NORTH)


FIELDS = {
    "grid": (field(VALUES[:3], [440.0, 550, 670]), False),
    "points, sun of the caller": (scattered(), True),
    "points, sun of the file": (to_north(scattered()), False),
}


@pytest.mark.parametrize("name", FIELDS)
def test_one_field_is_one_plan_alone_in_sky_toml_and_in_python(name, tmp_path):
    """The sun of amc.inp, of options, of an argument or of the file guides the interpolation of points alike."""
    made, has_sun = FIELDS[name]
    path = scene_folder(tmp_path, made=made, scene="clear_day")
    sun = {"sun_zenith_deg": 35.0, "sun_azimuth_deg": 0.0} if has_sun else {}
    words = ["--sun-zenith", 35, "--sun-azimuth", 0] if has_sun else []
    out = ["--iterations", 1000, "--format", "none", "--out", tmp_path / "out", "--quiet"]
    assert command("run", tmp_path / "field.nc", *words, *out) == 0
    alone = sky.Plan.load(tmp_path / "out" / "plan.npz")
    table = sky.TabulatedSky.from_xarray(made, **sun)
    in_python = sky.Scene(wavebands=[440, 550, 670], n_photons=1000, components=table)
    assert alone == sky.read_scene(path, iterations=1000).source().plan == in_python.source().plan
    assert [band.sky_wavelength_nm for band in alone.bands] == [440, 550, 670]
    assert any("1 of 299 directions come more than once" in note for note in table.remarks) == (made.ndim == 2)


@pytest.mark.parametrize(
    "angle", [{"azimuth_deg": 8.0}, {"zenith_deg": 39.0}, {"zenith_deg": 39.0, "azimuth_deg": 8.0}]
)
def test_angles_of_the_sun_that_are_asked_for_win_over_the_file_and_amc_inp(angle, tmp_path):
    """The other angle is that of the file; the field is interpolated around this sun, which is that of the beam."""
    pytest.importorskip("pvlib")
    path = scene_folder(tmp_path, made=to_north(scattered()), scene="clear_day")
    sun = {"zenith_deg": 36.0, "azimuth_deg": 1.0} | angle
    scene = sky.read_scene(path, sun=angle, iterations=1000, perez=AMOUNTS)
    assert (scene.options["sun"]["zenith_deg"], scene.options["sun"]["azimuth_deg"]) == tuple(sun.values())
    table = sky.TabulatedSky.from_xarray(scattered(), **{f"sun_{name}": value for name, value in sun.items()})
    mass = scene.components[-1].mass[scene.row_of_band]
    np.testing.assert_array_equal(mass, table.lower([440.0, 550.0, 670.0])[0].mass)


def test_with_flag_1_it_replaces_the_sky_file_and_an_option_wins_over_it(tmp_path):
    path = scene_folder(tmp_path, made=field(wavelength_nm=[440.0, 550.0, 555.0, 670.0]), scene="clear_day")
    scene = sky.read_scene(path)
    assert [c.name for c in scene.components] == ["sky"]
    assert sky.read_scene(path, weighting="solid-angle").components[0].law is sky.component.Law.CELL_MU
    uniform = sky.read_scene(path, sky="uniform")
    assert "sky.toml: table is not used: another sky is asked for" in uniform.notes
    assert "table" not in uniform.input_files
    assert "field" not in uniform.options


def test_absolute_units_and_backgrounds_stand_beside_it(tmp_path):
    toml = '[sky]\ntable = "field.nc"\ndiffuse_irradiance = [0.4, 0.3, 0.2, 0.1]\n'
    scene = sky.read_scene(scene_folder(tmp_path, toml=toml))
    np.testing.assert_allclose(scene.irradiance.of_component[:, 1], [0.4, 0.3, 0.2, 0.1])


GIVEN = """[sky]
table = "field.nc"
variable = "sky"
isel = { member = 0 }
elevation = "a"
azimuth = "b"
wavelength = "c"
angle_unit = "rad"
azimuth_convention = "north_clockwise"
wavelength_unit = "um"
radiance_unit = "relative"
"""


@pytest.mark.parametrize("is_stated", [False, True])
def test_what_is_said_beside_the_file_stands_for_it_and_wins_over_it(is_stated, tmp_path):
    """All that a file does not state; and other words of the file, that are wrong."""
    expected = sky.read_scene(scene_folder(tmp_path))
    made = field().drop_attrs().expand_dims(member=2).copy()
    made[1] = 77.0
    made = made.assign_coords(
        zenith=np.deg2rad(90 - ZENITH), azimuth=np.deg2rad(90 - AZIMUTH), wavelength=np.divide(NM, 1000)
    )
    data = xarray.Dataset({"sky": made.rename(zenith="a", azimuth="b", wavelength="c")}).assign(error=made[0] + 1.0)
    data["radiance"] = data["sky"] * 2.0
    if is_stated:
        for name in "ab":
            data[name].attrs = {"units": "degree_true", "azimuth_convention": "clockwise from south"}
        data["c"].attrs["units"], data["sky"].attrs["units"] = "nm", "cd m-2"
    scene = sky.read_scene(scene_folder(tmp_path, toml=GIVEN, made=data))
    for one, other in zip(scene.components, expected.components, strict=True):
        np.testing.assert_allclose(one.mass, other.mass, rtol=1e-12)
        np.testing.assert_array_equal(one.cell, other.cell)
    assert scene.options["field"]["isel"] == {"member": 0}
    (tmp_path / "sky.toml").write_text(GIVEN[: GIVEN.index("angle_unit")])
    if not is_stated:
        with pytest.raises(sky.InputFileError) as error:
            sky.read_scene(tmp_path / "amc.inp")
        assert [one.code for one in error.value.problems] == ["E710"] * 4


def test_advice_of_sky_toml_names_keys(tmp_path):
    made = field().drop_attrs().rename(azimuth="vaa")
    with pytest.raises(sky.InputFileError) as error:
        sky.read_scene(scene_folder(tmp_path, made=made))
    said = " ".join(one.advice for one in error.value.problems)
    for words in ('azimuth = "vaa"', "isel = { vaa = 0 }", "angle_unit deg or rad", "wavelength_unit nm"):
        assert words in said, words
    assert "--" not in said


def test_a_field_that_is_dark_where_diffuse_light_is_needed(tmp_path):
    dark = VALUES.copy()
    dark[1] = 0.0
    with pytest.raises(sky.SceneError, match=r"field of sky.toml is dark at 450 nm, but 0\.2 of the light"):
        sky.read_scene(scene_folder(tmp_path, made=field(dark)))


def test_options_that_a_field_cannot_use(tmp_path):
    path = scene_folder(tmp_path)
    with pytest.raises(sky.UsageError, match=r"--limits \(limits=\) is not used: the sky is the field of sky.toml"):
        sky.read_scene(path, perez={"limits": "paper"})
    scene = sky.read_scene(path, perez={"epsilon": 3.0, "delta": 0.2, "spectrum": "flat"})  # before difcol.inp
    assert scene.components[0].strength == pytest.approx([0.667] * len(scene.components[0].strength), abs=5e-4)
    assert any(note.startswith("difcol.inp: its direct fractions are not used") for note in scene.notes)
    with pytest.raises(sky.UsageError, match="weighting 'listed' is for sky files"):
        sky.read_scene(path, weighting="listed")
    (tmp_path / "field.nc").unlink()
    sky.read_scene(scene_folder(tmp_path, made=field(1.0 + 0 * VALUES)), sun={"zenith_deg": 20.0})
