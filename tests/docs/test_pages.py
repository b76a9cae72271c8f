"""Pages that a reader follows: everything they say to type is typed, and what they show comes out."""

import re
import shutil

import pytest

import aomc_sky as sky
from aomc_sky.cli.commands.info import include_dir
from tests.support.host_programs import needs, run
from tests.support.pages import SavedFile, carry_out, programs, steps
from tests.support.shared import REPOSITORY

CODE = ("c", "fortran", "cuda", "python")


def test_every_block_of_the_readme_is_run():
    """Here or, those of ``sh``, by .ci/run (tests/docs/test_docs.py)."""
    text = (REPOSITORY / "README.md").read_text()
    assert set(re.findall(r"^```(\w*)\n.*?^```$", text, re.MULTILINE | re.DOTALL)) == {"console", "sh", *CODE}
    code, typed = programs("README.md"), typed_on(text)
    assert len(code) == len(re.findall(rf"^```(?:{'|'.join(CODE)})$", text, re.MULTILINE))
    assert [name for name in code if name not in typed] == ["kernel.cu"]


def typed_on(text):
    return "".join(step.line for step in steps(text) if not isinstance(step, SavedFile))


def compile_kernel(folder, *options):
    """Where nvcc is; nothing runs it."""
    if shutil.which("nvcc"):
        run(["nvcc", "-fmad=false", f"-I{include_dir()}", *options, "kernel.cu"], folder)


@needs("gcc", "gfortran")
@pytest.mark.slow
def test_tutorial_after_the_readme_in_one_folder(tmp_path):
    pytest.importorskip("pvlib")
    assert carry_out("../README.md", tmp_path) == 5
    compile_kernel(tmp_path, "-c", "-o", "kernel.o")
    pytest.importorskip("matplotlib")
    assert carry_out("tutorial.md", tmp_path) == 11
    # so that the programs of both pages go on running
    assert not programs("README.md").keys() & programs("docs/tutorial.md").keys()


COMMANDS = [
    ("error_bars.md", 1, ()),
    ("howto/from_aomc.md", 6, ()),
    ("howto/from_libradtran.md", 3, ("xarray", "h5netcdf")),
    ("formats/mcpl.md", 2, ("mcpl",)),
    pytest.param("howto/index.md", 2, ("matplotlib",), marks=pytest.mark.slow),
    pytest.param("howto/measured_sky.md", 8, (), marks=pytest.mark.slow),
    pytest.param("howto/weather.md", 12, ("pvlib",), marks=pytest.mark.slow),
    pytest.param("howto/polarised.md", 3, (), marks=pytest.mark.slow),
    pytest.param("howto/radiance.md", 8, ("xarray",), marks=pytest.mark.slow),
    pytest.param("models/atmosphere.md", 1, (), marks=pytest.mark.slow),
    pytest.param("plots.md", 2, ("matplotlib", "h5py"), marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("page", "n_commands", "packages"), COMMANDS)
def test_page_of_commands(page, n_commands, packages, tmp_path):
    for package in packages:
        pytest.importorskip(package)
    assert carry_out(page, tmp_path) == n_commands


@pytest.mark.slow
def test_page_of_own_skies(tmp_path, skies_site, monkeypatch):
    pytest.importorskip("xarray")
    monkeypatch.setenv("PYTHONPATH", str(skies_site))
    assert carry_out("howto/own_sky.md", tmp_path) == 7
    monkeypatch.syspath_prepend(skies_site)
    day, chosen = tmp_path / "inputs" / "clear_day", {"sky": "bright_zenith", "iterations": 10**6}
    scene = sky.read_scene(day, **chosen, sky_options={"brightening": 0})
    assert -scene.source().photons(0).uz.mean(dtype=float) == pytest.approx(2 / 3, abs=1e-5)
    with pytest.raises(sky.UsageError, match=r"our-skies 0\.1.*brightening must be 0 or more, got -1"):
        sky.read_scene(day, **chosen, sky_options={"brightening": -1})


@needs("gcc", "gfortran")
@pytest.mark.slow
def test_page_of_hosts(tmp_path):
    assert carry_out("hosts.md", tmp_path) == 9


def test_page_of_hosts_builds_all_that_it_shows():
    text = (REPOSITORY / "docs" / "hosts.md").read_text()
    names, built = programs("docs/hosts.md"), typed_on(text)
    assert len(re.findall(r"^```(?:c|fortran|python)$", text, re.MULTILINE)) == len(names)
    assert [name for name in names if name not in built] == []


@pytest.mark.parametrize(
    "page",
    ["```console\n$ echo 1\n2\n```\n", "```console\n$ false\n```\n", "```python\nprint(1)\n```\n"],
    ids=["other output", "failed command", "file without a name"],
)
def test_wrong_page_is_noticed(page, tmp_path, monkeypatch):
    docs = tmp_path / "repository" / "docs"
    (tmp_path / "repository" / "inputs").mkdir(parents=True)
    docs.mkdir()
    (docs / "wrong.md").write_text(page)
    (tmp_path / "work").mkdir()
    monkeypatch.setattr("tests.support.pages.REPOSITORY", tmp_path / "repository")
    with pytest.raises(AssertionError):
        carry_out("wrong.md", tmp_path / "work")
