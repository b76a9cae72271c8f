"""[[background]] and [sky] of a scene: components in one absolute unit, shares, the horizon, and what is refused."""

import dataclasses
import json
import warnings

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.errors import InputFileError, SceneError, UsageError
from aomc_sky.source.light.brightness import InBands
from aomc_sky.source.light.join import Light, in_absolute_units
from tests.support.scenes import copy_scene
from tests.support.shared import INPUTS

h5py = pytest.importorskip("h5py")

WAVELENGTH = [400.0, 500.0, 700.0]
FLAT = [2e-9, 2e-9, 2e-9]
BACKGROUND = "[[background]]\nfile = 'glow.h5'\ntime = 0\n"


def write_glow(folder, animations, name="glow.h5"):
    sky.lobes.write_background(folder / name, sky.lobes.background_of_lobes(animations, WAVELENGTH))


def glow(**shape):
    return sky.lobes.SkyLobe(**{"kind": "hg", "width": 0.0, "spectrum": FLAT, **shape})


@pytest.fixture
def perez(tmp_path):
    """A scene of sun and Perez sky, with a background-sky file beside it that it does not name yet."""
    amc = copy_scene("perez_sky", tmp_path)
    write_glow(amc.parent, {"town": glow(), "perez": glow(kind="ggx", width=0.5, zenith_deg=60.0)})
    return amc


LISTED = '[sky]\nweighting = "listed"\n'


def add(amc, text):
    with open(amc.parent / "sky.toml", "a") as file:
        file.write(f"\n{text}")
    return amc


def irradiances(scene):
    return scene.irradiance.of_component


def plane_irradiance(lobes, wavelength_nm):
    """Radiance times cosine over the hemisphere, by Gauss points in zenith angle and even ones in azimuth."""
    nodes, weights = np.polynomial.legendre.leggauss(100)
    zenith = (nodes + 1) * np.pi / 4
    azimuth = np.arange(240) * 2 * np.pi / 240
    values = lobes.radiance(zenith[:, None], azimuth[None, :], wavelength_nm).mean(axis=1) * 2 * np.pi
    return float(np.sum(weights * np.pi / 4 * values * np.sin(zenith) * np.cos(zenith)))


def test_the_night_scene_is_what_its_radiance_integrates_to():
    """Read, and made in Python."""
    scene = sky.read_scene(INPUTS / "night_sky")
    assert [c.law.name for c in scene.components] == ["GGX", "GGX", "HG"]
    assert scene.options["sky"] == "none"
    background = sky.read_background(INPUTS / "night_sky" / "night.h5", utc_offset_h=1.0)
    lobes = sky.background_at(background, 1771104600.0)
    whole = irradiances(scene).sum(axis=1)
    for band, wavelength in enumerate(scene.wavebands.wavelength_nm):
        assert whole[band] == pytest.approx(plane_irradiance(lobes, wavelength), rel=1e-6)
    sphere = background.irradiance(None, 1771104600.0, scene.wavebands.wavelength_nm)
    above = background.irradiance(None, 1771104600.0, scene.wavebands.wavelength_nm, above="horizon")
    np.testing.assert_allclose(scene.irradiance.horizon_loss, 1 - above / sphere, rtol=0, atol=1e-12)
    made = sky.Scene(wavebands=scene.wavebands.wavelength_nm, n_photons=1000, components=(lobes,))
    np.testing.assert_allclose(irradiances(made), irradiances(scene), rtol=1e-12)
    np.testing.assert_allclose(made.irradiance.horizon_loss, scene.irradiance.horizon_loss, rtol=0, atol=1e-10)


def test_the_night_scene_has_the_brightness_that_its_sources_give():
    s10 = 3.63e-11 * 10 ** (-0.4 * 27.78) * (180 * 3600 / np.pi) ** 2
    assert s10 == pytest.approx(1.19e-11, rel=0.01)
    background = sky.read_background(INPUTS / "night_sky" / "night.h5")
    v_band = np.arange(500.0, 601.0, 10.0)
    full = 86400 * 20 / 24  # 20:00, all lamps on

    def radiance(name, zenith_deg, azimuth_deg):
        one = dataclasses.replace(background, animations={name: background.animations[name]})
        angles = np.deg2rad([zenith_deg, azimuth_deg])
        return float(sky.background_at(one, full).radiance(*angles, v_band).mean())

    assert radiance("starlight", 20.0, 70.0) == pytest.approx(75 * s10, rel=1e-5)
    assert radiance("airglow", 0.0, 0.0) == pytest.approx(145 * s10, rel=1e-5)
    assert radiance("airglow", 60.0, 0.0) / radiance("airglow", 0.0, 0.0) == pytest.approx(1.93, abs=0.01)
    walker = 0.01 * 200_000 * 30.0**-2.5
    assert radiance("city", 45.0, 205.0) == pytest.approx(walker * 220 * s10, rel=1e-5)


def test_sun_sky_and_lobes_share_the_photons_by_irradiance(perez):
    add(perez, "[sky]\ndiffuse_irradiance = [1e-9, 2e-9, 4e-9, 0.0]\n" + BACKGROUND)
    scene = sky.read_scene(perez, iterations=100_000)
    names = [c.name for c in scene.components]
    assert names == ["direct", "perez", "perez (2)", "town"]
    fraction = np.array([0.74, 0.80, 0.86, 0.90])
    diffuse = np.array([1e-9, 2e-9, 4e-9, 0.0])
    found = irradiances(scene)
    np.testing.assert_allclose(found[:, 0], diffuse * fraction / (1 - fraction), rtol=1e-14)
    np.testing.assert_array_equal(found[:, 1], diffuse)
    np.testing.assert_allclose(found[:, 3], 2e-9 / 4, rtol=1e-6)  # a quarter of a sphere's light falls on a plane
    source = scene.source(seed=3)
    start = source.plan.component_start
    for band in range(4):
        counts = np.add.reduceat(source.counts[band], start[:-1])
        wanted = found[band] / found[band].sum() * source.n_photons(band)
        assert np.all(np.abs(counts - wanted) < 1)
        assert source.irradiance(band) == dict(zip(names, found[band].tolist(), strict=True))
    json.dumps(dict(scene.options))
    assert scene.options["backgrounds"][0]["file"] == "glow.h5"
    assert scene.options["backgrounds"][0]["time"] == "1970-01-01T00:00:00Z"


def test_a_table_takes_backgrounds_band_by_band(tmp_path):
    amc = copy_scene("sparse_sky", tmp_path)
    write_glow(amc.parent, {"town": glow(spectrum=[4e-9, 8e-9, 4e-9])})
    (amc.parent / "sky.toml").write_text(LISTED + "diffuse_irradiance = [1e-9, 2e-9, 0.0, 1e-9]\n" + BACKGROUND)
    plain_amc = copy_scene("sparse_sky", tmp_path / "plain")
    plain, scene = sky.read_scene(plain_amc), sky.read_scene(amc)
    wavelength = scene.wavebands.wavelength_nm
    np.testing.assert_array_equal(scene.sky_wavelength_nm, plain.sky_wavelength_nm)
    found = irradiances(scene)
    np.testing.assert_array_equal(found[:, 0], [1e-9, 2e-9, 0.0, 1e-9])
    np.testing.assert_allclose(found[:, 1], np.interp(wavelength, WAVELENGTH, [1e-9, 2e-9, 1e-9]), rtol=1e-6)
    for band in (0, 1, 3):  # the table keeps its own shares
        rows = plain.row_of_band[band], scene.row_of_band[band]
        one, other = plain.components[0].mass_of(rows[0]), scene.components[0].mass_of(rows[1])
        np.testing.assert_allclose(other / other.sum(), one / one.sum(), rtol=1e-14)


@pytest.mark.parametrize(
    ("scene", "missing"), [("perez_sky", "diffuse"), ("sparse_sky", "diffuse"), ("beam_only", "direct")]
)
def test_relative_light_and_a_background_need_the_lines_that_are_shown(scene, missing, tmp_path):
    amc = copy_scene(scene, tmp_path)
    write_glow(amc.parent, {"town": glow()})
    add(amc, BACKGROUND)
    with pytest.raises(InputFileError) as caught:
        sky.read_scene(amc)
    (problem,) = caught.value.problems
    assert (problem.code, caught.value.exit_code) == ("E708", 3)
    lines = str(caught.value).partition("\n\n")[2]
    n_bands = len((amc.parent / "lambbot.inp").read_text().split("\n")) - 2
    assert [line.partition(" ")[0] for line in lines.split("\n") if "=" in line] == [f"{missing}_irradiance"]
    assert lines.count("0.1") == n_bands
    toml = amc.parent / "sky.toml"  # what is shown can be written, in the [sky] that is there
    toml.write_text(lines + toml.read_text().replace("[sky]\n", ""))
    assert 0.1 in irradiances(sky.read_scene(amc))[0]


def test_one_brightness_of_two_is_refused(tmp_path):
    amc = add(copy_scene("beam_only", tmp_path), "[sky]\ndiffuse_irradiance = [0.0, 1.0]\n")
    message = r"nothing says it of the direct light(?s:.*)direct_irradiance = \[0\.1, 0\.1\]"
    with pytest.raises(InputFileError, match=message):
        sky.read_scene(amc)


IRRADIANCES = "[sky]\ndiffuse_irradiance = [0.4, 0.3, 0.2, 0.1]\ndirect_irradiance = [0.1, 0.2, 0.0, 0.9]\n"


@pytest.mark.parametrize(
    ("scene", "model"), [("perez_sky", ""), ("perez_sky", "overcast"), ("sparse_sky", ""), ("sparse_sky", "uniform")]
)
def test_irradiances_of_beam_and_sky_are_their_shares(scene, model, tmp_path):
    """Version 0.3 ended in "nothing else says how much of the light is direct"."""
    amc = copy_scene(scene, tmp_path)
    (amc.parent / "difcol.inp").unlink(missing_ok=True)
    (amc.parent / "sky.toml").write_text(IRRADIANCES + f'model = "{model}"\n' * bool(model))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sky.InputWarning)  # the clearness of a Perez sky is computed
        found = sky.read_scene(amc, iterations=100_000)
    np.testing.assert_allclose(irradiances(found)[:, 0], [0.1, 0.2, 0.0, 0.9], rtol=1e-12)
    np.testing.assert_allclose(irradiances(found)[:, 1:].sum(axis=1), [0.4, 0.3, 0.2, 0.1], rtol=1e-12)
    beam = found.source().counts[:, 0]
    assert np.all(np.abs(beam - 100_000 * np.array([0.2, 0.4, 0.0, 0.9])) <= 1)
    if scene == "sparse_sky" and not model:
        assert (amc.parent / "skydist.inp").exists()
        assert [c.name for c in found.components] == ["direct", "sky"]


def test_components_of_a_sky_share_its_irradiance_by_strength():
    """One that has no mass in a waveband has no part of it."""
    grid = sky.PatchGrid.regular(1, 2)
    parts = {"direct": (0.5, [[1, 0]]), "one": (0.1, [[0.2, 0], [0, 0], [0.2, 1]]), "other": (0.3, [[0, 1]])}
    components = [
        Component(
            name=name,
            law=Law.CELL_MU2,
            strength=np.full(3, strength),
            mass=np.array(mass, dtype=np.float64),
            cell=cells_of_grid(grid),
            grid=grid,
        )
        for name, (strength, mass) in parts.items()
    ]
    bands = sky.Wavebands(wavelength_nm=np.array([400.0, 500.0, 600.0]))
    light = Light(components=tuple(components), row_of_band=np.arange(3))
    level = InBands(direct_fraction=np.full(3, 0.5), direct=np.full(3, 2.0), diffuse=np.array([4.0, 8.0, 12.0]))
    found = in_absolute_units(light, bands, None, level).irradiance.of_component
    np.testing.assert_allclose(found, [[2, 1, 3], [2, 0, 8], [2, 3, 9]], rtol=1e-15)


NIGHT = '[sky]\nmodel = "none"\n'


@pytest.mark.parametrize("scene", ["perez_sky", "sparse_sky"])
def test_a_night_reads_neither_difcol_nor_skydist(scene, tmp_path):
    amc = copy_scene(scene, tmp_path)
    write_glow(amc.parent, {"town": glow()})
    for name in ("difcol.inp", "skydist.inp"):
        if (amc.parent / name).exists():
            (amc.parent / name).write_text("nonsense")
    if scene == "sparse_sky":
        (amc.parent / "sky.toml").unlink()
    add(amc, NIGHT + BACKGROUND)
    night = sky.read_scene(amc, iterations=500)
    assert [c.name for c in night.components] == ["town"]
    assert set(night.n_photons.tolist()) == {500}
    used = [note for note in night.notes if "[perez] and [sun] are not used" in note]
    assert bool(used) == (scene == "perez_sky")


def test_the_argument_wins_over_the_model_of_the_file(tmp_path):
    night = copy_scene("night_sky", tmp_path)
    with pytest.raises(InputFileError, match="how much of the light is direct"):
        sky.read_scene(night, sky="perez")
    (night.parent / "sky.toml").write_text('[sky]\nmodel = "uniform"\n[perez]\ndni = 0\ndhi = 100\n')
    assert [c.name for c in sky.read_scene(night).components] == ["uniform"]
    with pytest.raises(UsageError, match=r"no \[\[background\]\]"):
        sky.read_scene(night, sky="none")
    with pytest.raises(UsageError, match="not used"):
        sky.read_scene(copy_scene("night_sky", tmp_path / "other"), sun={"zenith_deg": 20.0})


def test_light_below_the_horizon_is_told(perez):
    down = glow(kind="ggx", width=0.3, zenith_deg=180.0)
    write_glow(perez.parent, {"town": glow(), "under": down})
    scene = sky.read_scene(add(perez, NIGHT + BACKGROUND))
    assert [c.name for c in scene.components] == ["town"]
    assert any("below the horizon" in note and "under" in note for note in scene.notes)
    np.testing.assert_allclose(scene.irradiance.horizon_loss, 0.75, rtol=1e-6)  # half of one and all of the other
    write_glow(perez.parent, {"under": down})
    with pytest.raises(SceneError, match="all their lobes lie below the horizon"):
        sky.read_scene(perez)
    write_glow(perez.parent, {"dark": glow(factor=0.0)})
    with pytest.raises(SceneError, match="no light at that time"):
        sky.read_scene(perez)


def test_several_files_times_and_animations(perez):
    write_glow(perez.parent, {"a": [glow(time_days=0.25), glow(time_days=0.75, factor=3.0)], "b, c": glow()}, "two.h5")
    with h5py.File(perez.parent / "two.h5", "r+") as file:
        file["SpectralCurves"].attrs["note"] = "Werte mal 1000"
    text = "[[background]]\nfile = 'two.h5'\ntime = 43200\nanimation = 'a'\n"
    scene = sky.read_scene(add(perez, NIGHT + BACKGROUND + text + "[[background]]\nfile='two.h5'\ntime=43200\n"))
    assert [c.name for c in scene.components] == ["1:perez", "1:town", "2:a", "3:a", "3:b_ c"]
    np.testing.assert_allclose(irradiances(scene)[:, 2], 2 * 2e-9 / 4, rtol=1e-6)  # half way from 1 to 3
    assert set(scene.input_files) == {"amc", "lambbot", "sky_toml", "background_1", "background_2", "background_3"}
    said = 'background two.h5: the file says "note: Werte mal 1000" (texts change nothing)'
    assert [note for note in scene.notes if "says" in note] == [said]


def test_turning_lobes_and_local_midnight(perez):
    """At midnight the first key holds; at noon two keys, or one that turns."""
    keys = [glow(kind="ggx", width=0.2, zenith_deg=z, time_days=t) for t, z in ((0.25, 0.0), (0.75, 60.0))]
    write_glow(perez.parent, {"moving": keys})
    add(perez, NIGHT + BACKGROUND)
    for more, names in (
        ("", ["moving"]),
        ("utc_offset = 12", ["moving:0", "moving:1"]),
        ('interpolation = "slerp"', ["moving"]),
    ):
        assert [c.name for c in sky.read_scene(add(perez, more)).components] == names


def test_every_problem_of_every_file_at_once(perez):
    (perez.parent / "lambbot.inp").write_text("1\n400 1.5 0\n")
    (perez.parent / "broken.h5").write_bytes(b"nothing")
    for file, animation in (("broken", "town"), ("absent", "town"), ("glow", "twn")):
        add(perez, f"[[background]]\nfile = '{file}.h5'\ntime = 0\nanimation = '{animation}'\n")
    with pytest.raises(InputFileError, match="the nearest is town") as caught:
        sky.read_scene(perez)
    codes = [problem.code for problem in caught.value.problems]
    assert codes[-3:] == ["E501", "E500", "E709"]
    assert any(code.startswith("E2") for code in codes)
    assert "it has perez, town" in str(caught.value)


def test_a_wavelength_outside_the_spectra(perez):
    (perez.parent / "lambbot.inp").write_text("4\n" + "".join(f"{w} 0 0\n" for w in (400.0, 500.0, 600.0, 750.0)))
    with pytest.raises(SceneError, match="750 nm is outside"):
        sky.read_scene(add(perez, NIGHT + BACKGROUND))
