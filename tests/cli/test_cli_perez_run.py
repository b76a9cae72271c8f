"""``run``, ``info`` and ``validate`` with a sky.toml and the options of sun and weather."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from aomc_sky.cli.main import main
from tests.support.scenes import copy_scene, run_bytes


@pytest.fixture
def amc(tmp_path: Path) -> Path:
    return copy_scene("perez_sky", tmp_path)


def run(*words: object) -> int:
    return main(["run", *map(str, words)])


def test_a_run_and_its_manifest(amc, tmp_path, capsys):
    out = tmp_path / "out"
    assert run(amc, "--iterations", 20_000, "--out", out) == 0
    shown = capsys.readouterr()
    assert "note: Perez sky: epsilon " in shown.out
    assert "note: difcol.inp: direct fraction 0.74 to 0.9" in shown.out
    assert shown.err == ""
    manifest = json.loads((out / "manifest.json").read_text())
    assert manifest["components"] == ["direct", "perez"]
    assert set(manifest["inputs"]) == {"amc", "lambbot", "difcol", "sky_toml"}
    options = manifest["options"]["scene"]
    assert options["sun"] == {"zenith_deg": 32.4, "azimuth_deg": 121.25, "disc": True, "from": "sky.toml"}
    assert set(options["perez"]) == {
        "epsilon",
        "delta",
        "coefficients",
        "limits",
        "within",
        "air_mass",
        "from",
        "limited",
    }
    assert len(options["perez"]["coefficients"]) == 5
    for band in manifest["bands"]:
        stored = np.load(out / f"photons-{band['waveband']:04d}.npy")
        assert len(stored) == band["requested"]
        assert stored[:, 2].max() < 0
        assert abs(band["mean_cosine_photons"] - band["mean_cosine_exact"]) < 1e-3


def test_options_and_sky_toml_give_the_same_bytes(amc, tmp_path):
    words = ("--iterations", 20_000, "-q", "--out")
    assert run(amc, *words, tmp_path / "file") == 0
    (amc.parent / "sky.toml").unlink()
    given = ("--dni", 850, "--dhi", 95, "--sun-zenith", 32.4, "--sun-azimuth", 121.25, "--disc")
    assert run(amc, *given, *words, tmp_path / "options") == 0
    one, two = run_bytes(tmp_path / "file"), run_bytes(tmp_path / "options")
    assert set(one) == set(two)
    assert {name for name in one if one[name] != two[name]} == {"manifest.json"}


def test_dry_run_shows_sun_and_sky(amc, capsys):
    before = sorted(p.name for p in amc.parent.iterdir())
    assert run(amc, "--dry-run", "--epsilon", 3, "--delta", 0.25, "--limits", "paper", "--within", "uniform") == 0
    out = capsys.readouterr().out
    assert "option: sun = zenith_deg 32.4, azimuth_deg 121.25, disc yes, from sky.toml" in out
    line = next(line for line in out.splitlines() if line.startswith("option: perez = "))
    assert "epsilon 3, delta 0.25, coefficients " in line
    assert "limits paper, within uniform, from epsilon 3 and Delta 0.25 (options)" in line
    assert "modelled: perez, law " in out
    assert sorted(p.name for p in amc.parent.iterdir()) == before
    assert run(amc, "--dry-run", "--json") == 0
    assert json.loads(capsys.readouterr().out)["options"]["perez"]["from"] == "dni 850 and dhi 95 W m-2 (sky.toml)"


def test_validate_reads_sky_toml(amc, capsys):
    assert main(["validate", str(amc.parent)]) == 0
    assert "sky.toml: ok" in capsys.readouterr().out
    (amc.parent / "sky.toml").write_text("[perez]\ndni = 850.0\n[sun]\nzenith_deg = 90\n")
    assert main(["validate", str(amc.parent)]) == 3
    shown = capsys.readouterr()
    assert "sky.toml:2:1: error[E705]" in shown.err
    assert "sky.toml:4:14: error[E704]" in shown.err
    copy = amc.parent / "weather.toml"
    shutil.move(amc.parent / "sky.toml", copy)
    assert main(["validate", str(copy)]) == 3
    assert run(amc.parent, "--dry-run", "--sky", "uniform") == 0


def test_run_and_validate_miss_the_same_inputs_and_show_the_lines(amc, capsys):
    for name in ("sky.toml", "difcol.inp"):
        (amc.parent / name).unlink()
    for command in ("run", "validate"):
        assert main([command, str(amc.parent)]) == 3
        shown = capsys.readouterr().err
        assert "difcol.inp: error[E100]" in shown
        assert "[perez]\ndni = 850.0 " in shown
        assert "\ndhi = 95.0 " in shown
    assert run(amc, "--dni", 850, "--dhi", 95, "--dry-run") == 0
    assert "without difcol.inp: direct fraction 0.88" in capsys.readouterr().out
    assert main(["validate", str(amc.parent), "--dni", "850", "--dhi", "95"]) == 0
    assert "difcol" not in capsys.readouterr().out
    assert main(["validate", str(amc.parent), "--dni", "850"]) == 2
    assert main(["validate", str(amc.parent), "--dni", "0", "--dhi", "0"]) == 4
