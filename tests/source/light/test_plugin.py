"""Sky models of other packages that are wrong in every way: one sentence each, with the package and its version."""

import json
import shutil

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main
from tests.support.plugins import lay_package
from tests.support.shared import INPUTS

SCENE = INPUTS / "perez_sky"
FLAT = """
class Flat:
    def __init__(self, level=1.0):
        self.level = level
    def radiance(self, z, a, nm):
        return self.level
"""
GOOD = FLAT + "def make(*, sun_zenith_rad, sun_azimuth_rad, level=1.0, other=None): return Flat(level)\n"


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Lay a package with this code on the module path, as pip does, under a name of its own."""
    count = iter(range(100))

    def lay(code, *, name="dark", distribution="dark-skies", version="2.1"):
        k = next(count)
        module = f"{tmp_path.name.replace('-', '_')}_{k}"
        site = tmp_path / f"site{k}"
        monkeypatch.syspath_prepend(
            lay_package(site, module, code, name=name, distribution=distribution, version=version)
        )

    return lay


@pytest.fixture
def scene_with(tmp_path):
    """A scene with this text in the section [sky] of sky.toml."""

    def folder(text):
        target = shutil.copytree(SCENE, tmp_path / "scene", dirs_exist_ok=True)
        (target / "sky.toml").write_text(f"[sky]\n{text}")
        return target

    return folder


def make_of(body, **arguments):
    extra = "".join(f", {name}={value}" for name, value in arguments.items())
    return FLAT + f"def make(*, sun_zenith_rad, sun_azimuth_rad{extra}):\n    {body}\n"


BROKEN = {
    "import": ("import no_such_package\n", "cannot be imported: ModuleNotFoundError"),
    "syntax": ("def make(:\n", "cannot be imported: SyntaxError"),
    "exit": ("raise SystemExit('no licence')\n", "cannot be imported: SystemExit: no licence"),
    "base-exception": ("class Stop(BaseException): pass\nraise Stop('no licence')\n", "be imported: Stop: no licence"),
    "no-make": ("other = 1\n", "cannot be imported: AttributeError"),
    "not-callable": ("make = 3\n", "make is not a function"),
    "no-sun": ("def make(*, sun_zenith_rad): return None\n", "takes no sun_azimuth_rad"),
    "number": (make_of("return 3"), "gives int instead of an object with radiance"),
    "class": (make_of("return Flat"), "gives the class Flat instead of an object with radiance"),
    "crash": (make_of("return 1 / 0"), "fails: ZeroDivisionError: division by zero; this is a fault of dark-skies"),
    "crash-later": (make_of("return lambda z, a, nm: [][1]"), "fails: IndexError: list index out of range"),
    "nan": (make_of("return Flat(float('nan'))"), "gives nan at zenith angle"),
    "negative": (make_of("return Flat(-1.0)"), "gives -1 at zenith angle"),
    "shape": (make_of("return lambda z, a, nm: [1.0, 2.0, 3.0]"), "gives an array of shape (3,)"),
    "two-arguments": (make_of("return lambda z, a: 1.0"), "takes three arguments"),
    "lower-list": (make_of("f = Flat(); f.lower = lambda nm: [f]; return f"), "gives Flat instead of Components"),
    "lower-nothing": (make_of("f = Flat(); f.lower = lambda nm: (); return f"), "lower() gives no component"),
    "lower-rows": (
        make_of("import aomc_sky as a; f = Flat(); f.lower = lambda nm: a.UniformSky().lower([1.0]); return f"),
        "lower() gives 1 strengths for 4 wavelengths",
    ),
    "dark": (make_of("return Flat(0.0)"), "is dark at 400 nm, but 0.26 of the light there is diffuse"),
}


@pytest.mark.parametrize(("code", "reason"), BROKEN.values(), ids=BROKEN)
def test_a_broken_model_gets_one_sentence(install, code, reason):
    install(code)
    with pytest.raises(sky.errors.PluginError if "is dark" not in reason else sky.SceneError) as caught:
        sky.read_scene(SCENE, sky="dark")
    message = str(caught.value)
    assert message.startswith("a dark sky " if "is dark" in reason else "the sky model 'dark' (dark-skies 2.1) ")
    assert reason in message
    assert "\n" not in message


def test_the_command_line_says_it_without_a_traceback_unless_it_is_asked(install, told, tmp_path):
    install(make_of("return 1 / 0"))
    words = ["run", str(SCENE), "--sky", "dark", "--out", str(tmp_path / "out"), "-q"]
    shown = told(*words, code=4).err
    assert "Traceback" not in shown
    assert shown.endswith("      = -v shows where in that package\n")
    shown = told(*words, "-v", code=4).err
    assert "ZeroDivisionError" in shown.partition("aomc-sky: error")[0]
    assert "return 1 / 0" in shown


def test_a_good_model_is_a_sky(install):
    install(GOOD)
    scene = sky.read_scene(SCENE, sky="dark", sky_options={"level": np.float32(2)})
    assert [c.name for c in scene.components] == ["direct", "dark"]
    assert scene.options["plugin"]["options"] == {"level": 2.0}
    uniform = sky.read_scene(SCENE, sky="uniform")
    both = [one.source().counts for one in (scene, uniform)]
    np.testing.assert_array_equal(both[0].sum(axis=1), both[1].sum(axis=1))
    assert abs(both[0][:, 0] - both[1][:, 0]).max() <= 1


def test_a_broken_or_noisy_package_spoils_no_list_of_the_others(install, told):
    install("raise BaseException('no licence')", name="broken", distribution="broken-skies")
    install("print('welcome')\n" + GOOD)
    shown = told("info", "--skies", "--json")
    listed = json.loads(shown.out)
    assert [one["name"] for one in listed["skies"] if one["distribution"] != "aomc-sky"] == ["dark"]
    assert "BaseException: no licence; this is a fault of broken-skies" in listed["refused"][0]
    assert shown.err == "welcome\n"
    install("raise KeyboardInterrupt", name="stopped", distribution="stopped-skies")
    with pytest.raises(KeyboardInterrupt):
        sky.read_scene(SCENE, sky="stopped")


@pytest.mark.parametrize("name", ["perez", "direct", "field", "table"])
def test_our_names_are_ours(install, name, told):
    install(GOOD, name=name, distribution="evil-skies", version="6.6")
    assert f"note: evil-skies 6.6 has a sky model '{name}', a name of aomc-sky's own" in told("info", "--skies").out
    assert "plugin" not in sky.read_scene(SCENE, sky="perez").options
    if name != "perez":
        with pytest.raises(sky.UsageError, match=r"evil-skies 6\.6 has a sky model"):
            sky.read_scene(SCENE, sky=name)


NAMES = '"perez", "uniform", "none", "cardioidal", "cie", "harrison-coombes", "overcast" or "dark"'
WRONG = {
    "drak": ({"sky": "drak"}, f"there is no sky model 'drak'; the nearest is dark; write {NAMES}"),
    "no number": ({"sky_options": {"other": object()}}, "option other of a sky model must be a number.* got object"),
}


@pytest.mark.parametrize(("arguments", "message"), WRONG.values(), ids=WRONG)
def test_names_and_options_that_are_wrong(install, arguments, message):
    install(GOOD)
    with pytest.raises(sky.UsageError, match=message):
        sky.read_scene(SCENE, **{"sky": "dark", **arguments})


def test_two_packages_of_one_name_are_refused(install):
    install(GOOD)
    install(GOOD, distribution="darker-skies", version="0.1")
    with pytest.raises(sky.UsageError, match=r"dark-skies .* have each a sky model 'dark'; uninstall all but one"):
        sky.read_scene(SCENE, sky="dark")


IN_SKY_TOML = {
    "unknown": ('model = "dark"\nlevl = 2.0\n', "3:1: error[E702]", "no option 'levl'; the nearest is level"),
    "ours-misspelt": ('model = "dark"\ndifuse_irradiance = [1.0]\n', "3:1: error[E702]", "is diffuse_irradiance"),
    "value": ('other = 1\nmodel = "dark"\nlevel = 3.0\n', "4:9: error[E704]", "refuses what it is given: level is 3.0"),
    "name": ('model = "drak"\nlevel = 1.0\n', "2:9: error[E704]", "there is no sky model 'drak'; the nearest is dark"),
}


@pytest.mark.parametrize(("text", "at", "reason"), IN_SKY_TOML.values(), ids=IN_SKY_TOML)
def test_a_wrong_key_of_sky_toml_is_shown(install, scene_with, text, at, reason):
    body = "if level > 2: raise ValueError(f'level is {level}')\n    return Flat(level)"
    install(make_of(body, level=1.0, other=None))
    with pytest.raises(sky.InputFileError) as caught:
        sky.read_scene(scene_with(text))
    assert f"sky.toml:{at}" in str(caught.value)
    assert reason in str(caught.value)


def test_an_option_that_is_needed(install, scene_with):
    install(make_of("return Flat(level)", level="None").replace("level=None", "level"))
    with pytest.raises(sky.UsageError, match=r'needs level; write .* \(sky_options=\{"level": \.\.\.\}\)'):
        sky.read_scene(SCENE, sky="dark")
    folder = scene_with('model = "dark"\n')
    with pytest.raises(sky.InputFileError, match=r"sky.toml:2:9: error\[E705\].* needs level"):
        sky.read_scene(folder)
    assert main(["validate", str(folder)]) == 3
    assert main(["validate", str(folder), "--sky-option", "level=2.0"]) == 0


VALUES = {"level=2": 2, "level=[1, 2]": [1, 2], "level=clear": "clear", "level=1\nother=2": "1\nother=2", "level=": ""}


@pytest.mark.parametrize("text", VALUES)
def test_values_on_the_command_line_are_those_of_toml(text):
    from aomc_sky.cli.values import sky_option

    assert sky_option(text) == ("level", VALUES[text])


def test_rayleighs_pattern_on_the_sky_of_another_package(install, scene_with):
    """Around the sun that it gets; where it says its polarisation itself, the pattern is refused."""
    install(GOOD, name="polar")
    pattern, sun = sky.RayleighPattern(max_degree=0.6), {"sun_zenith_deg": 40.0, "sun_azimuth_deg": 25.0}
    how = {"wavebands": [550.0], "n_photons": 1000, **sun, "ghi": 780.0, "dhi": 140.0, "sky": "polar"}
    scene = sky.weather_scene(**how, polarisation=pattern)
    function = {**how, "sky": lambda z, a, nm: np.ones(np.broadcast(z, a, nm).shape)}
    expected = sky.weather_scene(**function, polarisation=pattern)
    np.testing.assert_array_equal(scene.components[1].stokes, expected.components[1].stokes)
    assert sky.weather_scene(**how).components[1].stokes is None
    by_toml = sky.read_scene(scene_with('model = "polar"\npolarisation = 0.6\n'))
    assert by_toml.components[1].stokes is not None
    own = "import aomc_sky as a; return a.CIESky(type=3, sun_zenith_rad=1.0, polarisation=a.RayleighPattern())"
    install(make_of(own), name="own")
    assert sky.weather_scene(**{**how, "sky": "own"}).components[1].stokes is not None
    with pytest.raises(sky.UsageError, match="is polarised already"):
        sky.weather_scene(**{**how, "sky": "own"}, polarisation=pattern)


def test_our_own_names_start_no_search(monkeypatch):
    searches = []
    monkeypatch.setattr("aomc_sky.formats.sky_models.entry_points", lambda **group: searches.append(group) or ())
    sky.read_scene(SCENE, sky="uniform")
    sky.read_scene(SCENE)
    assert searches == []
    with pytest.raises(sky.UsageError):
        sky.read_scene(SCENE, sky="nobody's")
    assert searches == [{"group": "aomc_sky.sky_models"}]


def test_what_is_missing_is_not_said_beside_what_is_wrong(install, scene_with):
    """The misspelt name is often the one that is needed."""
    install(make_of("return Flat(level)", level="None").replace("level=None", "level"))
    with pytest.raises(sky.UsageError, match="no option 'levl'") as caught:
        sky.read_scene(SCENE, sky="dark", sky_options={"levl": 1.0})
    assert "needs" not in str(caught.value)
    with pytest.raises(sky.InputFileError, match="no option 'levl'") as caught:
        sky.read_scene(scene_with('model = "dark"\nlevl = 1.0\n'))
    assert len(caught.value.problems) == 1
