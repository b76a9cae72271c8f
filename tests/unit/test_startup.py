"""The command line answers without loading numba, scipy or matplotlib; importing the package loads nothing."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.shared import INPUTS

HEAVY = {"numba", "llvmlite", "scipy", "matplotlib", "pandas", "pvlib", "rich", "xarray"}

_PROBE = """
import io, json, sys
from contextlib import redirect_stderr, redirect_stdout
shown = io.StringIO()
with redirect_stdout(shown), redirect_stderr(shown):
    try:
        from aomc_sky.cli.main import main
        code = main(sys.argv[1:])
    except SystemExit as leaving:
        code = leaving.code or 0
modules = sorted({name.partition(".")[0] for name in sys.modules})
print(json.dumps({"code": code, "shown": shown.getvalue(), "modules": modules}))
"""


def probe(*arguments: str) -> dict[str, object]:
    """Run the command line in a fresh interpreter: its exit code, what it showed, what it imported."""
    done = subprocess.run(
        [sys.executable, "-c", _PROBE, *arguments], capture_output=True, text=True, timeout=60, check=True
    )
    answer: dict[str, object] = json.loads(done.stdout)
    return answer


@pytest.mark.parametrize(
    ("arguments", "code", "wanted"),
    [
        (["--help"], 0, "usage: aomc-sky"),
        (["--version"], 0, "aomc-sky 0."),
        (["run", "--help"], 0, "--seed"),
        (["validate", "--help"], 0, "every problem"),
        (["info", "--help"], 0, "usage: aomc-sky info"),
        (["perez", "--help"], 0, "examples:"),
        (["run", "no_such_folder/amc.inp"], 3, "no_such_folder"),
        (["run", str(INPUTS / "document_example"), "--dry-run"], 0, "modelled: "),
        (["info", str(INPUTS / "document_example")], 0, "skydist.inp"),
        (["run", "amc.inp", "--order", "sideways"], 2, "sideways"),
    ],
    ids=[
        "help",
        "version",
        "run-help",
        "validate-help",
        "info-help",
        "perez-help",
        "missing-file",
        "dry-run",
        "info",
        "unknown-option-value",
    ],
)
def test_answers_without_heavy_imports(arguments: list[str], code: int, wanted: str) -> None:
    answer = probe(*arguments)
    assert answer["code"] == code
    assert wanted in str(answer["shown"])
    assert not HEAVY & set(answer["modules"])  # type: ignore[call-overload]
    assert "--help" not in arguments or "numpy" not in answer["modules"]  # type: ignore[operator]


def broken(tmp_path: Path, scene: str, name: str, old: bytes, new: bytes) -> Path:
    """Copy a scene with one change in one file."""
    for path in (INPUTS / scene).iterdir():
        data = path.read_bytes()
        if path.name == name:
            assert data.count(old) >= 1
            data = data.replace(old, new, 1)
        (tmp_path / path.name).write_bytes(data)
    return tmp_path / "amc.inp"


@pytest.mark.parametrize("command", ["run", "validate"])
@pytest.mark.parametrize(
    ("scene", "name", "old", "new", "shown"),
    [
        ("document_example", "amc.inp", b": 100.0\n", b": 100\n", "E104"),
        ("document_example", "lambbot.inp", b"0.05", b"1.50", "E202"),
        ("document_example", "skydist.inp", b"1 2 1 20.0", b"1 2 1 nan", "E302"),
        ("beam_only", "difcol.inp", b"1.0 0.5", b"1.0 x", "error[E"),
    ],
    ids=["amc", "lambbot", "skydist", "difcol"],
)
def test_input_errors_appear_without_heavy_imports(
    tmp_path: Path, command: str, scene: str, name: str, old: bytes, new: bytes, shown: str
) -> None:
    amc = broken(tmp_path, scene, name, old, new)
    answer = probe(command, str(amc if command == "run" else amc.parent))
    assert answer["code"] == 3
    assert shown in str(answer["shown"])
    assert name in str(answer["shown"])
    assert not HEAVY & set(answer["modules"])  # type: ignore[call-overload]


def test_scene_without_light_is_told_without_heavy_imports(tmp_path: Path) -> None:
    amc = broken(tmp_path, "document_example", "skydist.inp", b"2 1 0 8.2\n2 1 1 9.5\n2 2 1 15.3\n", b"")
    sky = amc.with_name("skydist.inp")
    sky.write_bytes(sky.read_bytes().replace(b"6 2 2 2", b"3 2 2 2"))
    answer = probe("run", str(amc))
    assert answer["code"] == 4
    assert "650 nm" in str(answer["shown"])
    assert not HEAVY & set(answer["modules"])  # type: ignore[call-overload]


def test_importing_the_package_loads_no_third_party_module() -> None:
    probe_text = "import sys; import aomc_sky; print(*sorted({m.partition('.')[0] for m in sys.modules}))"
    done = subprocess.run([sys.executable, "-c", probe_text], capture_output=True, text=True, timeout=60, check=True)
    assert not {"numpy", *HEAVY} & set(done.stdout.split())


def test_module_and_script_are_the_same_program() -> None:
    environment = {**os.environ, "COLUMNS": "100"}
    module = subprocess.run(
        [sys.executable, "-m", "aomc_sky", "--help"], capture_output=True, text=True, check=True, env=environment
    )
    assert module.stdout.startswith("usage: aomc-sky ")


_COMMANDS = """
import contextlib, io, sys
from aomc_sky.cli.main import main
with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
    main(sys.argv[1:])
print(*sorted({name.split(".")[3] for name in sys.modules if name.startswith("aomc_sky.cli.commands.")}))
"""


@pytest.mark.parametrize(
    ("words", "loaded"),
    [(["--help"], ""), (["run", "--help"], "run"), (["perez", "--help"], "perez"), (["merge", "--help"], "merge run")],
    ids=["top", "run", "perez", "merge"],
)
def test_only_the_sub_command_that_was_asked_for_is_built(words: list[str], loaded: str) -> None:
    command = [sys.executable, "-c", _COMMANDS, *words]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == loaded


_RUN = """
import json, sys
from aomc_sky.cli.main import main
code = main(["run", sys.argv[1], "--iterations", "1e3", "--out", sys.argv[2], "-q"])
print(json.dumps({"code": code, "modules": [name for name in sys.modules if name.startswith("aomc_sky.")]}))
"""

PEREZ, LOBES, TABLE = {"perez"}, {"lobes", "background", "backgrounds"}, {"tabulated"}
ATMOSPHERE, MOON = {"atmosphere", "atmospheres", "atmo"}, {"moon", "eclipse"}
WEATHER = {"weather", "year", "sun_position", "spectral_split"}
MODELS = PEREZ | LOBES | ATMOSPHERE | MOON | WEATHER | {"sky_toml", "light", "uniform"}

UNUSED = {
    "clear_day": MODELS,
    "document_example": MODELS,
    "perez_sky": ATMOSPHERE | WEATHER | TABLE | {"uniform"},
    "sun_and_sky": ATMOSPHERE | WEATHER | TABLE | {"uniform"},
    "night_sky": PEREZ | ATMOSPHERE | WEATHER | TABLE | {"uniform"},
    "atmosphere_sky": WEATHER | TABLE | {"uniform", "lobes"},
}
"""Names of rooms and modules that a run of the scene has no use for."""


@pytest.mark.parametrize("scene", UNUSED)
def test_a_run_loads_what_its_scene_needs_alone(tmp_path: Path, scene: str) -> None:
    if scene == "night_sky":
        pytest.importorskip("h5py")
    folder = shutil.copytree(INPUTS / scene, tmp_path / "scene")
    if scene == "atmosphere_sky":  # order 1 in few patches: the same modules but for the solver
        toml = folder / "sky.toml"
        few = 'clear.atmo"\nmethod = "order1"\nzenith_bins = 2\nazimuth_bins = 2\n'
        toml.write_text(toml.read_text(encoding="utf-8").replace('clear.atmo"', few), encoding="utf-8")
    command = [sys.executable, "-c", _RUN, str(folder), str(tmp_path / "out")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True)
    answer = json.loads(done.stdout)
    assert answer["code"] == 0
    assert [name for name in answer["modules"] if UNUSED[scene] & set(name.split("."))] == []


_PHOTONS = """
import sys
import aomc_sky as sky
source = sky.read_scene(sys.argv[1], iterations=int(sys.argv[2])).source(seed=1)
if source.total > 10**6:
    from aomc_sky.kernels.backend import announce_photons
    announce_photons(source.total)
source.photons(0, 0, 1000)
print("numba" in sys.modules)
"""


@pytest.mark.parametrize(("iterations", "loads_numba"), [(10**5, False), (10**8, True)])
def test_small_jobs_run_without_numba_and_large_ones_with_it(iterations: int, loads_numba: bool) -> None:
    command = [sys.executable, "-c", _PHOTONS, str(INPUTS / "overcast"), str(iterations)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    assert done.stdout.strip() == str(loads_numba)


_TWICE = """
import os, sys
from aomc_sky.cli.main import main
code = main(["run", sys.argv[1], "--iterations", "1e3", "--out", sys.argv[2], "-q"])
print(code, "numba" in sys.modules)
"""


def test_a_scene_whose_atmosphere_was_solved_before_loads_no_solver(tmp_path: Path) -> None:
    folder = shutil.copytree(INPUTS / "twilight", tmp_path / "scene")
    toml = folder / "sky.toml"
    toml.write_text(toml.read_text(encoding="utf-8").replace("18", "4\npaths = 8"), encoding="utf-8")
    environment = os.environ | {"AOMC_SKY_CACHE": str(tmp_path / "kept")}
    for name, loads_numba in (("first", True), ("second", False)):
        command = [sys.executable, "-c", _TWICE, str(folder), str(tmp_path / name)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True, env=environment)
        assert done.stdout.split() == ["0", str(loads_numba)], done.stderr
    plans = {(tmp_path / name / "plan.npz").read_bytes() for name in ("first", "second")}
    assert len(plans) == 1
