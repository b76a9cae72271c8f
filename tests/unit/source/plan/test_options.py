"""Options of a run: names that no choice has are refused with those that there are."""

import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main
from aomc_sky.errors import UsageError
from tests.support.shared import INPUTS


def scene():
    return sky.Scene(wavebands=[500.0], n_photons=1000, components=sky.UniformSky().lower([500.0]))


@pytest.mark.parametrize(
    ("name", "value", "allowed"),
    [
        ("method", "halton", "'stratified', 'iid'"),
        ("method", "sobol", "'stratified', 'iid'"),
        ("placement", "sobol", "'r2', 'philox', 'centre'"),
    ],
)
def test_other_names_get_the_allowed_ones(name, value, allowed):
    with pytest.raises(UsageError, match=f"{name} must be one of {allowed}, got '{value}'"):
        scene().source(**{name: value})


def test_commands(capsys):
    with pytest.raises(SystemExit, match="2"):
        main(["run", str(INPUTS / "clear_day/amc.inp"), "--method", "sobol"])
    shown = capsys.readouterr()
    assert "stratified" in shown.err
    assert shown.out == ""
