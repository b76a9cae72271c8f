"""What a command cannot use: what is wrong comes first, then what was meant; no file is written.

Exit code and a few words of the one message here; whole messages of frequent mistakes stand in mistakes.md. With --json
an error is one object of a published schema.
"""

import argparse
import json
import re
import shlex
import shutil
from collections import Counter
from importlib import import_module
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from aomc_sky.cli import commands
from aomc_sky.cli.commands.run import FIRST
from aomc_sky.cli.options import add_option, names_of
from aomc_sky.cli.usage import COMMANDS
from aomc_sky.cli.values import LIMITED, TYPES
from aomc_sky.formats.sky_toml.keys import KEYS
from aomc_sky.options import OPTIONS, Kind, Option
from tests.support.fault_rows import command
from tests.support.shared import INPUTS, REPOSITORY

GREY = "run --wavelengths 443 555 --out new --sky"
SUN = "run --wavelengths 443 555 --out new --sun-zenith 40"
FIVE = "--coefficients -1 -0.3 5 -3 0.1"
SKY = "run inputs/measured/sky.csv --out new"
EPW = "--epw inputs/weather/two_days.epw"
TIME = "--time 2026-06-21T09:30:00Z --latitude 54.18 --longitude 7.89"
CLEAR = "perez --sun-zenith 40 --dni 850 --dhi 95"
NIGHT = "info inputs/night_sky/night.h5"
AIR = "atmosphere inputs/atmosphere_sky/clear.atmo"
EXPORT = "export out --force --to"
THEIRS = "verify theirs.npy --scene inputs/clear_day"
SIZE = "texture-save-precision"
USAGE = {
    # unknown words
    "export x --to csv --out-dir y": "export has no option --out-dir",
    "run x --format jpeg": "--format: invalid choice: 'jpeg'; choose from npy, mcpl, raw, source, none",
    "lobes x.h5 --time 0": "aomc-sky info or plot FILE.h5 --time TIME",
    # options of a run
    "run scene --out new --format mcpl --format none": "--format none",
    "run scene --format mcpl --out -": "--format",
    "run scene --format raw --out - --json": "--json and --out -",
    "run scene --out new --sky perez": "dhi",
    "run scene --out new --compat aomc --allocation systematic": "--compat aomc",
    "run scene --out new --method iid --placement r2": "iid",
    "run scene --out new --max-memory 1k": "--max-memory",
    "run scene --out new --seed -1": "--seed",
    "run scene --out new --order none": "--order",
    "run scene --out new --shard 0/3": "shard",
    "run scene --out new --shard 1/3 --format mcpl": "shard",
    "run scene --out new --shard 1/3 --force": "shard",
    "run scene --out new --engine dask --shard 1/2": "dask",
    "run scene --out new --scheduler tcp://localhost:1": "--scheduler",
    "run inputs/perez_sky --out new --bias direct": "expected NAME=SHARE, for example direct=0.2",
    "run inputs/perez_sky --out new --bias direct=a": "expected a finite number",
    "run inputs/perez_sky --out new --bias direct=0.2,perez=0.8": "write the option once for each component",
    "run inputs/perez_sky --out new --bias direct=0.1 --bias direct=0.2": "--bias direct is given twice",
    "run inputs/perez_sky --bias sun=0.2 --dry-run": "there is no component 'sun'",
    "run scene --replicates 0 --dry-run": "1 to 4096",
    # skies by name
    f"{GREY} none": '--sky none (sky="none") needs a scene of files',
    f"{GREY} uniform --sky-option a=1": "has no options",
    f"{GREY} uniform --sky-option a=1 --sky-option a=2": "--sky-option a is given twice",
    f"{GREY} overcast --azimuth-convention from_sun": "--azimuth-convention is for a measured sky (.csv)",
    f"{GREY} overcast --bins degrees": "--bins is for a scene of files",
    f"{GREY} cie --sky-option type": "expected KEY=VALUE",
    f"{GREY} cie --sky-option type=3 --sky-option polarisation=0.5 --sun-zenith 40": "write --polarisation 0.75",
    # light that a scene cannot use
    f"perez --sun-zenith 40 {FIVE} --limits paper": "--limits (limits=) is not used",
    "run scene --wind 5": "run has no option --wind; leave it out: surface, wind and waves are the transport code's",
    "run scene --limits paper": "run has no option --limits; write limits below [perez] of sky.toml",
    "verify out --scene scene --coefficients 1": "write a to e below [perez] of sky.toml",
    "info scene --moon-zenith 40": "write moon_zenith_deg below [atmosphere] of sky.toml",
    f"{SUN} --ghi 780 --dhi 140 --diffuse-only --disc": "--disc (sun_disc=True) is not used",
    # weather
    f"run perez --out new {EPW} --row 49": "rows 1 to 48",
    f"run perez --out new {EPW}": "--epw (epw=) needs --row N (row=N)",
    "run perez --out new --row 5": "--row (row=) needs --weather FILE (weather=FILE)",
    f"run perez --out new {EPW} --row 12 --dni 5": "--dni (dni=) contradicts --epw (epw=)",
    f"run perez --out new {TIME} --altitude 1e5": "--altitude: 100000.0 is outside the range -500 to 9000",
    # measured skies and fields
    f"{SKY} --sky uniform": "--sky: not used with",
    f"{SKY} --waveband 5": "waveband 5",
    f"{SKY} --stokes-signs 1 -1": "--stokes-signs is for a radiance field (.nc)",
    "run inputs/clear_day --out new --angle-unit deg": "--angle-unit is for a measured sky (.csv)",
    # perez
    "perez": "where is the sun",
    "perez --time 2024-01-01T12:00:00Z --latitude 5 --dni 1 --dhi 1": "--longitude",
    f"{CLEAR} --placement philox": "--placement is for photons",
    f"{CLEAR} --polarisation 0.6": "--polarisation is for photons: name their folder with --out DIR",
    f"{CLEAR} --format none --format npy --out new": "--format none",
    f"{CLEAR} --write-skydist s.inp --wavelength -1": "positive",
    f"{CLEAR} --plot sky.jpeg": ".png",
    f"perez --sun-zenith 40 {FIVE} --with-beam --out new": "how bright the beam is",
    f"{CLEAR} --out - --format raw": "perez writes a folder",
    # info
    "info": "",
    "info --include-dir somewhere": "",
    "info inputs/atmosphere/hazy.atmo --iterations 777": "--iterations is for a scene; ",
    "info inputs/sparse_sky --wavelengths 500": "--wavelengths is for a run without files or a measured sky",
    "info inputs/sparse_sky --animation a": "--animation is for a background sky; ",
    f"{NIGHT} --time 0 --utc-offset 99": "outside the range -24 to 24",
    f"{NIGHT} --time 0 --animation cty": "the nearest is city; it has airglow, city, starlight",
    f"{NIGHT} --time 0 --wavelength 300": "300 is outside the spectra of the file, 380 to 720 nm",
    f"{NIGHT} --wavelength 550": "need --time",
    # export
    f"{EXPORT} npy --waveband 4": "waveband 4 is not in this run; it has wavebands 1, 2, 3",
    f"{EXPORT} csv --scene x": "--scene is for --to aomc",
    f"{EXPORT} netcdf --waveband 1": "holds all wavebands",
    f"{EXPORT} envmap --out -": "--out - is for run",
    f"{EXPORT} envmap --out sky.tif": "--to envmap writes no .tif file",
    f"{EXPORT} envmap --out out/sky.hdr": "is in the run itself",
    f"{EXPORT} envmap --out folder.hdr": "folder.hdr is a folder; name a file",
    f"{EXPORT} mcpl --out sky.hdr": "a name that ends in .mcpl is a file, and a name without an ending",
    f"{EXPORT} csv --out photons.csv": "a name without an ending, such as photons, is a folder",
    f"{EXPORT} npy --out out": "is the run itself",
    f"{EXPORT} mcpl --out out": "photons.mcpl in the run is the run's own",
    f"{EXPORT} source --out out/plan.npz": "plan.npz is there and no folder",
    f"{EXPORT} mcpl --out r.mcpl.gz": "write r.mcpl and run gzip on it",
    # targets that are never replaced
    f"{CLEAR} --force --write-skydist scene/amc.inp": "never replaced",
    f"{CLEAR} --force --write-skydist inputs/perez_sky/sky.toml": "never replaced",
    f"{CLEAR} --force --write-skydist /dev/null": "device or a pipe",
    # an empty name
    "plot inputs/clear_day --out ''": "empty",
    f"{AIR} --out-dir ''": "empty",
    # plot
    "plot scene --pull": "--pull is for a run",
    "plot scene --size 20": "300 to 8000",
    "plot scene --range 3 1": "increasing",
    "plot scene --cmap virdis": "near it are viridis",
    "plot scene --waveband 9": "9",
    "plot out --iterations 5": "--iterations is for",
    "plot out --pull --show counts": "--show",
    # verify
    "verify out --method iid": "--scene AMC_INP",
    "verify out --waveband 4": "waveband 4 is not in this run",
    "verify out --resample 1.5": "resample",
    "verify out --level x": "level",
    "verify out --iterations 7": "--iterations says how a scene is read",
    THEIRS: "name the waveband of the photons with --waveband",
    f"{THEIRS} --waveband 9": "waveband 9 is not in this scene",
    f"{THEIRS} --waveband 1 --waveband 2": "give one --waveband",
    f"{THEIRS} --waveband 1 --resample 0.5": "--resample",
    "verify theirs.npy": "--scene AMC_INP",
    # atmosphere and validate
    f"{AIR} --sun-zenith 40": "--out-dir",
    f"{AIR} --out-dir new --sun-zenith 181": "181",
    f"{AIR} --out-dir new --sun-zenith 0:90:1e-9": "0:90:1e-9",
    f"{AIR} --out-dir new --sun-zenith 5,5": "5",
    f"{AIR} --out-dir new --bins 0 4": "--bins",
    f"{AIR} --out-dir new --wavelength -5": "wavelength",
    f"{AIR} --out-dir new --sun-zenith 0:90:1 --bins 3600 3600 --no-netcdf": "is the most; ask for fewer suns",
    f"{AIR} --out-dir new --{SIZE} 0": SIZE,
    f"{AIR} --out-dir new --no-netcdf --save-irradiance": "--save-irradiance",
    f"{AIR} --out-dir new --save-scat-density --orders 1": "source functions need --method sos",
    f"{AIR} --out-dir new --save-light-pollution --orders 1": "light pollution relative radiance",
    f"{AIR} --no-save-tex --sun-zenith all": 'no "scattering texture size for sza"',
    f"{AIR} --no-save-tex --sun-zenith 70:95:5 --method sos": "--sun-zenith 95",
    "validate weatherless --dni 850": "dhi",
}  # fmt: skip
"""Command line -> words of the message; exit code 2."""
OTHERS = {
    (3, f"run perez --out new --tmy3 {EPW[6:]} --row 1"): "E601",
    (3, "perez --epw absent.epw --row 1"): "absent.epw",
    (3, "export nowhere --to npy"): "there is no such folder",
    (3, "export scene --to npy"): "run it first: aomc-sky run",
    (3, "export folder.hdr --to npy"): "this folder holds no plan.npz",
    (3, "plot nosuch"): "E100",
    (4, f"run scene --out new --format none --iterations {2**62 + 1}"): f"from 1 to 2^62, got {2**62 + 1}",
    (4, "run scene --out new --iterations 10 --replicates 11"): "too few for 11 replicates",
    (4, f"run perez --out new {EPW} --row 1"): "the nearest row with light is 5",
    (4, "perez --sun-zenith 40 --dni 850 --dhi 0 --out new"): "no light in the sky",
    (6, f"{CLEAR} --write-skydist no/such/folder/skydist.inp"): "no/such/folder",
    (6, "plot scene --out absent/sky.png"): "absent",
    (6, "run scene -q --out theirs.npy"): "cannot create the folder",
    (6, "run scene -q --out /proc/self/aomc-sky-out"): "/proc/self/aomc-sky-out",  # refuses names to everybody
}  # fmt: skip
"""The same with their exit codes."""
NEEDED = {"plot": "matplotlib", "night.h5": "h5py", "--epw": "pvlib", "--time 2": "pvlib", "--tmy3": "pvlib"}
NEEDED |= {"--save-scat": "h5netcdf", "--save-light": "h5netcdf"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A scene, a run of it, photons of another code, files of other kinds, and all that lies in inputs/."""
    made = tmp_path_factory.mktemp("usage")
    shutil.copytree(INPUTS, made / "inputs")
    shutil.copytree(INPUTS / "document_example", made / "scene")
    for name, lost in (("perez", ["difcol.inp"]), ("weatherless", ["difcol.inp", "sky.toml"])):
        shutil.copytree(INPUTS / "perez_sky", made / name, ignore=shutil.ignore_patterns(*lost))
    (made / "folder.hdr").mkdir()
    np.save(made / "theirs.npy", np.tile(np.float32([0.6, 0.0, -0.8]), (100, 1)))
    assert command("run", made / "scene", "--iterations", 100, "-q", "--out", made / "out") == 0
    few = made / "few"  # of which some have names that are near a wrong one
    for name, source in (("scene", made / "scene"), ("out", made / "out"), ("misspelt", INPUTS / "perez_sky")):
        shutil.copytree(source, few / name)
    (few / "misspelt" / "sky.toml").write_text("[perez]\ndni = 850.0\ndiffuse = 95.0\n")
    shutil.copy(INPUTS / "atmosphere" / "molecules_only.atmo", few / "air.atmo")
    (few / "my_sky.py").write_text("import aomc_sky\n")
    (few / "scan.dat").write_text("10 20 0.3\n10 30 0.4\n")
    return made


@pytest.mark.parametrize(
    ("code", "line", "words"), [*((2, *row) for row in USAGE.items()), *((*key, said) for key, said in OTHERS.items())]
)
def test_what_does_not_go(code, line, words, folder, monkeypatch, told):
    for word, package in NEEDED.items():
        if word in line:
            pytest.importorskip(package)
    monkeypatch.chdir(folder)
    before = sorted(folder.rglob("*"))
    said = told(*shlex.split(line), code=code)
    assert words.lower() in said.err.lower()
    assert said.out == ""
    assert code == 3 or len(re.findall(r"^aomc-sky( \w+)?: error: ", said.err, re.MULTILINE)) == 1
    assert sorted(folder.rglob("*")) == before


PAGE = Path(__file__).with_name("mistakes.md")
ROWS = re.findall(r"(?m)^\| `aomc-sky ?(.*?)` \| `(.*)` \|$", PAGE.read_text())


def test_first_lines_are_those_of_the_page(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder / "few")
    assert len(ROWS) == 38
    for words, line in ROWS:
        status = command(*shlex.split(words))
        said = capsys.readouterr()
        assert (status in (2, 3), said.out) == (True, ""), words
        shown = said.err.splitlines()
        assert shown[0] == line.replace("\\|", "|"), words
        assert len(shown) <= 3


def test_the_second_line_names_the_help(told):
    for words in ([], ["fly"], ["validate"], ["run", "a", "b"]):
        first, second = told(*words, code=2).err.splitlines()
        assert first.startswith("aomc-sky: error: ")
        assert re.fullmatch(r"      = help: aomc-sky (\w+ )?--help", second)
    for name in COMMANDS:  # without a word it says what it needs
        assert 1 <= len(told(name, code=2).err.splitlines()) <= 2


def test_json_stands_behind_the_command(told):
    (problem,) = json.loads(told("--json", "info", "x", code=2).out)["error"]["problems"]
    assert problem["message"] == "--json stands before the command"
    assert problem["advice"] == "write aomc-sky COMMAND ... --json"


def test_errors_of_every_kind_are_one_object(folder, tmp_path, monkeypatch, capsys):
    jsonschema = pytest.importorskip("jsonschema")
    schema = json.loads((files("aomc_sky") / "cli" / "error.schema.json").read_text())
    validator = jsonschema.Draft7Validator(schema)  # what is used of 2020-12 is the same there
    monkeypatch.chdir(folder / "few")
    broken = tmp_path / "skydist.inp"
    broken.write_text((folder / "scene" / "skydist.inp").read_text().replace("20.0", "nan"))
    expected = {
        "run scene --ordre patch": (2, "usage", None),
        "run scene --replicates 2 --format npy --format none": (2, "usage", None),
        "run misspelt": (3, "E702", 3),
        "run out": (3, "E100", None),
        "run scene --iterations 9e18": (4, "scene", None),
        "run scene --seed 2 --out out": (5, "foreign-output", None),
        "run scene --out /dev/null/x": (6, "output", None),
        f"plot {broken} --out {tmp_path}/x.png": (3, "E302", 5),
        "info none.h5 --time 0": (3, "E500", None),
    }
    for line, (status, code, at) in expected.items():
        needed = {"plot": "matplotlib", "info": "h5py"}.get(line.split()[0])
        if needed and find_spec(needed) is None:
            status, code, at = 2, "missing-extra", None
        assert command(*line.split(), "--json") == status, line
        said = capsys.readouterr()
        assert said.err == "", line
        answer = json.loads(said.out)
        assert list(validator.iter_errors(answer)) == []
        problem = answer["error"]["problems"][0]
        assert (answer["error"]["exit_status"], problem["code"], problem["line"]) == (status, code, at), line


@pytest.mark.parametrize("name", COMMANDS)
def test_help_is_short_and_says_where_the_rest_is(name, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "80")
    shown = {}
    for flag in ("--help", "--help-all"):
        assert command(name, flag) == 0 or flag == "--help-all"
        shown[flag] = capsys.readouterr().out
    short = shown["--help"]
    assert sum(1 + max(len(line) - 1, 0) // 80 for line in short.splitlines()) <= 60
    assert short.startswith(f"usage: aomc-sky {name} ")
    if "--help-all" in short:
        n_hidden = int(re.search(r"(\d+) more options with --help-all", short)[1])
        listed = {key: set(re.findall(r"(?m)^  (?:-\w, )?(--[a-z0-9-]+)", text)) for key, text in shown.items()}
        assert listed["--help"] < listed["--help-all"]
        assert len(listed["--help-all"] - listed["--help"]) == n_hidden
    assert commands.__doc__.count(f"aomc-sky {name}`") == 1


def test_the_row_of_an_option_says_whether_it_may_be_repeated_and_not_its_help():
    parser = argparse.ArgumentParser()
    rows = (Option("a", "a number, not repeatable", "I"), Option("b", "texts", "I", repeats=True))
    for row in rows:
        add_option(parser, row)
    found = parser.parse_args(["--a", "1", "--a", "2", "--b", "1", "--b", "2"])
    assert (found.a, found.b) == ("2", ["1", "2"])
    assert [action.help for action in parser._actions[1:]] == ["a number, not repeatable", "texts (repeatable)"]


def test_every_row_of_the_table_is_used_and_has_what_its_kind_needs():
    """A row that no command shows and no section of sky.toml has is forgotten; a kind without a reader cannot be."""
    groups = [import_module(f"aomc_sky.cli.commands.{name}").GROUPS for name in COMMANDS]
    shown = Counter(name for one in groups for names in one.values() for name in names.split())
    assert shown.keys() <= OPTIONS.keys()
    for name, row in OPTIONS.items():
        assert (name in shown) == (row.option != "-"), name
        assert row.option != "-" or row.section, name
        assert row.kind in (Kind.FLAG, Kind.SWITCH) or row.kind in {**TYPES, **LIMITED} or row.option == "-", name
        assert (
            row.section in KEYS and (row.key or row.own_name) in {*KEYS[row.section], "coefficients"}
        ) or not row.section
        assert bool(row.words) == (row.kind is Kind.WORD), name
        assert "default" not in row.text or row.default is None, name
    for one in groups:
        flags = [OPTIONS[name].flag for name in names_of(one)]
        assert len(flags) == len(set(flags))  # no option twice in a command


def test_the_first_screen_of_run_begins_with_the_first_command_of_the_readme():
    readme = (REPOSITORY / "README.md").read_text()
    first = readme.partition("$ aomc-sky run")[2].partition("\n...")[0]
    asked = re.findall(r"--[a-z-]+", first)
    assert sorted(asked) == sorted(f"--{name}" for name in FIRST.split()[: len(asked)])
