"""Rows 34 and 35 of the matrix: the Perez sky at the edges of its inputs, and where its luminance is negative."""

import json
import math

import numpy as np
import pytest

import aomc_sky as sky
from tests.reference import perez_exact
from tests.support.fault_rows import command, row, row_id, run_scene
from tests.support.scenes import copy_scene

EDGES = {
    # name: sun zenith [deg], epsilon, Delta, row of Table 1 [from 1], Delta that is used, words of the warning
    "sun-at-the-zenith": ("0", "3.0", "0.2", 6, "0.2", None),
    "epsilon-on-the-first-edge": ("40", "1.065", "0.2", 2, "0.2", None),
    "epsilon-below-the-last-edge": ("40", repr(math.nextafter(6.2, 0.0)), "0.2", 7, "0.2", None),
    "epsilon-above-12": ("40", "40", "0.15", 8, "0.15", None),
    "delta-below-the-floor-of-rows-2-to-5": ("40", "1.1", "0.05", 2, "0.2", "Delta was limited to 0.2"),
}


@pytest.mark.parametrize("name", EDGES, ids=[row_id(34, name) for name in EDGES])
def test_edges_of_the_inputs(name, told):
    """The bin and its coefficients are those of the paper, on either side of every edge; a limit is told."""
    zenith, epsilon, delta, table_row, used, warning = EDGES[name]
    words = ("perez", "--sun-zenith", zenith, "--epsilon", epsilon, "--delta", delta)
    said = told(*words, "--json")
    found = json.loads(said.out)
    assert (found["bin"], found["epsilon_used"]) == (table_row, min(float(epsilon), 12.01))
    assert found["delta_used"] == float(used)
    exact = [float(value) for value in perez_exact.coefficients(table_row - 1, used, zenith)]
    assert list(found["coefficients"].values()) == pytest.approx(exact, rel=1e-12, abs=1e-14)
    assert 0 < found["horizontal_integral"] < math.inf
    assert (said.err == "") is (warning is None)
    if warning:
        assert warning in said.err
        assert "--strict turns warnings into errors" in told(*words, "--strict", code=3).err


REFUSED = {
    "sun-on-the-horizon": (["--sun-zenith", 90, "--epsilon", 3, "--delta", 0.2], 4, "0 to below 90 degrees, got 90"),
    "no-diffuse-light": (["--sun-zenith", 40, "--dni", 850, "--dhi", 0], 4, "the diffuse irradiance is 0"),
    "beam-above-the-sun-itself": (["--sun-zenith", 89.9, "--ghi", 20, "--dhi", 15], 4, "is a beam of 2865 W m-2"),
    "beam-above-the-global": (["--sun-zenith", 40, "--ghi", 600, "--dni", 900], 4, "dni cos Z is 689.44 W m-2"),
    "epsilon-below-1": (["--sun-zenith", 40, "--epsilon", 0.99, "--delta", 0.2], 2, "outside the range 1 or more"),
    "epsilon-nan": (["--sun-zenith", 40, "--epsilon", "nan", "--delta", 0.2], 2, "epsilon"),
}


@pytest.mark.parametrize("name", REFUSED, ids=[row_id(34, name) for name in REFUSED])
def test_no_substitute_sky(name, told):
    words, code, text = REFUSED[name]
    said = told("perez", *words, code=code)
    assert text in said.err
    assert said.out == ""
    assert "Traceback" not in said.err


@row(34, "no-diffuse-light-in-a-run")
def test_no_substitute_sky_in_a_run(fault, tmp_path, capsys):
    """Irradiances without diffuse light launch the beam alone; a sky that difcol.inp needs is refused."""
    options = ["--sky", "perez", "--dni", 850, "--dhi", 0, "--sun-zenith", 40]
    answer = run_scene(tmp_path, {}, options, capsys)
    assert answer.code == 0
    assert "all light is direct, so no sky is modelled" in answer.out
    zenith = np.deg2rad(40.0)
    for path in sorted(answer.folder.glob("photons-*.npy")):
        np.testing.assert_allclose(np.load(path)[:, 2], -np.cos(zenith), rtol=1e-6)
    scene = copy_scene("perez_sky", tmp_path).parent
    (scene / "sky.toml").write_text("[perez]\ndni = 850.0\ndhi = 0.0\n")
    assert command("run", scene, "--out", tmp_path / "out") == 4
    said = capsys.readouterr()
    assert said.out == ""
    assert "give a positive diffuse irradiance" in said.err
    assert not (tmp_path / "out").exists()


DARK_ABOVE_60 = [-math.exp(2.0), -1.0, 1.0, -1.0, 0.0]
"""1 - exp(2 - 1/cos xi) is negative within 60 degrees of the zenith: half the solid angle of the sky."""


@row(35, "negative-luminance-counts-as-0")
def test_negative_luminance(fault, tmp_path, capsys):
    keys = "".join(f"{key} = {value!r}\n" for key, value in zip("abcde", DARK_ABOVE_60, strict=True))
    options = ["--sky", "perez", "--sun-zenith", 23, "--iterations", 20_000, "-q"]
    answer = run_scene(tmp_path, {"sky.toml": f"[perez]\n{keys}"}, options, capsys)
    assert answer.code == 0
    assert answer.err.count("warning: ") == 1
    assert "the luminance is negative over 50 % of the sky and counts as 0 there" in answer.err
    for band in (1, 2, 3):
        directions = np.load(answer.folder / f"photons-{band:04d}.npy")
        assert directions.shape == (20_000, 3)
        assert 0.49 < -directions[:, 2].min() <= 0.5  # up to the border and not beyond


@row(35, "b-above-0")
def test_an_infinite_horizon(fault, told):
    """exp(b / cos xi) with b > 0 has no end at the horizon: b becomes 0, which is told."""
    said = told("perez", "--sun-zenith", 40, "--coefficients", 0.1, 0.5, 1, -1, 0, "--json")
    assert "b = 0.5 makes the horizon infinitely bright or dark and was set to 0" in said.err
    exact = 1.1 * sky.perez.horizontal_integral([0.0, 0.0, 1.0, -1.0, 0.0], np.deg2rad(40.0))
    assert json.loads(said.out)["horizontal_integral"] == pytest.approx(exact, rel=1e-12)
