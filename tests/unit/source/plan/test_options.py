"""A method that was removed is refused by name wherever it can stand, with what to write instead."""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main
from aomc_sky.errors import InputFileError, UsageError
from aomc_sky.plan.plan import Plan
from tests.support.shared import INPUTS

TOLD = "early builds of 0.1.0 are the last that have it"


def scene():
    bands = sky.Wavebands(wavelength_nm=np.array([500.0]))
    return sky.Scene(wavebands=bands, n_photons=1000, components=sky.UniformSky().lower([500.0]))


def plan_of_the_method():
    """Options and arrays as such a plan had them."""
    plan = scene().source(seed=3).plan
    arrays = {
        **plan.arrays,
        "sobol_mass": np.zeros_like(plan.arrays["mass"], dtype=np.uint64),
        "sobol_keys": np.zeros(2, np.uint64),
    }
    return Plan(arrays=arrays, options={**plan.options, "method": "sobol", "placement": "sobol"})


@pytest.mark.parametrize(
    "options", [{"method": "sobol"}, {"placement": "sobol"}, {"method": "sobol", "order": "patch"}]
)
def test_scene_source(options):
    with pytest.raises(UsageError, match=f"'sobol' was removed; {TOLD}; write --method stratified") as caught:
        scene().source(**options)
    assert caught.value.exit_code == 2


def test_other_names_are_told_what_there_is():
    with pytest.raises(UsageError, match="method must be one of 'stratified', 'iid', got 'halton'"):
        scene().source(method="halton")


@pytest.mark.parametrize(
    "words",
    [
        ("run", INPUTS / "clear_day/amc.inp", "--method", "sobol"),
        ("run", INPUTS / "clear_day/amc.inp", "--method=sobol", "--placement", "r2", "--dry-run"),
    ],
)
def test_commands(words, capsys):
    assert main([*map(str, words)]) == 2
    shown = capsys.readouterr()
    assert TOLD in shown.err
    assert "write --method stratified" in shown.err
    assert shown.out == ""


def test_plans(tmp_path, capsys):
    path = tmp_path / "plan.npz"
    plan_of_the_method().save(path)
    with pytest.raises(InputFileError, match=f"{TOLD} and read its plans; run the scene again") as caught:
        Plan.load(path)
    assert (caught.value.exit_code, [p.code for p in caught.value.problems]) == (3, ["E955"])
    with pytest.raises(InputFileError, match="E955"):
        sky.PhotonSource.from_plan(plan_of_the_method())
