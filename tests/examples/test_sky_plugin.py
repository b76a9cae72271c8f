"""The package of examples/sky_plugin, installed by pip: its sky on the command line and in Python."""

import json
import os
import shutil
import subprocess
import sys

import pytest

import aomc_sky as sky
from tests.support.shared import INPUTS, REPOSITORY

EXAMPLE = REPOSITORY / "examples" / "sky_plugin"


@pytest.fixture
def installed(skies_site, monkeypatch):
    monkeypatch.syspath_prepend(skies_site)


def command(*words, site, **options):
    environment = os.environ | {"PYTHONPATH": str(site)}
    program = [sys.executable, "-m", "aomc_sky", *map(str, words)]
    return subprocess.run(program, capture_output=True, text=True, env=environment, check=False, timeout=120, **options)


def test_command_line(skies_site, tmp_path):
    amc = INPUTS / "perez_sky" / "amc.inp"
    chosen = ("--sky", "bright_zenith", "--sky-option", "brightening=1.23", "--iterations", 20_000, "--json")
    done = command("run", amc, *chosen, "--out", tmp_path / "a", site=skies_site)
    assert done.returncode == 0, done.stderr
    manifest = json.loads(done.stdout)
    expected = {"name": "bright_zenith", "distribution": "our-skies", "version": "0.1", "entry_point": "our_skies:make"}
    assert manifest["options"]["scene"]["plugin"] == expected | {"options": {"brightening": 1.23}}
    assert manifest["components"] == ["direct", "bright_zenith"]
    assert sum("'bright_zenith' of our-skies 0.1 with brightening 1.23" in note for note in manifest["notes"]) == 1

    listed = command("info", "--skies", "--json", site=skies_site)
    about = {"name": "bright_zenith", "distribution": "our-skies", "version": "0.1", "options": ["brightening"]}
    found = json.loads(listed.stdout)
    assert [one for one in found["skies"] if one["distribution"] != "aomc-sky"] == [about]
    assert found["refused"] == []
    checked = command("verify", tmp_path / "a", site=tmp_path)  # the plan needs no package
    assert checked.returncode == 0, checked.stdout


def test_sky_toml_options_and_python_give_the_same_photons(installed, tmp_path):
    scene = tmp_path / "scene"
    shutil.copytree(INPUTS / "perez_sky", scene)
    (scene / "sky.toml").write_text('[sky]\nmodel = "bright_zenith"\nbrightening = 1\n')
    by_file = sky.read_scene(scene)
    over_file = sky.read_scene(scene, sky_options={"brightening": 3})
    (scene / "sky.toml").unlink()
    by_options = sky.read_scene(scene, sky="bright_zenith", sky_options={"brightening": 1})
    hashes = [one.source(seed=1).plan.sha256 for one in (by_file, by_options, over_file)]
    assert hashes[0] == hashes[1] != hashes[2]
    assert over_file.options["plugin"]["options"] == {"brightening": 3}


@pytest.mark.parametrize("brightening", [0, 1.23])
def test_the_mean_cosine_is_that_of_the_integrals(installed, brightening):
    """Mean of mu of the flux mu (1 + b mu) by hand: (1/3 + b/4) / (1/2 + b/3)."""
    options = {"sky_options": {"brightening": brightening}, "iterations": 400_000}
    scene = sky.read_scene(INPUTS / "clear_day", sky="bright_zenith", **options)
    exact = (1 / 3 + brightening / 4) / (1 / 2 + brightening / 3)
    assert -scene.source(seed=1).photons(0).uz.mean(dtype=float) == pytest.approx(exact, abs=2e-5)


def test_the_readme_says_what_is_typed(skies_site, tmp_path):
    lines = [line for line in (EXAMPLE / "README.md").read_text().splitlines() if line.startswith("aomc-sky ")]
    assert len(lines) == 2
    shutil.copytree(INPUTS, tmp_path / "inputs")
    for line in lines:
        done = command(*line.split()[1:], site=skies_site, cwd=tmp_path)
        assert done.returncode == 0, done.stderr


def test_the_page_of_own_skies_shows_it():
    page = (REPOSITORY / "docs/howto/own_sky.md").read_text()
    for name in ("our_skies.py", "pyproject.toml"):
        assert f"```{{literalinclude}} ../../examples/sky_plugin/{name}\n" in page
        assert (EXAMPLE / name).exists()
