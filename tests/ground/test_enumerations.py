"""Arguments of a closed list take its words, or the members of its enumeration, and refuse everything else."""

import inspect
import re
from functools import partial

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.formats import azimuth
from aomc_sky.formats.radiance_words import LENGTH_NM
from aomc_sky.outputs.photon_formats import PHOTON_FORMATS, SOURCE
from aomc_sky.plan.options import Sampling
from tests.support.atmospheres import molecules_only
from tests.support.shared import INPUTS
from tests.support.signatures import CHOICES, arguments, choices, constructor, public, shown, words_of_enumeration
from tests.support.type_checker import complaints

GRID = {"grid": sky.PatchGrid.regular(1, 2), "wavelength_nm": [500.0], "values": np.ones((1, 2))}
SCENE = sky.Scene(wavebands=[500.0], n_photons=10, components=sky.TabulatedSky(**GRID))
POINTS = ([0.0, 40.0, 40.0], [0.0, 0.0, 180.0], [1.0, 1.0, 1.0])
TABLE = sky.files.SkyTable(wavelength_nm=np.array([500.0]), radiance=np.ones((1, 1, 1)))
FIELD = sky.RadianceField.from_points(*POINTS, is_absolute=False)
CELL = {"name": "a", "strength": np.ones(1), "mass": np.ones((1, 1)), "cell": np.zeros((1, 6))}
SHAPE = {"kind": "ggx", "param0": 0.5, "param1": 0.5}
TURNED = SHAPE | {"quaternion": np.array([1.0, 0.0, 0.0, 0.0])}
LOBE = {"name": "a", "wavelength_nm": np.array([500.0]), "spectrum": np.ones(1)} | TURNED
FILE = sky.lobes.background_of_lobes({"a": sky.lobes.SkyLobe(kind="hg", width=0.5, spectrum=[1.0])}, [500.0])
BACKGROUND = sky.lobes.BackgroundSky(animations=FILE.animations, wavelength_nm=FILE.wavelength_nm, curves=FILE.curves)
SUN = {"sun_zenith_deg": 40.0}
LOOK = {"wavelength_nm": [500.0], "sun_zenith_deg": 170.0, "sky_zenith_deg": [0.0], "azimuth_from_sun_deg": [0.0]}


def picture(**words):
    figure = pytest.importorskip("matplotlib.figure")
    return sky.plot(SCENE, ax=figure.Figure().subplots(), **words)  # the layout of a whole figure takes its time


def lobes(reference="diurnal", **words):
    lobe = sky.lobes.SkyLobe(**{"kind": "ggx", "width": 0.5, "spectrum": [1.0]} | words)
    return sky.lobes.background_of_lobes({"a": lobe}, [500.0], reference=reference)


def from_xarray(**words):
    xarray = pytest.importorskip("xarray")
    coordinates = {"zenith": ("zenith", [20.0, 60.0], {"units": "degree"}), "wavelength": 500.0}
    coordinates |= {"azimuth": ("azimuth", [0.0, 90.0, 180.0, 270.0], {"units": "degree"})}
    field = xarray.DataArray(np.ones((2, 4)), dims=("zenith", "azimuth"), coords=coordinates, name="radiance")
    given = {"azimuth_convention": "north_clockwise", "radiance_unit": "relative", "wavelength_unit": "nm"} | words
    return sky.TabulatedSky.from_xarray(field, sun_azimuth_deg=0.0, **given)


CALLS = {
    "AtmosphereSky": partial(sky.AtmosphereSky, medium=molecules_only([500.0]), sun_zenith_deg=170.0),
    "lobes.BackgroundSky.irradiance": partial(BACKGROUND.irradiance, None, 0.0, 500.0),
    "ClearSky": sky.ClearSky,
    "component.Component": partial(sky.component.Component, **CELL),
    "Footprint": partial(sky.Footprint, size_x_m=1.0, size_y_m=1.0),
    "PerezSky": partial(sky.PerezSky, epsilon=5.0, delta=0.1, **SUN),
    "RadianceField": partial(sky.RadianceField, FIELD.wavelength_nm, FIELD.direction, FIELD.values),
    "RadianceField.from_points": partial(sky.RadianceField.from_points, *POINTS, is_absolute=False),
    "Scene.source": SCENE.source,
    "lobes.SkyLobe": lobes,
    "files.SkyTable": partial(sky.files.SkyTable, wavelength_nm=TABLE.wavelength_nm, radiance=TABLE.radiance),
    "TabulatedSky": partial(sky.TabulatedSky, **GRID),
    "TabulatedSky.from_xarray": from_xarray,
    "lobes.WeightedLobe": partial(sky.lobes.WeightedLobe, **LOBE),
    "lobes.WeightedLobe.share": sky.lobes.WeightedLobe(**LOBE).share,
    "allocate": partial(sky.allocate, np.ones((2, 2)), 7),
    "background_at": partial(sky.background_at, BACKGROUND, 0.0),
    "lobes.background_of_lobes": lobes,
    "directions.sky_angles": partial(sky.directions.sky_angles, np.array([0.0, 0.6, -0.8])),
    "directions.sky_from_travel": partial(sky.directions.sky_from_travel, [0.0, 0.6, -0.8]),
    "directions.to_enu_azimuth_deg": partial(sky.directions.to_enu_azimuth_deg, 30.0, sun_azimuth_deg=10.0),
    "directions.travel_from_sky": partial(sky.directions.travel_from_sky, 30.0, 0.0),
    "irradiances": partial(sky.irradiances, "2026-06-21T10:00Z", 43.4, 7.9, wavebands=[550.0], ghi=700.0, dhi=120.0),
    "lobes.mass_above_horizon": partial(sky.lobes.mass_above_horizon, **TURNED),
    "lobes.patch_mass": partial(sky.lobes.patch_mass, **TURNED, grid=GRID["grid"]),
    "lobes.pdf": partial(sky.lobes.pdf, **SHAPE, m=[0.0, 0.0, 1.0]),
    "lobes.sample": partial(sky.lobes.sample, **SHAPE, u=0.5, v=0.5),
    "perez.coefficients": partial(sky.perez.coefficients, 5.0, 0.1, 0.7),
    "perez.limited": partial(sky.perez.limited, 5.0, 0.1),
    "perez.relative_air_mass": partial(sky.perez.relative_air_mass, 0.7),
    "perez.sky_brightness": partial(sky.perez.sky_brightness, 100.0, 0.7),
    "plot": picture,
    "read_radiance_csv": partial(sky.read_radiance_csv, INPUTS / "measured" / "sky.csv"),
    "read_scene": partial(sky.read_scene, INPUTS / "perez_sky", iterations=10),
    "solve_atmosphere": partial(sky.solve_atmosphere, INPUTS / "atmosphere" / "molecules_only.atmo", **LOOK),
    "verify_counts": partial(sky.verify_counts, [1, 1], [1.0, 1.0]),
    "weather_scene": partial(sky.weather_scene, wavebands=[550.0], ghi=700.0, dhi=120.0, **SUN),
    "write_run": partial(sky.write_run, SCENE, "out"),
    "files.write_skydist": partial(sky.files.write_skydist, TABLE, "skydist.inp"),
}
"""A call of each function that has such an argument, which is given by its name."""


OPEN = {
    *("path", "out", "weather", "epw", "tmy2", "tmy3", "time"),
    *("name", "preset_name", "title", "label", "author", "description", "organization", "advice", "animation"),
    *("zenith", "elevation", "azimuth", "wavelength", "variable", "variable_q", "variable_u", "radiance_unit"),
}
"""Arguments that take any text: files, times, names, units of radiance."""
RESULTS = {("atmosphere.AtmosphereResult", "method")}
"""What a result says, which nobody gives."""
BY_NUMBER = {("component.Component", "law")}
"""A law is its number, which is part of files."""
ARGUMENTS = {which: choices(text) for which, text in arguments().items() if any(choices(text))}
WORDS = {which: {word for name in names for word in CHOICES[name]} for which, (_, names) in ARGUMENTS.items() if names}
MEMBERS = {which: kinds[0] for which, (kinds, _) in ARGUMENTS.items() if kinds}
WRONG = {"verify_counts": "aomc"}
"""A word that a function refuses, by default "nothing"."""
LIST = re.compile(
    r"(?:must be(?: one of)?|formats are|known words; write|--wavelength-unit) (.*?)(?:, got|, or a |, or give| \(|$)"
)
"""The list of words in a message."""


def outcome(which, value):
    """What a function returns for a value of an argument, and the message in which it refuses it, or an empty one."""
    called, name = which
    try:
        return CALLS[called](**{name: value}), ""
    except (sky.AomcSkyError, ValueError) as error:
        return None, str(error)


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_every_choice_is_a_literal():
    texts = {which for which, text in arguments().items() if re.search(r"(^|\| )str\b", text)}
    assert {(called, name) for called, name in texts if name not in OPEN} == RESULTS
    assert set(MEMBERS) - BY_NUMBER <= set(WORDS)
    assert {called for called, _ in ARGUMENTS} == set(CALLS)


@pytest.mark.parametrize("which", sorted(WORDS), ids=".".join)
def test_words_of_a_literal_are_those_that_the_function_knows(which, tmp_path):
    words, wrong = WORDS[which], WRONG.get(which[0], "nothing")
    message = outcome(which, wrong)[1]
    if which[1] == "azimuth_convention":
        assert sorted(words) == sorted([*azimuth.WORDS, *words_of_enumeration(sky.directions.AzimuthConvention)])
    else:
        assert sorted(word.strip("'\"") for word in re.split(", | or ", LIST.search(message)[1])) == sorted(words)
    assert not list(tmp_path.iterdir())


@pytest.mark.filterwarnings("ignore::aomc_sky.InputWarning", "ignore::aomc_sky.ModelLimitWarning")
@pytest.mark.parametrize("which", sorted(WORDS), ids=".".join)
def test_every_word_of_a_literal_is_taken(which):
    wrong = WRONG.get(which[0], "nothing")
    message = outcome(which, wrong)[1]
    for word in WORDS[which]:  # some go with other arguments, and other messages say so
        assert outcome(which, word)[1] != message.replace(repr(wrong), repr(word))


def test_units_of_a_wavelength_are_those_of_files():
    assert {LENGTH_NM[unit] for unit in CHOICES["WavelengthUnitWord"]} == set(LENGTH_NM.values())


def test_formats_of_a_run_are_those_of_photons_and_the_source():
    assert {*CHOICES["RunFormatWord"], "csv"} == {*PHOTON_FORMATS, SOURCE}


@pytest.mark.parametrize("which", sorted(ARGUMENTS), ids=".".join)
def test_what_is_no_member_is_refused(which, tmp_path):
    for wrong in ("nothing", 99, 1.5, b"up", ["up"]):
        assert outcome(which, wrong)[1]
    assert not list(tmp_path.iterdir())


@pytest.mark.filterwarnings("ignore::aomc_sky.InputWarning")
@pytest.mark.parametrize("which", sorted(set(MEMBERS) - BY_NUMBER), ids=".".join)
def test_words_are_members(which):
    for member in MEMBERS[which]:
        word = member.value if isinstance(member.value, str) else member.name.lower()
        expected, message = outcome(which, member)
        for written in (word, word.upper()):
            found, refused = outcome(which, written)
            assert refused[:60] == message[:60]  # a member that goes with other arguments
            if isinstance(found, np.ndarray | tuple):
                np.testing.assert_array_equal(found, expected)


WRITTEN = [called for called, one in public().items() if isinstance(one, type) and constructor(one)]
"""Classes whose signature for type checkers is written by hand."""


@pytest.mark.parametrize("called", WRITTEN)
def test_what_type_checkers_see_is_what_a_class_takes(called):
    real = inspect.signature(public()[called]).parameters
    written = constructor(public()[called])
    assert list(shown(public()[called])) == list(real)
    assert [one.arg for one in written.kwonlyargs] == [
        one.name for one in real.values() if one.kind == one.KEYWORD_ONLY
    ]
    optional = [one.arg for one, default in zip(written.kwonlyargs, written.kw_defaults, strict=True) if default]
    assert optional == [one.name for one in real.values() if one.default is not one.empty]


def test_functions_that_pass_arguments_on_to_a_source_know_them():
    taken = inspect.signature(sky.Scene.source).parameters
    known = {name: one.__forward_arg__ for name, one in Sampling.__annotations__.items()}
    assert known == {name: one.annotation for name, one in taken.items() if name not in ("self", "seed")}


@pytest.mark.slow
def test_a_type_checker_refuses_a_wrong_word(tmp_path):
    """Every word of every argument, and one that it does not have."""
    given = {*((*which, word) for which, words in WORDS.items() for word in (*words, "no such word"))}
    given |= {("Scene.plot", name, word) for called, name, word in given if called == "plot"}
    given |= {("write_run", name, word) for called, name, word in given if called == "Scene.source"}
    calls = [f"sky.{called}(**given, {name}={word!r})" for called, name, word in sorted(given)]
    (tmp_path / "programs").mkdir()
    program = tmp_path / "programs" / "words.py"
    program.write_text(
        "\n".join(["from typing import Any", "import aomc_sky as sky", "given: dict[str, Any] = {}", *calls])
    )
    found = {int(line.split(":")[1]) for line in complaints(program.parent)}
    assert found == {number for number, call in enumerate(calls, start=4) if "'no such word'" in call}


def test_light_comes_from_above_in_the_frame_that_is_named():
    up, down = (sky.directions.travel_from_sky(30.0, 0.0, frame) for frame in ("UP", "down"))
    np.testing.assert_allclose((up[2], down[2]), (-np.cos(np.pi / 6), np.cos(np.pi / 6)), rtol=1e-15)
    assert sky.directions.to_enu_azimuth_deg(30.0, "north_clockwise") == 60.0
    for wrong in ("sideways", None, 0):
        with pytest.raises(sky.UsageError, match=r"frame must be one of 'up', 'down', got"):
            sky.directions.travel_from_sky(30.0, 0.0, wrong)
