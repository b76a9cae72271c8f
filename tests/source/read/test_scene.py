"""From files to scenes: meanings, options, and every refusal."""

import math
import shutil
import warnings

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.source.read.table import remarks_of
from tests.support.scenes import write_scene
from tests.support.shared import AOMC, INPUTS


def test_document_example_means_what_the_document_says():
    scene = sky.read_scene(INPUTS / "document_example")
    source = scene.source()
    assert scene.sky_wavelength_nm.tolist() == [550, 550, 650]
    shares = np.array([[10.5, 12.0, 0, 0, 20.0, 0], [8.2, 9.5, 0, 0, 15.3, 0]])
    for band, row in ((0, 0), (2, 1)):
        np.testing.assert_allclose(source.mass(band), shares[row] / shares[row].sum(), rtol=1e-15)
        assert source.counts[band].sum() == 10_000
        assert np.all(np.abs(source.counts[band] - source.expected(band)) < 1)
    assert "of mean cosine 0.9996, not 0.6782" in remarks_of(scene)[0]


@pytest.mark.parametrize("value", ["1e300", "1e39"])
def test_values_beyond_float32(tmp_path, value):
    """The program's reading is compared without a warning of numpy's, and refused where it is asked for."""
    write_scene(tmp_path, sky_text=f"2 2 2 1\n500\n1 1 0 {value}\n1 2 1 1\n")
    scene = sky.read_scene(tmp_path)
    assert "launch no photon" in remarks_of(scene)[0]
    assert scene.source().total == 1000
    for options in ({"bins": "degrees", "weighting": "aomc"}, {"compat": "aomc"}):
        with pytest.raises(sky.InputFileError, match=r"skydist.inp:3:1: error\[E302\].*32-bit"):
            sky.read_scene(tmp_path, **options)


def test_degrees_and_the_seam(tmp_path):
    text = "3 89 360 1\n500\n1 1 0 1.0\n1 45 360 2.0\n1 89 180 3.0\n"
    write_scene(tmp_path, sky_text=text)
    source = sky.read_scene(tmp_path, bins="degrees", weighting="listed").source()
    lit = np.flatnonzero(source.mass(0))
    assert lit.tolist() == [0, 44 * 360, 88 * 360 + 180]
    (tmp_path / "skydist.inp").write_text("2 89 360 1\n500\n1 45 0 1.0\n1 45 360 2.0\n")
    with pytest.raises(sky.InputFileError, match="E309"):
        sky.read_scene(tmp_path, bins="degrees")


@pytest.mark.parametrize(
    ("shape", "reading", "n_more"),
    [
        ((120, 4), {"bins": "degrees"}, 31 * 5),
        ((3, 400), {"bins": "degrees"}, 3 * 40),
        ((93, 1), {"compat": "aomc"}, 6),
    ],
)
def test_a_table_in_other_bins_is_one_problem_with_the_number_of_lines(tmp_path, shape, reading, n_more):
    n_zenith, n_azimuth = shape
    rows = [f"1 {z} {a} 1.0" for z in range(n_zenith, 0, -1) for a in range(n_azimuth + 1)]
    write_scene(tmp_path, sky_text=f"{len(rows)} {n_zenith} {n_azimuth} 1\n500\n" + "\n".join(rows) + "\n")
    with pytest.raises(sky.InputFileError) as caught:
        sky.read_scene(tmp_path, **reading)
    (problem,) = caught.value.problems
    assert problem.code == "E307"
    assert problem.message.endswith(f" (and {n_more - 1} more lines like this)")
    wrong = [k for k, row in enumerate(rows) if int(row.split()[1]) > (90 if "compat" in reading else 89)]
    wrong += [k for k, row in enumerate(rows) if int(row.split()[2]) > 360 and not wrong]
    assert problem.line == 3 + min(wrong)


def test_azimuth_bins_from_one(tmp_path):
    write_scene(tmp_path, sky_text="2 2 4 1\n500\n1 1 1 1.0\n1 2 4 1.0\n")
    with pytest.warns(sky.InputWarning, match="azimuth-bins n"):
        assert sky.read_scene(tmp_path).source().grid.n_azimuth == 5
    source = sky.read_scene(tmp_path, azimuth_bins="n").source()
    assert source.grid.n_azimuth == 4
    assert np.flatnonzero(source.mass(0)).tolist() == [0, 7]
    (tmp_path / "skydist.inp").write_text("1 2 4 1\n500\n1 1 0 1.0\n")
    with pytest.raises(sky.InputFileError, match="E301"):
        sky.read_scene(tmp_path, azimuth_bins="n")


def test_declaration_of_our_own_files_is_obeyed(tmp_path):
    write_scene(tmp_path, sky_text="1 89 359 1\n500\n1 45 0 1.0\n# aomc-sky bins=degrees values=radiance\n")
    scene = sky.read_scene(tmp_path)
    assert (scene.options["bins"], scene.options["weighting"]) == ("degrees", "projected")
    assert sky.read_scene(tmp_path, weighting="listed").options["weighting"] == "listed"


def test_bands_share_the_mass_of_their_wavelength_and_half_photons_round_up(tmp_path):
    scene = sky.read_scene(INPUTS / "sparse_sky")
    assert scene.sky_wavelength_nm.tolist() == [450, 550, 550, 650]  # 500 is a tie: the longer one
    assert len(scene.source().components[0].mass) == 3
    write_scene(tmp_path, difcol="3\n1 0.0005\n1 0.0014999\n1 0\n", bands=(400.0, 500.0, 600.0), flag=0)
    assert sky.read_scene(tmp_path).n_photons.tolist() == [1, 1, 0]


def test_internal_source_shares_exactly():
    scene = sky.read_scene(INPUTS / "sun_and_sky", sky="uniform")
    source = scene.source()
    intensity, fraction = [0.8, 0.95, 1.0, 0.98, 0.9], [0.55, 0.65, 0.72, 0.78, 0.82]
    for band, (i, f) in enumerate(zip(intensity, fraction, strict=True)):
        n = round(i * 400_000)
        assert source.n_photons(band) == n
        assert abs(source.counts[band, 0] - f * n) < 1 + 1e-9


def test_a_waveband_without_photons_is_named(tmp_path):
    """A run leaves such a waveband out of its files."""
    shutil.copytree(INPUTS / "sun_and_sky", tmp_path, dirs_exist_ok=True)
    (tmp_path / "difcol.inp").write_text("5\n0.5 0\n0.5 1\n0.5 0.0000012\n0.5 0.0000013\n0.5 1\n")
    scene = sky.read_scene(tmp_path, sky="uniform")
    assert scene.n_photons.tolist() == [0, 400_000, 0, 1, 400_000]
    assert scene.notes[-1] == "difcol.inp: no photons in wavebands 1, 3, where intensity x iterations is below 1/2"
    assert "no photons" not in str(sky.read_scene(INPUTS / "sun_and_sky", sky="uniform").notes)
    (tmp_path / "difcol.inp").write_text("5\n" + "0.5 1e-7\n" * 5)
    with pytest.raises(sky.SceneError, match=r"difcol.inp gives no photons"):
        sky.read_scene(tmp_path, sky="uniform")
    assert not sky.read_scene(tmp_path, compat="aomc").n_photons.any()  # as the program


@pytest.mark.parametrize("compat", [None, "aomc"])
@pytest.mark.parametrize("intensity", ["1e14", "1e300"])
def test_too_many_photons_are_refused(intensity, compat, tmp_path):
    """Beyond 2^62 and beyond 32-bit floats, without a warning of numpy."""
    shutil.copytree(INPUTS / "sun_and_sky", tmp_path, dirs_exist_ok=True)
    (tmp_path / "difcol.inp").write_text("5\n" + f"0.5 {intensity}\n" * 5)
    with pytest.raises(sky.SceneError, match=r"must not exceed 2\^62 photons in a band, got 1e\+"):
        sky.read_scene(tmp_path, sky="uniform", compat=compat)


def test_no_diffuse_light_no_sky():
    scene = sky.read_scene(INPUTS / "beam_only")
    assert [c.name for c in scene.components] == ["direct"]
    assert "no sky is modelled" in scene.notes[0]
    batch = scene.source().photons(1)
    assert len(batch) == 50_000
    np.testing.assert_allclose(batch.directions[0], [0, -0.5, -np.sqrt(0.75)], atol=1e-7)
    assert np.ptp(batch.ux) == np.ptp(batch.uy) == np.ptp(batch.uz) == 0


NOON = {"time": "2026-06-21T09:30:00Z", "latitude_deg": 54.2, "longitude_deg": 7.9}
SPECTRL2 = {"spectrum": "spectrl2"}
REFUSED = {
    "perez_sky": [
        ({"perez": {"dni": -1.0, "dhi": 1.0}}, "outside the range"),
        ({"perez": {"dni": math.nan, "dhi": 1.0}}, "not finite"),
        ({"perez": {"dni": "850", "dhi": 1.0}}, "not a number"),
        ({"perez": {"dnii": 850.0}}, "no input 'dnii'"),
        ({"perez": {"limits": "none"}}, "limits: 'none' is not one of the known words; write"),
        ({"perez": SPECTRL2}, r"\(spectrum=\) is not used: the light is that of difcol.inp"),
        ({"sun": {"zenith_deg": 90.0}}, "below 90 degrees, got 90 .options and sky.toml.; a sun that has set needs"),
        ({"sun": {"zenith_deg": 181.0}}, "outside the range"),
        ({"sun": {"disc": 1}}, "neither true nor false"),
        ({"weighting": "solid-angle"}, r"--weighting \(weighting=\) is not used: the sky is a perez sky"),
        ({"sky": "uniform", "perez": {"limits": "paper"}}, r"\(limits=\) is not used: the sky is a uniform sky"),
        ({"sky_options": {"type": 1}}, "are for a sky model of another package"),
        ({"compat": "aomc", "perez": {"dni": 1.0, "dhi": 1.0}}, "--compat aomc"),
        ({"compat": "aomc", "sky": "perez"}, "--compat aomc"),
        ({"clear_sky": {"aod_500nm": 0.1}}, r"--aod \(clear_sky=\) is not used: the light is that of difcol"),
        ({"bins": "degrees"}, r"--bins \(bins=\) is not used: the sky is a perez sky"),
    ],
    "document_example": [
        ({"sun": {"zenith_deg": 1.0}}, r"is not used: the scene has no beam; write --sky perez .* for a beam$"),
        ({"sky": "uniform", "sun": {"zenith_deg": 1.0}, "diffuse_only": True}, "not used: the scene has no beam"),
        ({"weather": NOON}, r"\(longitude_deg=\) are not used: the scene has no beam; write --sky perez"),
    ],
    "sparse_sky": [
        ({"compat": "aomc", "bins": "equal"}, "aomc"),
        ({"weighting": "aomc"}, "weighting"),
        ({"sky": "uniform", "weighting": "aomc"}, "a uniform sky has 'projected' or 'solid-angle'"),
        ({"bins": "degrees", "azimuth_bins": "n"}, "bins"), ({"wavebands": [0]}, "waveband 0"),
    ],
    "atmosphere_sky": [
        ({"perez": SPECTRL2}, r"\(spectrum=\) is not used: the light is that of the atmosphere of sky.toml"),
        ({"perez": {"dni": 800.0, "dhi": 90.0}}, "are not used: the light is that of the atmosphere .* --sky pe"),
        ({"weighting": "solid-angle"}, r"\(weighting=\) is not used: the sky is the atmosphere of sky.toml"),
        ({"azimuth_bins": "n"}, r"--azimuth-bins \(azimuth_bins=\) is not used: the sky is the atmosphere"),
    ],
    "night_sky": [({"bins": "degrees"}, r"--bins \(bins=\) is not used: the sky is the backgrounds")],
    "sun_and_sky": [
        ({"compat": "aomc", "perez": SPECTRL2}, r"does not use --spectrum \(spectrum=\)"),
        ({"perez": {"air_mass": "kasten-1966"}}, r"--air-mass .* is not used: the sky is a perez sky"),
    ],
    "beam_only": [
        ({"diffuse_only": True}, r"difcol[.]inp., and --diffuse-only \(diffuse_only=True\) leaves"),
        ({"within": "uniform"}, r"--within .* not used: all light is direct .difcol.inp., so there is no"),
    ],
}  # fmt: skip
"""Scene of inputs/ -> what it cannot use, and what is said."""


@pytest.mark.parametrize(("name", "options", "message"), [(n, *row) for n, rows in REFUSED.items() for row in rows])
def test_what_a_scene_cannot_use(name, options, message):
    if {"weather", "clear_sky"} & options.keys() or options.get("perez") == SPECTRL2:
        pytest.importorskip("pvlib")
    if name == "night_sky":
        pytest.importorskip("h5py")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sky.InputWarning)
        with pytest.raises((sky.UsageError, sky.SceneError), match=message):
            sky.read_scene(INPUTS / name, **options)


def test_with_flag_1_a_sky_that_is_asked_for_has_the_beam_of_the_irradiances():
    pytest.importorskip("pvlib")
    light = {"dni": 850.0, "dhi": 95.0}
    scene = sky.read_scene(INPUTS / "clear_day", sky="perez", perez=light | SPECTRL2)
    assert [c.name for c in scene.components] == ["direct", "perez"]
    sun = {f"sun_{name}": scene.options["sun"][name] for name in ("zenith_deg", "azimuth_deg")}
    expected = sky.weather_scene(wavebands=scene.wavebands, **light, **SPECTRL2, **sun)
    np.testing.assert_allclose(scene.irradiance.of_component, expected.irradiance.of_component, rtol=1e-12)


def test_with_flag_1_a_sun_without_a_beam_is_warned_of():
    with pytest.warns(sky.InputWarning, match="the direct beam of the sun is missing: nothing says how bright it is"):
        scene = sky.read_scene(INPUTS / "document_example", sky="uniform", sun={"zenith_deg": 1.0})
    assert scene.notes == ("all light comes from a uniform sky, which replaces skydist.inp",)


def test_compat_refuses_other_sampling():
    scene = sky.read_scene(INPUTS / "sparse_sky", compat="aomc")
    with pytest.raises(sky.UsageError, match="--compat aomc"):
        scene.source(order="shuffled")
    assert scene.source(order="patch").total > 0


def test_compat_photons_are_lattice_points_in_order():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sky.InputWarning)
        scene = sky.read_scene(INPUTS / "document_example", compat="aomc")
    batch = scene.source(precision="float64").photons(0)
    assert np.all(np.diff(batch.patch) >= 0)
    zenith, azimuth = scene.source().grid.index_of(batch.patch)
    s, c = np.sin(np.deg2rad(zenith)), np.cos(np.deg2rad(zenith))
    expected = np.stack([-s * np.cos(np.deg2rad(azimuth)), -s * np.sin(np.deg2rad(azimuth)), -c], axis=-1)
    np.testing.assert_allclose(batch.directions, expected, atol=1e-15)


@pytest.mark.parametrize("name", ["multiband", "simple_relationship", "mobley1"])
def test_program_inputs(name):
    scene = sky.read_scene(AOMC / "program_inputs" / name)
    assert scene.n_photons.min() >= 1_000_000
    assert scene.source().counts.sum() == scene.n_photons.sum()


def test_all_problems_of_all_files_at_once(tmp_path):
    write_scene(tmp_path, sky_text="1 2 2 1\n500\n1 9 0 1.0\n")
    (tmp_path / "lambbot.inp").write_text("1\n500 1.5 0\n")
    with pytest.raises(sky.InputFileError) as caught:
        sky.read_scene(tmp_path)
    assert {p.code for p in caught.value.problems} == {"E202", "E301"}
    (tmp_path / "skydist.inp").unlink()
    with pytest.raises(sky.InputFileError, match="no such file"):
        sky.read_scene(tmp_path)
