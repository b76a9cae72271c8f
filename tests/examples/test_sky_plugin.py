"""The package of examples/sky_plugin, installed by pip: the skies of ISO 15469 on the command line and in Python."""

from __future__ import annotations

import dataclasses
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import mpmath
import numpy as np
import pytest

import aomc_sky as sky
from tests.support.shared import INPUTS

TYPES = range(1, 16)
GRADATION = {"I": ("4", "-0.7"), "II": ("1.1", "-0.8"), "III": ("0", "-1"), "IV": ("-1", "-0.55"), "V": ("-1", "-0.32")}
GRADATION |= {"VI": ("-1", "-0.15")}
INDICATRIX = {1: ("0", "-1", "0"), 2: ("2", "-1.5", "0.15"), 3: ("5", "-2.5", "0.3"), 4: ("10", "-3", "0.45")}
INDICATRIX |= {5: ("16", "-3", "0.3"), 6: ("24", "-2.8", "0.15")}
GROUPS = ["I1", "I2", "II1", "II2", "III1", "III2", "III3", "III4", "IV2", "IV3", "IV4", "V4", "V5", "VI5", "VI6"]
"""Gradation and indicatrix of each type as Darula and Kittler (2002) have them."""


@pytest.fixture
def cie(cie_site, monkeypatch):
    monkeypatch.syspath_prepend(cie_site)
    import cie_skies  # type: ignore[import-not-found]

    return cie_skies


def test_the_table_is_that_of_six_gradations_and_six_indicatrices(cie):
    for number, group in zip(TYPES, GROUPS, strict=True):
        expected = (*GRADATION[group[:-1]], *INDICATRIX[int(group[-1])])
        assert cie.TYPES[number] == tuple(map(float, expected))


def exact_luminance(number, zenith, azimuth, sun):
    """The standard's formula with 40 digits, from the table of groups."""
    with mpmath.workdps(40):
        group = GROUPS[number - 1]
        a, b, c, d, e = map(mpmath.mpf, (*GRADATION[group[:-1]], *INDICATRIX[int(group[-1])]))

        def phi(z):
            return 1 + a * mpmath.exp(b / mpmath.cos(z))

        def f(chi):
            return 1 + c * (mpmath.exp(d * chi) - mpmath.exp(d * mpmath.pi / 2)) + e * mpmath.cos(chi) ** 2

        z, s = mpmath.mpf(zenith), mpmath.mpf(sun)
        cosine = mpmath.cos(s) * mpmath.cos(z) + mpmath.sin(s) * mpmath.sin(z) * mpmath.cos(mpmath.mpf(azimuth))
        return float(f(mpmath.acos(cosine)) * phi(z) / (f(s) * phi(mpmath.mpf(0))))


@pytest.mark.parametrize("number", TYPES)
def test_luminances_are_those_of_the_formula(cie, number):
    for zenith, azimuth in [(0.0, 0.0), (0.3, 2.0), (1.2, 0.01), (1.5707, 3.0), (0.9, 1e-3)]:
        value = cie.make(sun_zenith_rad=0.9, sun_azimuth_rad=0.0, type=number).radiance(zenith, azimuth, 550.0)
        assert value == pytest.approx(exact_luminance(number, zenith, azimuth, 0.9), rel=1e-12)


@pytest.mark.parametrize("number", [1, 4, 8, 12, 15])
def test_the_exact_law_has_the_masses_of_the_radiance(cie, number):
    """The same sky twice: as a Perez law times a constant, and by quadrature of `radiance` over the same patches.

    The radiance has a cusp at the sun where d is steep, which the quadrature meets inside a patch.
    """
    model = cie.make(sun_zenith_rad=0.7, sun_azimuth_rad=1.0, type=number)
    (exact,) = model.lower([550.0])
    (patches,) = sky.FunctionSky(model.radiance, grid=exact.grid).lower([550.0])
    share, other = exact.mass[0] / exact.mass[0].sum(), patches.mass[0] / patches.mass[0].sum()
    assert np.abs(share - other).sum() < 1e-9


def command(*words, site, **options):
    environment = os.environ | {"PYTHONPATH": str(site)}
    program = [sys.executable, "-m", "aomc_sky", *map(str, words)]
    return subprocess.run(program, capture_output=True, text=True, env=environment, check=False, timeout=120, **options)


def test_command_line(cie_site, tmp_path):
    amc = INPUTS / "perez_sky" / "amc.inp"
    sun = ("--sun-zenith", 40, "--iterations", 20_000, "--json")
    done = command("run", amc, "--sky", "cie", "--sky-option", "type=12", *sun, "--out", tmp_path / "a", site=cie_site)
    assert done.returncode == 0, done.stderr
    manifest = json.loads(done.stdout)
    expected = {"name": "cie", "distribution": "cie-skies", "version": "1.0", "entry_point": "cie_skies:make"}
    assert manifest["options"]["scene"]["plugin"] == expected | {"options": {"type": 12}}
    assert manifest["components"] == ["direct", "cie"]
    assert sum("sky model 'cie' of cie-skies 1.0 with type 12" in note for note in manifest["notes"]) == 1

    listed = command("info", "--skies", "--json", site=cie_site)
    about = {"name": "cie", "distribution": "cie-skies", "version": "1.0", "options": ["type (needed)"]}
    found = json.loads(listed.stdout)
    assert [one for one in found["skies"] if one["distribution"] != "aomc-sky"] == [about]
    assert found["refused"] == []
    checked = command("verify", tmp_path / "a", site=tmp_path)  # the plan needs no package
    assert checked.returncode == 0, checked.stdout


def test_sky_toml_options_and_python_give_the_same_photons(cie, tmp_path):
    scene = tmp_path / "scene"
    shutil.copytree(INPUTS / "perez_sky", scene)
    (scene / "sky.toml").write_text('[sky]\nmodel = "cie"\ntype = 12\n')
    of_file = sky.read_scene(scene)
    over_file = sky.read_scene(scene, sky_options={"type": 3})
    (scene / "sky.toml").unlink()
    of_options = sky.read_scene(scene, sky="cie", sky_options={"type": 12})
    hashes = [one.source(seed=1).plan.sha256 for one in (of_file, of_options, over_file)]
    assert hashes[0] == hashes[1] != hashes[2]
    assert over_file.options["plugin"]["options"] == {"type": 3}


def test_shares_beside_the_sun_are_those_of_difcol(cie):
    scene = sky.read_scene(INPUTS / "perez_sky", sky="cie", sky_options={"type": 8})
    perez = sky.read_scene(INPUTS / "perez_sky")
    beam, diffuse = (c.strength for c in scene.components)
    of_perez = perez.components[0].strength[perez.row_of_band]
    np.testing.assert_array_equal(beam, of_perez)
    np.testing.assert_allclose(beam + diffuse, 1.0, rtol=1e-15)


def test_uniform_type_has_the_photons_of_the_law_alone(cie):
    """Type 5 is 1 everywhere: the mean cosine of a flux of constant radiance is 2/3."""
    scene = sky.read_scene(INPUTS / "clear_day", sky="cie", sky_options={"type": 5}, iterations=1_000_000)
    assert -scene.source(seed=1).photons(0).uz.mean(dtype=float) == pytest.approx(2 / 3, abs=1e-5)


def test_the_models_equal_and_hash(cie):
    one = cie.make(sun_zenith_rad=0.5, sun_azimuth_rad=0.0, type=2)
    assert one == dataclasses.replace(one)


def test_the_readme_says_what_is_typed(cie_site, tmp_path):
    readme = Path(__file__).parents[2] / "examples" / "sky_plugin" / "README.md"
    lines = [line for line in readme.read_text().splitlines() if line.startswith("aomc-sky ")]
    assert len(lines) == 2
    shutil.copytree(INPUTS, tmp_path / "inputs")
    for line in lines:
        done = command(*line.split()[1:], site=cie_site, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
