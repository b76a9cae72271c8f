"""``info`` and ``validate`` of background-sky files, of lobes at one time, and of descriptions of an atmosphere."""

import json
import os

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.commands.info import include_dir
from aomc_sky.cli.main import main
from tests.support.background import LOBES, plain_file
from tests.support.processes import limited
from tests.support.scenes import manifest_of
from tests.support.shared import DATA, INPUTS

NIGHT = DATA / "background/good/three_keys.h5"


def test_info_lists_animations_keys_and_spectra(told):
    pytest.importorskip("h5py")
    lines = told("info", NIGHT).out.splitlines()
    assert lines[0] == f"background-sky file {NIGHT}, 1 animation with 3 keys"
    assert "author: Grüße" in lines
    assert "2 curves [W m-2 nm-1] at 3 wavelengths, 500 to 750 nm" in lines
    facts = json.loads(told("info", "--json", NIGHT).out)
    keys = facts["animations"]["a"]["keys"]
    assert [key["type"] for key in keys] == ["hg", "ggx", "beckmann"]
    assert keys[1]["quaternion"] == [0.5, -0.5, 0.5, 0.5]
    assert (facts["wavelength_nm"], facts["curves"][1]["greatest"]) == ([500.0, 625.0, 750.0], 10.0)


def test_long_names_and_lists_are_cut(tmp_path, told):
    pytest.importorskip("h5py")

    def change(file):
        file.move("LobeAnims/a", "LobeAnims/\x1b[31m" + "x" * 1000)

    path = plain_file(tmp_path / "y.h5", change=change, reference=(1, 2**63), lobes=LOBES[:1] * 120)
    text = told("info", path).out
    assert "\x1b" not in text
    assert f"reference: absolute\ntime point s: {2**63}\n" in text
    assert "... and 80 more (--json has all)" in text


MARS = INPUTS / "atmosphere" / "mars_like.atmo"


def test_info_prints_what_an_atmosphere_contains(told):
    lines = told("info", MARS).out.splitlines()
    assert lines[0] == f"atmosphere description {MARS}"
    assert "scattering orders: 15" in lines
    assert lines[-9].split() == ["nm", "irradiance", "albedo", "co2", "dust", "co2", "dust"]
    found = json.loads(told("info", MARS, "--json").out)
    assert [line for line in lines if line.startswith("note: ")] == [f"note: {found['notes'][0]}"]
    assert [part["name"] for part in found["scatterers"]] == ["co2", "dust"]
    # p / (m g) of the gas times its cross section, by hand: 610 Pa / (43.3 u 3.72 m s-2) 1.053e-31 m2 0.4^-4
    column = 610 / (43.3 * 1.66054e-27 * 3.72)
    assert found["optical_depth"]["co2"][0] == pytest.approx(column * 1.053e-31 * 0.4**-4, rel=1e-3)
    assert found["phase_norm"]["dust"] == pytest.approx([1.0] * 8, abs=1e-9)
    assert found["negligible_species"] == []


def test_allow_path_lets_tables_lie_elsewhere(tmp_path, told):
    (tmp_path / "home").mkdir()
    (tmp_path / "sun.csv").write_text("300,1\n900,1\n")
    path = tmp_path / "home" / "x.atmo"
    text = (DATA / "atmo" / "good" / "plain.atmo").read_text()
    path.write_text(text.replace("1.5, 1.9, 1.7, 1.4", "file ../sun.csv"))
    for command in ("info", "validate"):
        assert "error[E402]" in told(command, path, code=3).err
        assert main([command, str(path), "--allow-path", str(tmp_path)]) == 0


def test_info_prints_the_folder_of_the_header(told):
    assert told("info", "--include-dir").out.strip() == str(include_dir())
    assert all((include_dir() / f"aomc_sky.{end}").is_file() for end in ("h", "c"))


def test_info_of_a_scene_and_of_a_run(amc, tmp_path, told):
    assert "skydist.inp" in told("info", amc.parent).out
    assert len(json.loads(told("info", amc, "--json").out)["wavebands"]) == 3
    out = tmp_path / "out"
    told("run", amc, "--iterations", 1000, "--seed", 77, "--out", out, "-q")
    assert "seed 77" in told("info", out).out
    assert json.loads(told("info", out, "--json").out) == json.loads((out / "manifest.json").read_text())


def test_file_names_need_not_be_text(amc, tmp_path):
    folder = os.fsencode(tmp_path) + b"/sc\xffne"
    os.rename(amc.parent, folder)
    for name in ("info", "validate"):
        done = limited(tmp_path, name, os.fsdecode(folder))
        assert done.code == 0, done.err


CITY = INPUTS / "night_sky" / "night.h5"
WHEN = ("--time", "2026-02-14T21:30:00Z", "--utc-offset", "1")
UNIX = 1771104600.0
SOME = ("--wavelength", "440", "550")
SOME_NM = [440.0, 550.0]


def test_values_are_those_of_the_python_names(told):
    pytest.importorskip("h5py")
    found = json.loads(told("info", CITY, *WHEN, *SOME, "--json").out)
    background = sky.read_background(CITY, utc_offset_h=1.0)
    assert (found["unix_time_s"], found["wavelength_nm"]) == (UNIX, SOME_NM)
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


def test_animations_files_and_keys(tmp_path, told):
    pytest.importorskip("h5py")
    spectrum = [1e-9, 1e-9]
    keys = [
        sky.lobes.SkyLobe(kind="ggx", width=0.3, zenith_deg=z, spectrum=spectrum, time_days=t)
        for t, z in ((0.0, 0), (1.0, 80))
    ]
    other = tmp_path / "moving.h5"
    sky.lobes.write_background(
        other, sky.lobes.background_of_lobes({"moving": keys}, [500.0, 600.0], reference="absolute")
    )

    def names(*words):
        return [lobe["name"] for lobe in json.loads(told("info", *words, "--json").out)["lobes"]]

    assert names(CITY, *WHEN, "--animation", "city", "--animation", "airglow") == ["city", "airglow"]
    assert names(other, "--time", 43200) == ["moving:0", "moving:1"]
    assert names(other, "--time", 43200, "--interpolation", "slerp") == ["moving"]


def test_a_run_of_a_night_keeps_the_light_of_each_background(tmp_path, told):
    pytest.importorskip("h5py")
    out = tmp_path / "out"
    told("run", INPUTS / "night_sky", "--iterations", 400, "--format", "none", "--out", out, "-q")
    known = sky.read_scene(INPUTS / "night_sky").irradiance
    for band, row, loss in zip(manifest_of(out)["bands"], known.of_component, known.horizon_loss, strict=True):
        assert list(band["component_irradiance_W_m2_nm"].values()) == row.tolist()
        assert (band["irradiance_W_m2_nm"], band["horizon_loss"]) == (pytest.approx(row.sum(), rel=1e-15), loss)
