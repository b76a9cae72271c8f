"""``aomc-sky info`` of lobes at one time, and ``run`` and ``validate`` of a night: what they print and refuse."""

import json

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main
from tests.support.scenes import copy_scene, manifest_of
from tests.support.shared import INPUTS

pytest.importorskip("h5py")

NIGHT = str(INPUTS / "night_sky" / "night.h5")
WHEN = ("--time", "2026-02-14T21:30:00Z", "--utc-offset", "1")
UNIX = 1771104600.0
SOME = ("--wavelength", "440", "550")
SOME_NM = [440.0, 550.0]


def lobes(*words):
    return main(["info", *map(str, words)])


def test_values_are_those_of_the_python_names(told):
    found = json.loads(told("info", NIGHT, *WHEN, *SOME, "--json").out)
    background = sky.read_background(NIGHT, utc_offset_h=1.0)
    assert found["unix_time_s"] == UNIX
    assert found["wavelength_nm"] == [440.0, 550.0]
    assert [lobe["name"] for lobe in found["lobes"]] == ["airglow", "city", "starlight"]
    for above, name in (("sphere", "sphere_W_m2_nm"), ("projected", "irradiance_W_m2_nm")):
        for lobe in found["lobes"]:
            wanted = background.irradiance(lobe["name"], UNIX, SOME_NM, above=above)
            np.testing.assert_allclose(lobe[name], wanted, rtol=1e-12)
        np.testing.assert_allclose(found[name], background.irradiance(None, UNIX, SOME_NM, above=above), rtol=1e-12)
    city = found["lobes"][1]
    assert (city["zenith_deg"], city["azimuth_deg"]) == pytest.approx((84.0, 205.0), abs=1e-4)  # float32 in the file
    shares = background.irradiance("city", UNIX, 550.0, above="horizon") / background.irradiance("city", UNIX, 550.0)
    assert city["share_above_horizon"] == pytest.approx(float(shares), rel=1e-12)


def test_animations_files_and_keys(tmp_path, capsys):
    spectrum = [1e-9, 1e-9]
    keys = [
        sky.SkyLobe(kind="ggx", width=0.3, zenith_deg=z, spectrum=spectrum, time_days=t)
        for t, z in ((0.0, 0), (1.0, 80))
    ]
    other = tmp_path / "moving.h5"
    sky.write_background(other, sky.background_of_lobes({"moving": keys}, [500.0, 600.0], reference="absolute"))

    def names(*words):
        assert lobes(*words, "--json") == 0
        return [lobe["name"] for lobe in json.loads(capsys.readouterr().out)["lobes"]]

    assert names(NIGHT, *WHEN, "--animation", "city", "--animation", "airglow") == ["city", "airglow"]
    assert names(other, "--time", 43200) == ["moving:0", "moving:1"]
    assert names(other, "--time", 43200, "--interpolation", "slerp") == ["moving"]


def test_a_night_that_is_run_validated_and_shown(tmp_path, told):
    amc = copy_scene("night_sky", tmp_path)
    out = tmp_path / "out"
    assert main(["validate", str(amc.parent)]) == 0
    dry = told("run", amc, "--dry-run").out
    assert "not modelled: sun and sky (the backgrounds are the only source)" in dry
    assert "absolute: 8.065e-09 to 2.431e-08 W m-2 nm-1" in dry
    text = told("run", amc, "--iterations", "400", "--out", out).out
    assert "irradiance of the horizontal plane, W m-2 nm-1" in text
    shown = told("info", out).out
    table = text[text.index("irradiance of the horizontal") : text.index("\n\n2000 photons")]
    assert table in shown
    manifest = manifest_of(out)
    assert manifest["inputs"]["background_1"]["name"] == "night.h5"
    scene = sky.read_scene(amc)
    for band, row, loss in zip(
        manifest["bands"], scene.irradiance.of_component, scene.irradiance.horizon_loss, strict=True
    ):
        assert list(band["component_irradiance_W_m2_nm"].values()) == row.tolist()
        assert band["irradiance_W_m2_nm"] == pytest.approx(row.sum(), rel=1e-15)
        assert band["horizon_loss"] == loss
