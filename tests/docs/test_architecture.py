"""docs/architecture.md: its drawing and its table are those of the code, and its changes can be made as they stand."""

import re
import shutil
import subprocess
import sys
from importlib.util import find_spec

import numpy as np
import pytest

from tests.support.shared import REPOSITORY

PAGE = REPOSITORY / "docs" / "architecture.md"
FIGURES = REPOSITORY / "docs" / "figures"
CHANGES = re.findall(r"^### An? ([\w ]+)\n.*?^```diff\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)


def test_drawing_and_table_are_those_of_the_code_and_a_new_file_changes_neither(tmp_path):
    for name in ("src", "docs/figures"):
        shutil.copytree(REPOSITORY / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
    shutil.copy(REPOSITORY / "pyproject.toml", tmp_path)
    new = tmp_path / "src" / "aomc_sky" / "outputs" / "photons" / "new.py"
    new.write_text('"""Photons in a new format."""\n\nfrom aomc_sky.outputs.photons.files import PhotonWriter\n')
    subprocess.run([sys.executable, str(tmp_path / "docs" / "figures" / "draw_architecture.py")], check=True)
    for name in ("architecture.svg", "rooms.md"):
        drawn, shown = (tmp_path / "docs" / "figures" / name).read_text(), (FIGURES / name).read_text()
        assert drawn == shown, f"run python docs/figures/draw_architecture.py, which makes {name} anew"


def test_there_is_a_change_for_everything_that_is_often_added():
    assert [name for name, _ in CHANGES] == ["sky", "input option", "output"]


def apply(change, folder, *words):
    command = ["git", "apply", *words, "-"]
    done = subprocess.run(command, cwd=folder, input=change, text=True, capture_output=True, check=False)
    assert done.returncode == 0, f"the change does not apply to the code as it is:\n{done.stderr}"


@pytest.mark.parametrize("change", [change for _, change in CHANGES], ids=[name for name, _ in CHANGES])
def test_a_change_applies_to_the_code_as_it_is(change):
    apply(change, REPOSITORY, "--check")


@pytest.fixture(params=[name for name, _ in CHANGES])
def changed(request, tmp_path):
    """A copy of package and tests with one change of the page."""
    for name in ("src", "tests", "inputs"):
        ignored = shutil.ignore_patterns("__pycache__", "*.egg-info")
        shutil.copytree(REPOSITORY / name, tmp_path / name, ignore=ignored)
    shutil.copy(REPOSITORY / "pyproject.toml", tmp_path)
    apply(dict(CHANGES)[request.param], tmp_path)
    return request.param, tmp_path


def in_copy(copy, *words):
    command = [sys.executable, "-c", f"import sys; sys.path[:0] = [{str(copy / 'src')!r}, {str(copy)!r}]\n" + words[0]]
    done = subprocess.run([*command, *words[1:]], cwd=copy, text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr + done.stdout
    return done.stdout


PYTEST = "import pytest; sys.exit(pytest.main(['-q', '-p', 'no:cacheprovider', *sys.argv[1:]]))"
LINTER = "from importlinter.cli import lint_imports; sys.exit(lint_imports(no_cache=True, no_logo=True))"
COMMAND = "from aomc_sky.cli.main import main; sys.exit(main(sys.argv[1:]))"


def sky_is_tested(copy):
    assert "passed" in in_copy(copy, PYTEST, "tests/conformance/test_sky_models.py", "-k", "clear or registered")
    (copy / "scene").mkdir()
    for name in ("amc.inp", "difcol.inp", "lambbot.inp"):
        shutil.copy(copy / "inputs/perez_sky" / name, copy / "scene")
    words = ["--iterations", "1000", "-q", "--out"]
    in_copy(copy, COMMAND, "run", "scene", "--sky", "clear", *words, "by_option")
    (copy / "scene/sky.toml").write_text('[sky]\nmodel = "clear"\n')
    in_copy(copy, COMMAND, "run", "scene", *words, "by_file")
    photons = [(copy / out / "photons-0001.npy").read_bytes() for out in ("by_option", "by_file")]
    assert photons[0] == photons[1]
    in_copy(copy, COMMAND, "verify", "by_file", "-q")


def option_is_taken(copy):
    refused = COMMAND.replace("sys.exit(main(sys.argv[1:]))", "assert main(sys.argv[1:]) == 4")
    of_perez = ["perez", "--sun-zenith", "40", "--epsilon", "30", "--delta", "2", "-q"]
    in_copy(copy, COMMAND, *of_perez)
    in_copy(copy, refused, *of_perez, "--refuse-limits")
    of_run, toml = ["run", "inputs/perez_sky", "--iterations", "100", "-q", "--out"], copy / "inputs/perez_sky/sky.toml"
    toml.write_text("[perez]\nepsilon = 30.0\ndelta = 2.0\n")
    in_copy(copy, COMMAND, *of_run, "out")
    toml.write_text(f"{toml.read_text()}strict = true\n")
    in_copy(copy, refused, *of_run, "none")


def output_is_written(copy):
    words = ["run", "inputs/clear_day/amc.inp", "--iterations", "1000", "--precision", "float64", "--out", "out", "-q"]
    in_copy(copy, COMMAND, *words, "--format", "double", "--format", "npy")
    in_copy(copy, COMMAND, "verify", "out", "-q")
    records = np.fromfile(copy / "out/photons-0001.f64").reshape(-1, 3)
    assert len(records) == 1000
    np.testing.assert_array_equal(records, np.load(copy / "out/photons-0001.npy"))
    in_copy(copy, COMMAND, "export", "out", "--to", "double", "-q")
    assert (copy / "out-double/photons-0001.f64").read_bytes() == (copy / "out/photons-0001.f64").read_bytes()


CHECKS = {"sky": sky_is_tested, "input option": option_is_taken, "output": output_is_written}


@pytest.mark.slow
def test_a_change_does_what_the_page_says(changed):
    name, copy = changed
    if find_spec("importlinter") is not None:
        in_copy(copy, LINTER)
    CHECKS[name](copy)
