"""sky.toml: good files say what they say, and nothing gets through otherwise."""

import dataclasses
import re
import time
import tomllib
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from aomc_sky.errors import InputFileError
from aomc_sky.formats.sky_toml.file import MAX_BYTES, key_spans, read_sky_toml
from aomc_sky.formats.sky_toml.keys import KEYS, SETS, set_problem
from aomc_sky.formats.sky_toml.sections import (
    AtmosphereSection,
    BackgroundSection,
    FieldSection,
    MoonDirection,
    PerezSection,
    SkySection,
    SkyToml,
    SunSection,
)
from aomc_sky.options import SECTIONS
from tests.support.limits import MOST_CPU_S
from tests.support.shared import DATA, REPOSITORY

MIDNIGHT_S = 1782084600.0  # 2026-06-21T23:30:00Z by `date -u -d ... +%s`
TABLE = FieldSection(
    file=str(DATA / "sky_toml" / "good" / "field.nc"), variable="radiance", isel=(("stokes", 0),), zenith="vza",
    azimuth="vaa", wavelength="w", angle_unit="deg", azimuth_convention="north_clockwise",
)  # fmt: skip
EXPECTED = {
    "absolute": SkyToml(
        sky=SkySection(diffuse_irradiance=(0.61, 1.0), direct_irradiance=(0.0, 1.25)),
        background=(BackgroundSection(file="city.h5", time=-1.0),),
    ),
    "atmosphere": SkyToml(
        atmosphere=AtmosphereSection(file="sub/clear.atmo", method="sos", orders=12, paths=999, zenith_bins=30)
    ),
    "backgrounds": SkyToml(
        sky=SkySection(model="none"),
        background=(
            BackgroundSection(
                file="city.h5", time=MIDNIGHT_S, animation=("city",), utc_offset=2.0, interpolation="slerp"
            ),
            BackgroundSection(file="sub/stars.h5", time=MIDNIGHT_S, animation=("milky way", "airglow")),
            BackgroundSection(file="stars.h5", time=MIDNIGHT_S + 0.5),
        ),
    ),
    "coefficients": SkyToml(perez=PerezSection(coefficients=(-1.0, -0.32, 10.0, -3.0, 0.45))),
    "eclipse": SkyToml(
        sun=SunSection(zenith_deg=93.5),
        atmosphere=AtmosphereSection(
            file="clear.atmo",
            moon=MoonDirection(zenith_offset_deg=0.25, azimuth_deg=120.0, distance_km=365_000.0),
            ground_luminance_cd_m2=0.5,
        ),
    ),
    "empty": SkyToml(),
    "ghi_dhi": SkyToml(perez=PerezSection(ghi=700.0, dhi=95.0)),
    "table": SkyToml(sky=SkySection(table=TABLE)),
    "three_irradiances": SkyToml(perez=PerezSection(ghi=700.0, dhi=95.0, dni=600.0)),
    "inline_and_dotted": SkyToml(perez=PerezSection(ghi=700.0, dni=640.0), sun=SunSection(zenith_deg=41.5)),
    "irradiances": SkyToml(
        perez=PerezSection(dni=850.0, dhi=95.0), sun=SunSection(zenith_deg=32.4, azimuth_deg=-121.25, disc=True)
    ),
    "shape_crlf_bom": SkyToml(perez=PerezSection(epsilon=1.02, delta=0.18)),
    "sun_only": SkyToml(sun=SunSection(disc=False)),
}


@pytest.mark.parametrize("name", EXPECTED)
def test_a_good_file_says_what_it_says(name):
    path = DATA / "sky_toml" / "good" / f"{name}.toml"
    found = read_sky_toml(path)

    def below(section):
        return section and dataclasses.replace(section, file=str(Path(section.file).relative_to(path.parent)))

    background = tuple(map(below, found.background))
    named = dataclasses.replace(found, background=background, atmosphere=below(found.atmosphere))
    assert named == EXPECTED[name]


def test_every_good_file_is_looked_at():
    assert {path.stem for path in (DATA / "sky_toml" / "good").glob("*.toml")} == set(EXPECTED)


def test_files_lie_below_the_folder_or_an_allowed_one(tmp_path):
    scene, other = tmp_path / "scene", tmp_path / "other"
    scene.mkdir()
    other.mkdir()
    (scene / "inside.h5").touch()
    (other / "city.h5").touch()
    (scene / "link.h5").symlink_to(other / "city.h5")
    (scene / "back").symlink_to(scene)
    toml = scene / "sky.toml"
    for name, is_inside in {
        "inside.h5": True,
        "./absent.h5": True,
        "back/inside.h5": True,
        "../scene/inside.h5": True,
        "../other/city.h5": False,
        "link.h5": False,
        str(other / "city.h5"): False,
        "back/../other/city.h5": False,
    }.items():
        toml.write_text(f"[[background]]\nfile = '{name}'\ntime = 0\n")
        for allowed in ((), (str(tmp_path / "oth"),), (str(other),)):
            if is_inside or allowed == (str(other),):
                (one,) = read_sky_toml(toml, allow_paths=allowed).background
                assert Path(one.file).resolve() == (scene / name).resolve()
                continue
            with pytest.raises(InputFileError, match=r"sky\.toml:2:8: error\[E707\].*\n.*\n.*--allow-path") as caught:
                read_sky_toml(toml, allow_paths=allowed)
            advice = str(caught.value).rpartition("--allow-path ")[2]
            assert Path(advice).resolve() == other


def test_arrays_have_a_value_for_each_waveband():
    path = DATA / "sky_toml" / "good" / "absolute.toml"
    assert read_sky_toml(path, n_wavebands=2).sky.diffuse_irradiance == (0.61, 1.0)
    with pytest.raises(InputFileError, match=r":2:26: error\[E705\]"):
        read_sky_toml(path, n_wavebands=3)


def test_the_page_names_every_key():
    page = (REPOSITORY / "docs/formats/sky_toml.md").read_text()
    made = re.findall(r"^```\{keys\} (\w+)$", page, re.MULTILINE)  # the site makes these tables
    assert sorted(made) == ["atmosphere", "clear_sky", "perez", "sun"]
    known = {*re.findall(r"`(\w+)`", page), *(name for section in made for name in SECTIONS[section]), *"abcde"}
    assert {key for section in KEYS.values() for key in section} - known == set()


def problems_of(path, text):
    path.write_bytes(text)
    with pytest.raises(InputFileError) as caught:
        read_sky_toml(path)
    return caught.value


HOSTILE = {
    "many keys": b"[perez]\n" + b"".join(b"k%d=1\n" % k for k in range(7000)),
    "long array": b"a = [" + b"1," * 32_000 + b"]\n",
    "long key": b"[perez]\n" + b"k" * 65_000 + b" = 1\n",
    "key of many parts": b"a." * 30_000 + b"b = 1\n",
    "header of many parts": b"[" + b"a." * 30_000 + b"b]\n",
    "many keys of many parts": b"".join(b"k%d." % k + b"a." * 980 + b"b = 1\n" for k in range(33)),
    "many tables": b"[[a]]\n" * 9000,
    "nested tables": b"a = " + b"{a=" * 3000 + b"1" + b"}" * 3000,
    "long string": b'dni = "' + b"x" * 65_000 + b'"\n',
    "nested arrays": b"[perez]\na = " + b"[" * 30_000,
    "too large": b"#" * (MAX_BYTES + 1),
    "nul": b"[perez]\ndni = 1\0",
    "digits": b"[perez]\ndni = " + b"9" * 5000,
}


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
def test_hostile_files_cost_little(tmp_path, text):
    start = time.process_time()
    code = problems_of(tmp_path / "sky.toml", text).problems[0].code
    assert code == "E101" if b"\0" in text else code[:2] == "E7"
    assert time.process_time() - start < MOST_CPU_S


BACKGROUND = '[[background]]\nfile = "x.h5"\n'


@pytest.mark.parametrize(
    ("text", "code", "place"),
    [
        *((f"[sun]\n{line}", "E701", None) for line in ("dni = .5", "dni = 1,234.5", "dni : 850", "model = overcast")),
        *((f"{BACKGROUND}time = {number}", "E704", (3, 8)) for number in (20260621, 202606212330)),  # dates
        ("[sky]\ndirect_irradiance = [1.5, 610.0]", "E704", (2, 21)),  # mW
        ("[perez]\nturbidity = 40.0", "E702", (2, 1)),
    ],
)
def test_what_people_write_is_told_at_its_place(text, code, place, tmp_path):
    problem = problems_of(tmp_path / "sky.toml", text.encode() + b"\n").problems[0]
    assert problem.code == code
    assert problem.line == 2 if place is None else (problem.line, problem.column) == place
    assert ("0.61" in problem.advice) == ("610" in text)


def test_many_problems_and_no_file(tmp_path):
    many = problems_of(tmp_path / "sky.toml", b"[perez]\n" + b"".join(b"key%d = 1\n" % k for k in range(3000)))
    assert len(many.problems) <= 200
    for path in (tmp_path / "none.toml", tmp_path):
        with pytest.raises(InputFileError, match="E100"):
            read_sky_toml(path)


@given(st.lists(st.sampled_from([key for complete in SETS for key in complete]), unique=True))
def test_exactly_the_complete_sets_are_accepted(names):
    complete = not names or any(set(names) == set(wanted) for wanted in SETS)
    problem = set_problem(names)
    assert (problem is None) == complete
    assert complete or (problem.message and problem.advice)


@given(st.binary(max_size=200) | st.text(alphabet="[]{}=.,\"'#\n abcdeghinrsuzp_019-+", max_size=120).map(str.encode))
@example(b"[perez]\ndni = 1e400\ndhi = 1\n")
@example(b'"perez" . dni = """\na""""" # x\nsun = {}')
def test_any_bytes_are_read_or_refused(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "fuzz.toml"
    path.write_bytes(data)
    try:
        shown = str(read_sky_toml(path))
    except InputFileError as error:
        shown = str(error)
    assert shown.startswith("SkyToml(") or "error[E" in shown


KEY = st.sampled_from(["dni", '"dhi"', "'zenith deg'", "a1", "x.y", 'q."r s".t'])
VALUE = st.sampled_from([
    "1", "1979-05-27 07:32:00 ", "[1, [2, 3], {u = 1}, # c ]\n 4\n]", '"a # ] \\" b"', "'it # ['", "{}", "[]", "-inf",
    "{u = 1, v = {w = 2}}",
])  # fmt: skip


@given(st.lists(st.tuples(KEY, VALUE, st.sampled_from(["", " # dni = 3", "\t"])), max_size=5), st.booleans())
def test_spans_are_those_of_the_keys(lines, with_header):
    head = "# head\n[ perez . 'sub' ] # x\n" if with_header else ""
    text = head + "".join(f" {k} = {v}{c}\n" for k, v, c in lines)
    try:
        tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return  # a key twice
    spans, number = key_spans(text), text[: len(head)].count("\n") + 1
    for key, value, _ in lines:
        names = ("x", "y") if key == "x.y" else ("q", "r s", "t") if "." in key else (key.strip("\"'"),)
        span = spans[*(("perez", "sub") if with_header else ()), *names]
        assert (span.key.line, span.key.column, span.key.width) == (number, 2, len(key))
        assert span.value.line == number
        shown = span.value.text[span.value.column - 1 :][: span.value.width]
        assert shown == value.split("\n")[0].split(" # c")[0].rstrip()
        number += value.count("\n") + 1


def test_what_has_no_line_of_its_own_stands_with_its_key():
    spans = key_spans('sun.disc = true\nperez = { dni = 1, "dhi" = 22 } # dhi = 3\n')
    assert spans["perez", "dhi"] == spans["perez",]
    assert (spans["perez",].key.line, spans["perez",].value.column, spans["perez",].value.width) == (2, 9, 23)
    assert (spans["sun", "disc"].key.column, spans["sun", "disc"].value.column) == (1, 12)
    assert spans["sky", "table"].key.line == 0


def test_spans_in_arrays_of_tables():
    text = "[[a]]\nk = 1\n[a.b]\nc = [7, 88]\n[[ a ]]\nk = 2\n[[a.d]]\n[[a.d]]\nx = 1\n"
    spans = key_spans(text)
    shown = {path: (span.key.line, span.value.column, span.value.width) for path, span in spans.items()}
    assert shown["a", "0", "b", "c"] == (4, 5, 7)
    assert shown["a", "1", "k"] == (6, 5, 1)
    assert shown["a", "1", "d", "1"] == (8, 3, 3)
    assert ("a", "1", "d", "1", "x") in spans
