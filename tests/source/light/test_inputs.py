"""Which inputs of the sun and of the Perez sky win, what they mean, and every refusal."""

import math
import shutil
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import aomc_sky as sky
from aomc_sky.formats.aomc.amc import LightSource
from aomc_sky.formats.sky_toml.sections import PerezSection, SunSection
from aomc_sky.options import listed, say
from aomc_sky.skies.direct_beam import SOLAR_RADIUS_DEG
from aomc_sky.source.light.brightness import InBands, direct_fraction
from aomc_sky.source.light.place import Sun
from aomc_sky.source.light.said import said_by_caller
from aomc_sky.source.light.skies import MEDIAN_DELTA, shape_of_shares
from tests.support.scenes import change_config
from tests.support.shared import INPUTS

FLAT = {"spectrum": "flat"}
"""One direct fraction for all wavebands without difcol.inp, and no warning of it."""
DERIVED = "difcol.inp: the sky's clearness"


def scene_folder(tmp_path, *, toml=None, difcol=None):
    """The scene perez_sky with another sky.toml and difcol.inp; None leaves a file out."""
    folder = tmp_path / "scene"
    shutil.copytree(INPUTS / "perez_sky", folder)
    for name, text in (("sky.toml", toml), ("difcol.inp", difcol)):
        (folder / name).unlink()
        if text is not None:
            (folder / name).write_text(text)
    return folder


DIFCOL = "4\n0.74 0.72\n0.80 0.94\n0.86 1.00\n0.90 0.88\n"
TOML = "[perez]\ndni = 850.0\ndhi = 95.0\n"


def perez_of(scene):
    return scene.options["perez"]


def test_options_win_over_sky_toml_and_sky_toml_over_difcol(tmp_path):
    folder = scene_folder(tmp_path, toml=TOML, difcol=DIFCOL)
    assert perez_of(sky.read_scene(folder))["from"].endswith("(sky.toml)")
    with pytest.warns(sky.InputWarning, match="every waveband has the broadband direct fraction 0.667 of epsilon 3"):
        options = sky.read_scene(folder, perez={"epsilon": 3.0, "delta": 0.25})
    assert perez_of(options)["from"] == "epsilon 3 and Delta 0.25 (options)"
    assert (perez_of(options)["epsilon"], perez_of(options)["delta"]) == (3.0, 0.25)
    asked = sky.read_scene(folder, perez={"epsilon": 3.0, "delta": 0.25} | FLAT)
    np.testing.assert_array_equal(asked.source().counts, options.source().counts)
    strengths = [c.strength.tolist() for c in asked.components]
    assert strengths == [[pytest.approx(0.667, abs=5e-4)], [pytest.approx(0.333, abs=5e-4)]]  # and not those of difcol
    np.testing.assert_array_equal(asked.n_photons, [360_000, 470_000, 500_000, 440_000])  # but its intensities
    said = "not used: the light is that of epsilon 3 and Delta 0.25 (options)"
    assert asked.notes[-2:] == (f"sky.toml: [perez] is {said}", f"difcol.inp: its direct fractions are {said}")
    (folder / "sky.toml").unlink()
    with pytest.warns(sky.InputWarning, match=DERIVED):
        derived = sky.read_scene(folder)
    assert perez_of(derived)["from"].endswith("(difcol.inp)")


def test_the_sun_wins_value_by_value(tmp_path):
    folder = scene_folder(tmp_path, toml=f"{TOML}[sun]\nzenith_deg = 31.75\ndisc = true\n", difcol=DIFCOL)
    scene = sky.read_scene(folder, sun={"azimuth_deg": 200.5})
    sun = {"zenith_deg": 31.75, "azimuth_deg": 200.5, "disc": True, "from": "sky.toml and options"}
    assert scene.options["sun"] == sun
    assert scene.components[0].law.name == "DISC"
    assert sky.read_scene(folder, sun={"disc": False}).components[0].law.name == "BEAM"
    uniform = sky.read_scene(folder, sky="uniform", sun={"zenith_deg": 60.0, "disc": False})
    batch = uniform.source(precision="float64").photons(0)
    assert batch.uz[batch.patch == 0][0] == pytest.approx(-0.5, abs=1e-12)


def test_the_disc_has_the_suns_radius(tmp_path):
    scene = sky.read_scene(scene_folder(tmp_path, toml=TOML, difcol=DIFCOL), sun={"disc": True, "zenith_deg": 0.0})
    batch = scene.source(precision="float64").photons(0)
    angle = np.rad2deg(np.arccos(-batch.uz[batch.patch == 0]))
    assert 0.99 * SOLAR_RADIUS_DEG < angle.max() <= SOLAR_RADIUS_DEG * (1 + 1e-9)


def test_nothing_given_shows_the_lines_to_write(tmp_path):
    folder = scene_folder(tmp_path)
    with pytest.raises(sky.InputFileError) as caught:
        sky.read_scene(folder)
    shown = str(caught.value)
    assert "difcol.inp: error[E100]" in shown
    coefficients = {"a": -1.0, "b": -0.3, "c": 10.0, "d": -3.0, "e": 0.45}
    with pytest.raises(sky.InputFileError, match="do not say how much"):
        sky.read_scene(folder, perez=coefficients)
    lines = shown.splitlines()
    start = lines.index("[perez]")
    (folder / "sky.toml").write_text("\n".join(lines[start : start + 3]) + "\n")
    by_file = sky.read_scene(folder, perez=FLAT)
    assert perez_of(by_file)["from"] == "dni 850 and dhi 95 W m-2 (sky.toml)"
    shaped = sky.read_scene(folder, perez=coefficients | FLAT)  # dni and dhi of the file stay
    assert perez_of(shaped)["from"] == "coefficients -1, -0.3, 10, -3, 0.45 (options)"
    assert perez_of(shaped)["coefficients"] == list(coefficients.values())
    strengths = [[c.strength.tolist() for c in scene.components] for scene in (shaped, by_file)]
    assert strengths[0] == strengths[1]
    assert strengths[0][0] == [pytest.approx(0.884, abs=1e-3)]
    assert not any("not used" in note for note in shaped.notes)


@pytest.mark.parametrize(
    ("fraction", "zenith_deg", "expected"), [(0.0, 10.0, 0), (0.3, 60.0, None), (0.6, 30.0, None), (0.95, 0.0, 7)]
)
def test_difcol_stands_in(fraction, zenith_deg, expected):
    spread = np.array([fraction, min(fraction + 0.04, 1.0), max(fraction - 0.02, 0.0)])
    weight, sun = np.array([1.0, 0.5, 2.0]), Sun(zenith_deg=zenith_deg, azimuth_deg=0.0)
    with pytest.warns(sky.InputWarning, match="too low, often by a bin"):
        amounts = shape_of_shares(InBands(direct_fraction=spread, intensity=weight, who="difcol.inp"), sun)
    mean = float(np.average(spread, weights=[1.0, 0.5, 2.0]))
    z = math.radians(zenith_deg)
    epsilon = 1 + mean / ((1 - mean) * math.cos(z)) / (1 + 1.041 * z**3)
    assert amounts.epsilon == pytest.approx(epsilon, rel=1e-12)
    bins = [1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2]
    row = sum(epsilon >= edge for edge in bins)
    assert expected in (None, row)
    assert amounts.delta == MEDIAN_DELTA[row]
    assert direct_fraction(amounts, sun) == pytest.approx(mean, abs=1e-12)


def test_flag_one_takes_the_perez_sky_instead_of_its_file(tmp_path):
    folder = scene_folder(tmp_path, toml=TOML)
    change_config(folder / "amc.inp", light_source=LightSource.FILE)
    scene = sky.read_scene(folder, sky="perez", perez=FLAT)
    assert [c.name for c in scene.components] == ["direct", "perez"]
    assert scene.n_photons.tolist() == [500_000] * 4
    beam = 850.0 * math.cos(math.radians(scene.options["sun"]["zenith_deg"]))
    assert scene.components[0].strength == pytest.approx([beam / (beam + 95.0)], rel=1e-12)
    assert scene.notes[0].startswith("dni 850 and dhi 95 W m-2 (sky.toml), the broadband share in every waveband")
    assert not any("missing" in note for note in scene.notes)
    flag_0 = scene_folder(tmp_path / "0", toml=TOML)
    assert sky.read_scene(flag_0, perez=FLAT).source(seed=1).plan.sha256 == scene.source(seed=1).plan.sha256
    alone = sky.read_scene(folder, sky="perez", perez=FLAT, diffuse_only=True)
    assert [c.name for c in alone.components] == ["perez"]
    direct = sky.read_scene(folder, sky="perez", perez={"dni": 850.0, "dhi": 0.0})
    assert [c.name for c in direct.components] == ["direct"]
    assert direct.notes[0].endswith("all light is direct, so no sky is modelled")
    (folder / "sky.toml").unlink()
    with pytest.raises(sky.UsageError, match=r"(?s)needs dni and dhi.*\[perez\]"):
        sky.read_scene(folder, sky="perez")


def test_a_sky_file_leaves_sky_toml_alone_and_says_so(tmp_path):
    folder = tmp_path / "scene"
    shutil.copytree(INPUTS / "document_example", folder)
    plain = sky.read_scene(folder)
    (folder / "sky.toml").write_text(TOML)
    scene = sky.read_scene(folder)
    said = 'sky.toml: [perez] is not used: the sky is skydist.inp; write --sky perez (sky="perez") for another sky'
    assert scene.notes == (*plain.notes, said)
    np.testing.assert_array_equal(scene.source().counts, plain.source().counts)
    (folder / "sky.toml").write_text("[perez]\ndni = 850.0\n")
    with pytest.raises(sky.InputFileError, match="E705"):
        sky.read_scene(folder)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sky.InputWarning)
        assert "sky_toml" not in sky.read_scene(folder, compat="aomc").input_files


@pytest.mark.parametrize("name", [None, "uniform", "overcast"])
def test_a_beam_beside_a_sky_file_is_launched_where_it_is_asked_for(name):
    alone = sky.read_scene(INPUTS / "document_example", sky=name)
    both = sky.read_scene(
        INPUTS / "document_example", sky=name, perez={"dni": 500.0, "dhi": 100.0} | FLAT, sun={"zenith_deg": 60.0}
    )
    assert [c.name for c in both.components] == ["direct", *(c.name for c in alone.components)]
    fraction = 500.0 * 0.5 / (500.0 * 0.5 + 100.0)
    for band in range(both.wavebands.n_bands):
        cosine = alone.source().exact_moments(band).mean_mu
        expected = fraction * 0.5 + (1 - fraction) * cosine
        assert both.source().exact_moments(band).mean_mu == pytest.approx(expected, rel=1e-12)


IRRADIANCE = st.floats(0, 10_000)
WEATHER = st.one_of(
    st.fixed_dictionaries({"dni": IRRADIANCE, "dhi": IRRADIANCE}),
    st.fixed_dictionaries({"dni": IRRADIANCE, "ghi": IRRADIANCE}),
    st.fixed_dictionaries({"epsilon": st.floats(1, 1.7e308), "delta": st.floats(0, 1e300)}),
)


@given(WEATHER, st.floats(0, 90, exclude_max=True))
def test_any_weather_splits_the_light_or_is_refused(weather, zenith_deg):
    (caller,) = said_by_caller(perez=weather)
    amounts = caller.perez
    try:
        fraction = direct_fraction(amounts, Sun(zenith_deg=zenith_deg, azimuth_deg=0.0))
    except sky.SceneError:
        assert "epsilon" not in weather
        return
    assert fraction is not None
    assert 0 <= fraction <= 1


@given(
    st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1e308)), min_size=1, max_size=5),
    st.floats(0, 90, exclude_max=True),
)
def test_any_difcol_stands_in(rows, zenith_deg):
    fractions, weight = np.array(rows).T
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sky.InputWarning)
        light = InBands(direct_fraction=fractions, intensity=weight, who="difcol.inp")
        section = shape_of_shares(light, Sun(zenith_deg=zenith_deg, azimuth_deg=0.0))
    assert section.epsilon is not None
    assert section.epsilon >= 1
    assert section.delta in MEDIAN_DELTA


def test_numbers_of_numpy_are_numbers():
    sun, perez = {"disc": np.bool_(True), "zenith_deg": 3}, {"dni": np.float32(850), "dhi": np.int64(95)}
    (caller,) = said_by_caller(perez=perez, sun=sun)
    assert caller.perez == PerezSection(dni=850.0, dhi=95.0)
    assert caller.sun == SunSection(disc=True, zenith_deg=3.0)


WORDS = {
    "{time} needs {latitude_deg}; write {spectrum:spectrl2} or {diffuse_only:True}": "--time (time=) needs --latitude "
    '(latitude_deg=); write --spectrum spectrl2 (spectrum="spectrl2") or --diffuse-only (diffuse_only=True)',
    "{zenith_deg}, {disc:False}, {disc:True}, {row:7}": "--sun-zenith (sun_zenith_deg=), --no-disc (sun_disc=False), "
    "--disc (sun_disc=True), --row 7 (row=7)",
    "{sky:perez}, {polarisation:0.75}": '--sky perez (sky="perez"), --polarisation 0.75 (polarisation=)',
}


@pytest.mark.parametrize("template", WORDS)
def test_an_input_has_both_its_names(template):
    assert say(template) == WORDS[template]


def test_a_list_of_inputs_names_each_once():
    assert listed(["dhi", "disc:False", "dhi"]) == "--dhi (dhi=) and --no-disc (sun_disc=False)"


@pytest.mark.parametrize(
    ("line", "argument"),
    [
        ('limits = "paper"', {"perez": {"limits": "paper"}}),
        ('within = "uniform"', {"within": "uniform"}),
        ('air_mass = "kasten-1966"', {"perez": {"air_mass": "kasten-1966"}}),
        ("extraterrestrial_normal = 1300.0", {"perez": {"extraterrestrial_normal": 1300.0}}),
    ],
)
@pytest.mark.filterwarnings("ignore:Perez sky, epsilon 3, Delta 0.9")
def test_a_key_of_the_model_is_the_argument(tmp_path, line, argument):
    toml = "[perez]\nepsilon = 3.0\ndelta = 0.9\n" if line.startswith("limits") else TOML
    folder = scene_folder(tmp_path, toml=f"{toml}{line}\n", difcol=DIFCOL)
    by_key = sky.read_scene(folder)
    (folder / "sky.toml").write_text(toml)
    by_argument, plain = sky.read_scene(folder, **argument), sky.read_scene(folder)
    plans = [scene.source(1).plan.sha256 for scene in (by_key, by_argument, plain)]
    assert plans[0] == plans[1] != plans[2]
    name, value = next(iter(argument.get("perez", argument).items()))
    assert perez_of(by_key)[name] == perez_of(by_argument)[name] == value != perez_of(plain)[name]


def test_keys_of_the_model_that_have_no_use_are_noted(tmp_path):
    words = 'limits = "paper"\nair_mass = "kasten-1966"\n'
    folder = scene_folder(tmp_path, toml=f"[perez]\nepsilon = 3.0\ndelta = 0.2\n{words}", difcol=DIFCOL)
    said = "sky.toml: air_mass is not used: the sky is a perez sky of epsilon 3 and Delta 0.2"
    assert said in sky.read_scene(folder).notes
    said = "sky.toml: limits and air_mass are not used: the sky is a uniform sky"
    (folder / "sky.toml").write_text(f"[perez]\n{words}")
    assert said in sky.read_scene(folder, sky="uniform").notes
