"""Values of skydist.inp that nothing explains: shares of the light, or radiances. A warning names both readings."""

import warnings

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.scenes import copy_scene

N_RINGS = 90


@pytest.fixture
def radiances(tmp_path):
    """A scene whose file holds the radiances 1 + 2 cos z of rings."""
    amc = copy_scene("overcast", tmp_path)
    (amc.parent / "sky.toml").unlink()
    zenith = (np.arange(N_RINGS) + 0.5) * np.pi / 2 / N_RINGS
    rows = [f"1 {ring} 0 {1 + 2 * np.cos(z):.6f}\n" for ring, z in enumerate(zenith, start=1)]
    (amc.parent / "skydist.inp").write_text(f"{N_RINGS} {N_RINGS} 0 1\n550\n{''.join(rows)}")
    return amc


def ed_over_eo(scene):
    return scene.source(seed=1).exact_moments(0).planar_over_scalar


def test_both_readings_are_named_with_their_irradiances(radiances):
    """Ed/Eo of 1 + 2 cos z: (1/2 + 2/3) / (1 + 1) as radiances."""
    with pytest.warns(sky.InputWarning, match="E312") as said:
        scene = sky.read_scene(radiances)
    text = str(said[0].message)
    as_radiances = ed_over_eo(sky.read_scene(radiances, weighting="projected"))
    assert as_radiances == pytest.approx(7 / 12, rel=1e-4)
    for option, value in (("listed", ed_over_eo(scene)), ("projected", as_radiances)):
        assert f"--weighting {option}" in text
        assert f"{value:.4f}" in text


@pytest.mark.parametrize("statement", ["argument", "preset", "sky.toml", "file", "alike"])
def test_a_statement_or_readings_alike_are_silent(radiances, statement):
    given = {"argument": {"weighting": "listed"}, "preset": {"compat": "aomc"}}.get(statement, {})
    file = radiances.parent / "skydist.inp"
    if statement == "sky.toml":
        (radiances.parent / "sky.toml").write_text('[sky]\nweighting = "projected"\n')
    elif statement == "file":
        file.write_text(file.read_text() + "# aomc-sky bins=equal values=radiance\n")
    elif statement == "alike":  # one ring: both readings are one sky
        file.write_text("1 1 0 1\n550\n1 1 0 1.0\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = sky.read_scene(radiances, **given)
    if statement in ("sky.toml", "file"):
        assert ed_over_eo(scene) == pytest.approx(7 / 12, rel=1e-4)


def test_the_key_is_that_of_skydist_inp(radiances):
    toml = radiances.parent / "sky.toml"
    toml.write_text('[sky]\nmodel = "overcast"\nweighting = "projected"\n')
    with pytest.raises(sky.InputFileError, match="E705"):
        sky.read_scene(radiances)
    toml.write_text('[sky]\nweighting = "projected"\n')
    assert any("weighting" in note for note in sky.read_scene(radiances, sky="uniform").notes)


def test_quiet_says_it_and_strict_refuses_it(radiances, tmp_path, told):
    out = tmp_path / "out"
    assert "E312" in told("run", radiances, "--format", "none", "--out", out, "-q").err
    assert "E312" in told("run", radiances, "--format", "none", "--out", out, "--strict", code=3).err


@pytest.mark.parametrize(("header", "is_told"), [(11, False), (12, True)])
def test_a_header_with_the_number_of_columns_is_told(radiances, header, is_told):
    """sky_azimuth is the largest index: 12 columns numbered from 0 want 11, else a twelfth of the sky is dark."""
    rows = "".join(f"1 {ring} {column} 1.0\n" for ring in (1, 2) for column in range(12))
    (radiances.parent / "skydist.inp").write_text(f"24 2 {header} 1\n550\n{rows}")
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        sky.read_scene(radiances, weighting="listed")
    assert any("E313" in str(one.message) for one in said) == is_told
