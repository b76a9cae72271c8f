"""aomc-sky atmosphere: what it writes and prints, and what it refuses before any work."""

import json

import numpy as np
import pytest

import aomc_sky
from aomc_sky.cli.main import main
from tests.support.scenes import copy_scene
from tests.support.shared import INPUTS

MODEL = INPUTS / "atmosphere_sky" / "clear.atmo"
FAST = ["--bins", "9", "12", "--orders", "3", "--wavelength", "500,680"]


def run(*arguments):
    return main(["atmosphere", str(MODEL), *map(str, arguments)])


def test_one_sun_as_netcdf_and_skydist(tmp_path, capsys):
    xarray = pytest.importorskip("xarray")
    out = tmp_path / "new" / "sky"
    assert run("--out-dir", out, "--sun-zenith", 40, "--sun-azimuth", 25, "--radiance", *FAST) == 0
    printed = capsys.readouterr().out
    for word in ("optical", "salt", "sos       3", "skydist", "seconds: "):
        assert word in printed
    assert sorted(path.name for path in out.iterdir()) == [
        "atmosphere.nc", "params.atmo", "report.json", "skydist.inp",
    ]  # fmt: skip
    assert (out / "params.atmo").read_bytes() == MODEL.read_bytes()
    with xarray.open_dataset(out / "atmosphere.nc", engine="h5netcdf") as found:
        assert dict(found.sizes) == {
            "sun_zenith": 1, "wavelength": 2, "order": 3, "zenith": 9, "azimuth": 12, "species": 3, "bounds": 2,
        }  # fmt: skip
        assert found.attrs["Conventions"].startswith("CF-")
        assert found.radiance.attrs["units"] == "W m-2 sr-1 nm-1"
        assert found.wavelength.attrs["standard_name"] == "radiation_wavelength"
        assert found.zenith.attrs["bounds"] == "zenith_bounds"
        np.testing.assert_allclose(found.radiance_by_order.sum("order"), found.radiance, rtol=1e-14)
        table = aomc_sky.read_skydist(out / "skydist.inp")
        np.testing.assert_array_equal(table.radiance[:, :, :12], found.radiance[0])
        brightest = found.radiance[0, 0].argmax(...)
        assert int(brightest["azimuth"]) == 0  # the sun at 25 degrees stands in the first column of 30
        assert int(brightest["zenith"]) in (4, 8)
        area = aomc_sky.PatchGrid.regular(9, 12).projected_solid_angle_sr
        np.testing.assert_allclose(
            found.radiance[0].values.reshape(2, -1) @ area, found.diffuse_irradiance[0], rtol=1e-13
        )
        assert np.all(found.standard_error < 0.01 * found.radiance)


def test_several_suns_each_with_its_folder(tmp_path, capsys):
    assert run("--out-dir", tmp_path, "--sun-zenith", "0:60:30", "--no-netcdf", "--json", *FAST) == 0
    report = json.loads(capsys.readouterr().out)
    assert [sun["sun_zenith_deg"] for sun in report["suns"]] == [0.0, 30.0, 60.0]
    assert {path.name for path in tmp_path.iterdir()} == {"params.atmo", "report.json", "sun_0", "sun_30", "sun_60"}
    assert report["files"]["skydist sun_30"] == str(tmp_path / "sun_30" / "skydist.inp")
    stored = json.loads((tmp_path / "report.json").read_text())
    assert stored == {name: value for name, value in report.items() if name != "files"}
    direct = [sun["direct_irradiance"][0] for sun in report["suns"]]
    assert direct == sorted(direct, reverse=True)
    assert all(sum(sun["truncation"]) < 0.2 for sun in report["suns"])


def test_the_table_is_what_solve_atmosphere_gives(tmp_path, told):
    arguments = ["--sun-zenith", 40, "--no-netcdf", "--bins", 90, 4, "--orders", 3, "--wavelength", 500, "--json"]
    report = json.loads(told("atmosphere", MODEL, "--out-dir", tmp_path, *arguments).out)
    found = aomc_sky.solve_atmosphere(
        MODEL, wavelength_nm=500, sun_zenith_deg=40, sky_zenith_deg=45.5, azimuth_from_sun_deg=[135.0], orders=3
    )
    assert report["suns"][0]["direct_irradiance"][0] == pytest.approx(found.direct_irradiance[0], rel=1e-14)
    assert report["suns"][0]["diffuse_irradiance"][0] == pytest.approx(found.diffuse_irradiance[0], rel=1e-5)


def test_a_plan_without_a_solution(tmp_path, capsys):
    assert run("--no-save-tex", "--sun-zenith", "10,95", "--orders", 1, "--out-dir", tmp_path / "none") == 0
    printed = capsys.readouterr().out
    assert "not solved" in printed
    assert "    10  order1\n    95  order1\n" in printed
    assert "air" in printed
    assert list(tmp_path.iterdir()) == []


def test_low_suns(tmp_path, told, capsys):
    assert told("atmosphere", MODEL, "--no-save-tex", "--sun-zenith", "70:90:5").err.count("warning") == 2
    assert run("--no-save-tex", "--sun-zenith", "40,85,95", "--method", "auto") == 0
    assert "    40     sos\n    85      mc\n    95      mc\n" in capsys.readouterr().out
    assert run("--no-save-tex", "--sun-zenith", "85", "--strict") == 3
    assert list(tmp_path.iterdir()) == []


def test_bad_input_and_a_bad_folder_are_told_before_the_work(tmp_path, monkeypatch, told, capsys):
    def no_work(*_arguments, **_options):
        raise AssertionError("solved for nothing")

    monkeypatch.setattr("aomc_sky.engine.atmosphere.solve_table", no_work)
    broken = tmp_path / "broken.atmo"
    broken.write_text(MODEL.read_text().replace("410nm", "410 parsec"))
    for model, text in ((broken, "broken.atmo:9"), (tmp_path / "absent.atmo", "E100")):
        assert text in told("atmosphere", model, "--no-netcdf", "--out-dir", tmp_path / "x", code=3).err
    (tmp_path / "file").write_text("")
    for out in (tmp_path / "file", tmp_path / "file" / "below"):
        assert run("--out-dir", out, "--no-netcdf", *FAST) == 6
        assert "cannot create the folder" in capsys.readouterr().err
    assert not (tmp_path / "x").exists()


def test_the_version_names_the_format(capsys):
    with pytest.raises(SystemExit) as end:
        main(["atmosphere", "-v"])
    assert end.value.code == 0
    assert "version 6" in capsys.readouterr().out


def test_a_slow_sky_says_how_to_save_it_and_the_saved_one_is_a_sky(tmp_path, monkeypatch, told):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    amc = copy_scene("atmosphere_sky", tmp_path)
    small = ["--wavelength", "410,680", "--orders", "1", "--bins", "6", "12"]
    saved = amc.parent / "sky.nc"
    assert f"sky: {saved}" in told("atmosphere", amc.parent / "clear.atmo", "--out", saved, *small).out
    (amc.parent / "sky.toml").write_text('[atmosphere]\nfile = "clear.atmo"\norders = 1\nzenith_bins = 6\n')
    monkeypatch.setattr("aomc_sky.cli.options._SLOW_SKY_S", 0.0)
    assert "write aomc-sky atmosphere MODEL.atmo --out sky.nc" in told("run", amc, "--dry-run").err
    (amc.parent / "sky.toml").write_text('[sky]\ntable = "sky.nc"\n')
    (amc.parent / "difcol.inp").write_text("4\n" + "0.5 1.0\n" * 4)
    scene = aomc_sky.read_scene(amc)
    assert scene.options["field"]["variable"] == "radiance"
    with xarray.open_dataset(saved) as data:
        part = next(part for part in scene.components if part.name == "sky")
        flux = data.radiance[0, 0].values.ravel() * part.grid.projected_solid_angle_sr
    mass = part.mass[0]
    np.testing.assert_allclose(mass / mass.sum(), flux / flux.sum(), rtol=1e-12)
