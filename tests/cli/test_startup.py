"""The command line answers without loading numba, scipy or matplotlib; importing the package loads nothing."""

import json
import shutil

import pytest

from aomc_sky.formats.sky_models import SKY_MODELS
from tests.support.processes import in_environment
from tests.support.shared import INPUTS, REPOSITORY

HEAVY = {"numba", "llvmlite", "scipy", "matplotlib", "pandas", "pvlib", "tqdm", "xarray"}

_PROBE = """
import io, json, sys
from contextlib import redirect_stderr, redirect_stdout
answers = []
for words in json.loads(sys.argv[1]):
    shown = io.StringIO()
    with redirect_stdout(shown), redirect_stderr(shown):
        try:
            from aomc_sky.cli.main import main
            code = main(words)
        except SystemExit as leaving:
            code = leaving.code or 0
    answers.append({"code": code, "shown": shown.getvalue(), "modules": list(sys.modules)})
print(json.dumps(answers))
"""


def probe(*commands):
    """Command lines one after another in a fresh interpreter: their exit codes, what they showed, what is imported."""
    done = in_environment(_PROBE, json.dumps(commands))
    for words, answer in zip(commands, json.loads(done), strict=True):
        answer["packages"] = {name.partition(".")[0] for name in answer["modules"]}
        answer["words"] = " ".join(words)
        yield answer


LIGHT = [
    (["--help"], 0, "usage: aomc-sky"), (["--version"], 0, "aomc-sky 0."), (["run", "--help"], 0, "--seed"),
    (["validate", "--help"], 0, "every problem"), (["info", "--help"], 0, "usage: aomc-sky info"),
    (["perez", "--help"], 0, "examples:"), (["run", "no_such_folder/amc.inp"], 3, "no_such_folder"),
    (["run", str(INPUTS / "document_example"), "--dry-run"], 0, "modelled: "),
    (["info", str(INPUTS / "document_example")], 0, "skydist.inp"),
    (["run", "amc.inp", "--order", "sideways"], 2, "sideways"),
]  # fmt: skip
"""What needs nothing heavy, help first: it needs no numpy either."""


def test_answers_without_heavy_imports():
    for (words, code, wanted), answer in zip(LIGHT, probe(*(words for words, _, _ in LIGHT)), strict=True):
        assert answer["code"] == code, answer
        assert wanted in answer["shown"], answer
        assert not HEAVY & answer["packages"], answer["words"]
        assert "--help" not in words or "numpy" not in answer["packages"], answer["words"]


@pytest.mark.parametrize(
    "loaded",
    [{"--help": "", "run": "run", "verify": "run verify"}, {"--help": "", "perez": "perez"}],
    ids=["run-and-verify", "perez"],
)
def test_only_the_sub_command_that_was_asked_for_is_built(loaded):
    words = [list(dict.fromkeys([name, "--help"])) for name in loaded]
    for answer, wanted in zip(probe(*words), loaded.values(), strict=True):
        built = {name.split(".")[3] for name in answer["modules"] if name.startswith("aomc_sky.cli.commands.")}
        assert built == set(wanted.split()), answer["words"]


def test_input_errors_appear_without_heavy_imports(tmp_path):
    """Of every file of inputs/bad, and of a scene with a waveband in the dark."""
    dark = shutil.copytree(INPUTS / "document_example", tmp_path / "dark")
    text = (dark / "skydist.inp").read_text()
    old, new = "2 1 0 8.2\n2 1 1 9.5\n2 2 1 15.3", "2 1 0 0.0\n2 1 1 0.0\n2 2 1 0.0"
    assert old in text
    (dark / "skydist.inp").write_text(text.replace(old, new))
    commands = {("validate", str(INPUTS / "bad")): (3, "E302"), ("run", str(dark)): (4, "650 nm")}
    for answer, (code, said) in zip(probe(*commands), commands.values(), strict=True):
        assert answer["code"] == code, answer
        assert said in answer["shown"], answer
        assert not HEAVY & answer["packages"], answer["words"]


def test_importing_the_package_loads_no_third_party_module():
    program = "import sys; import aomc_sky; print(*sorted({m.partition('.')[0] for m in sys.modules}))"
    loaded = set(in_environment(program).split())
    assert "aomc_sky" in loaded
    assert not {"numpy", *HEAVY} & loaded


RARE = {where.partition(":")[0].split(".")[2] for where in SKY_MODELS.values()}
RARE |= {"eclipse", "background", "backgrounds", "plugin", "weather", "sun_position", "spectral_split"}
RARE |= {"polarisation", "polarised_field"}
"""Names of rooms and modules that few scenes have a use for, each model of a sky among them."""
USED: dict[str, set[str]] = {
    "clear_day": {"tabulated"},
    "document_example": {"tabulated"},
    "beam_only": set(),
    "perez_sky": {"perez"},
    "sun_and_sky": {"perez"},
    "night_sky": {"lobes", "background"},
    "atmosphere_sky": {"atmosphere", "eclipse"},
}


def test_rare_modules_have_their_names():
    package = REPOSITORY / "src" / "aomc_sky"
    assert {*RARE} <= {path.stem for path in package.rglob("*") if path.suffix == ".py" or path.is_dir()}


@pytest.mark.parametrize(
    "scenes",
    [("clear_day", "document_example"), ("beam_only", "perez_sky", "sun_and_sky"), ("night_sky",), ("atmosphere_sky",)],
    ids=" ".join,
)
def test_a_run_loads_what_its_scene_needs_alone(tmp_path, scenes):
    """Scenes that need the same, one after another."""
    if "night_sky" in scenes:
        pytest.importorskip("h5py")
    folders = [shutil.copytree(INPUTS / scene, tmp_path / scene) for scene in scenes]
    if "atmosphere_sky" in scenes:  # order 1 in few patches: the same modules but for the solver
        toml = folders[0] / "sky.toml"
        few = 'clear.atmo"\nmethod = "order1"\nzenith_bins = 2\nazimuth_bins = 2\n'
        toml.write_text(toml.read_text(encoding="utf-8").replace('clear.atmo"', few), encoding="utf-8")
    runs = [["run", str(folder), "--iterations", "1e3", "--out", f"{folder}/out", "-q"] for folder in folders]
    for scene, answer in zip(scenes, probe(*runs), strict=True):
        assert answer["code"] == 0, answer
        ours = {part for name in answer["modules"] if name.startswith("aomc_sky.") for part in name.split(".")}
        assert ours & RARE == USED[scene], scene


_PHOTONS = """
import sys
import aomc_sky as sky
for iterations in map(int, sys.argv[2:]):
    source = sky.read_scene(sys.argv[1], iterations=iterations).source(seed=1)
    if source.total > 10**6:
        from aomc_sky.kernels.backend import announce_photons
        announce_photons(source.total)
    source.photons(0, 0, 1000)
    print("numba" in sys.modules)
"""


def test_numba_is_loaded_for_a_large_job_alone():
    said = in_environment(_PHOTONS, INPUTS / "overcast", 10**5, 10**8, NUMBA_DISABLE_JIT="1")  # to be loaded is enough
    assert said.split() == ["False", "True"]
