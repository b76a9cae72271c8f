"""aomc-sky atmosphere: what it writes and prints, and what it refuses before any work."""

import json
import shutil

import numpy as np
import pytest

import aomc_sky
from aomc_sky.cli.usage import IDLE
from aomc_sky.outputs.tables.atmosphere import rounded_significand
from aomc_sky.skies.atmosphere.description.keys import SIZES
from tests.support.fault_rows import command
from tests.support.scenes import copy_scene
from tests.support.shared import INPUTS

MODEL = INPUTS / "atmosphere_sky" / "clear.atmo"
FAST = ["--bins", "9", "12", "--orders", "3", "--wavelength", "500,680"]


def run(*words):
    return command("atmosphere", MODEL, *words)


def test_one_sun_as_netcdf_and_skydist(tmp_path, capsys):
    xarray = pytest.importorskip("xarray")
    out = tmp_path / "new" / "sky"
    assert run("--out-dir", out, "--sun-zenith", 40, "--sun-azimuth", 25, *FAST) == 0
    printed = capsys.readouterr().out
    for word in ("salt", "sos       3", "skydist"):
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
        table = aomc_sky.files.read_skydist(out / "skydist.inp")
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
    found = aomc_sky.solve_atmosphere(
        MODEL, wavelength_nm=500, sun_zenith_deg=30, sky_zenith_deg=45.5, azimuth_from_sun_deg=[135.0], orders=3
    )
    for part, rel in (("direct_irradiance", 1e-14), ("diffuse_irradiance", 1e-2)):  # of 9 x 12 patches
        assert report["suns"][1][part][0] == pytest.approx(getattr(found, part)[0], rel=rel)


def test_methods_of_suns_without_a_solution(tmp_path, told):
    words = ("atmosphere", MODEL, "--no-save-tex", "--out-dir", tmp_path / "none", "--sun-zenith")
    assert "    10  order1\n    95  order1\n" in told(*words, "10,95", "--orders", 1).out
    assert "    40     sos\n    85      mc\n    95      mc\n" in told(*words, "40,85,95", "--method", "auto").out
    assert told(*words, "70:90:5").err.count("warning") == 2
    told(*words, "85", "--strict", code=3)
    assert list(tmp_path.iterdir()) == []


def test_bad_input_and_a_bad_folder_are_told_before_the_work(tmp_path, monkeypatch, told):
    def no_work(*_arguments, **_options):
        raise AssertionError("solved for nothing")

    monkeypatch.setattr("aomc_sky.engine.atmosphere.solve_table", no_work)
    (tmp_path / "broken.atmo").write_text(MODEL.read_text().replace("410nm", "410 parsec"))
    (tmp_path / "file").write_text("")
    for model, out, code, said in (
        (tmp_path / "broken.atmo", "x", 3, "broken.atmo:9"),
        (tmp_path / "absent.atmo", "x", 3, "E100"),
        (MODEL, "file", 6, "cannot create the folder"),
        (MODEL, "file/below", 6, "cannot create the folder"),
    ):
        assert said in told("atmosphere", model, "--no-netcdf", "--out-dir", tmp_path / out, *FAST, code=code).err
    assert not (tmp_path / "x").exists()


def test_a_slow_sky_says_how_to_save_it(tmp_path, monkeypatch, told):
    """The words that it names are those of the command that saves it."""
    pytest.importorskip("h5netcdf")
    amc = copy_scene("atmosphere_sky", tmp_path)
    (amc.parent / "sky.toml").write_text('[atmosphere]\nfile = "clear.atmo"\norders = 1\nzenith_bins = 6\n')
    monkeypatch.setattr("aomc_sky.cli.options._SLOW_SKY_S", 0.0)
    advice = told("run", amc, "--dry-run").err
    sun = advice.partition("MODEL.atmo ")[2].partition(" --out sky.nc")[0].split()
    assert sun == ["--sun-zenith", "42", "--sun-azimuth", "65"]
    small = ["--wavelength", "410,680", "--orders", "1", "--bins", "6", "12"]
    saved = amc.parent / "sky.nc"
    assert f"sky: {saved}" in told("atmosphere", amc.parent / "clear.atmo", "--out", saved, *sun, *small).out


MOLECULES = INPUTS / "atmosphere" / "molecules_only.atmo"
SMALL = ["--bins", "3", "4", "--orders", "3", "--wavelength", "500", "--sun-zenith", "60"]
ORDER_ONE = ["--bins", "3", "4", "--orders", "1", "--wavelength", "500"]


def run_model(model, out, *words):
    pytest.importorskip("h5netcdf")
    return command("atmosphere", model, "--out-dir", out, *words)


def with_lines(folder, *lines):
    """The atmosphere of molecules with more lines at the top level."""
    shutil.copytree(MOLECULES.parent, folder / "model")
    path = folder / "model" / MOLECULES.name
    head, key, tail = path.read_text().partition("scattering orders")
    path.write_text(head + "".join(line + "\n" for line in lines) + key + tail)
    return path


def opened(folder):
    return pytest.importorskip("xarray").open_dataset(folder / "atmosphere.nc", engine="h5netcdf")


def test_every_save_option(tmp_path):
    names = ("irradiance", "scat-density", "scat-density2-from-ground", "accum-scattering")
    model = with_lines(tmp_path)
    model.write_text(model.read_text().replace("ground albedo: 0, 0, 0, 0, 0, 0, 0", "ground albedo: .4" + 6 * ", .4"))
    bits = ("--texture-save-precision", 12)
    assert run_model(model, tmp_path / "o", *[f"--save-{name}" for name in names], *SMALL) == 0
    assert run_model(model, tmp_path / "cut", *bits, *SMALL) == 0
    with opened(tmp_path / "o") as full, opened(tmp_path / "cut") as cut:
        assert not {"irradiance_by_order", "radiance_up_to_order", "source_by_order"} & set(cut.variables)
        assert (full.radiance.dtype, cut.radiance.dtype) == (np.float64, np.float32)
        np.testing.assert_array_equal(cut.radiance, rounded_significand(full.radiance.to_numpy(), 12))
        assert cut.attrs["significand_bits"] == 12
    with opened(tmp_path / "o") as found:
        np.testing.assert_allclose(found.irradiance_by_order.sum("order"), found.diffuse_irradiance, rtol=1e-13)
        assert found.irradiance_by_order.attrs["units"] == "W m-2 nm-1"
        running = found.radiance_up_to_order
        np.testing.assert_allclose(running.sel(order=1), found.radiance_by_order.sel(order=1), rtol=1e-14)
        np.testing.assert_allclose(running.isel(order=-1), found.radiance, rtol=1e-14)
        source = found.source_by_order
        assert source.dims[2:] == ("source_order", "altitude", "source_zenith", "source_azimuth")
        assert source.source_order.values.tolist() == [2, 3]
        assert np.all(source > 0)
        assert np.all(np.diff(found.altitude) < 0)
        assert np.all(found.source_from_ground <= source.sel(source_order=2).min("source_azimuth") * (1 + 1e-9))
        assert np.all(found.source_from_ground > 0)


def test_light_of_the_ground_by_orders(tmp_path, capsys):
    model = with_lines(tmp_path, *(f"light pollution texture size for {name}: 6" for name in ("VZA", "altitude")))
    key = "solar irradiance at TOA: file spectra/sun_astm_g173.csv"
    assert key in model.read_text()
    line = f"light pollution relative radiance: {','.join(['0.002'] * 7)}"
    model.write_text(model.read_text().replace(key, f"{key}\n{line}"))
    assert (
        run_model(model, tmp_path / "o", "--save-light-pollution", "--orders", 2, *ORDER_ONE[:3], *ORDER_ONE[5:]) == 0
    )
    assert "light pollution texture size for altitude" in capsys.readouterr().out
    with opened(tmp_path / "o") as found:
        glow = found.glow_by_order
        assert dict(glow.sizes) == {"wavelength": 1, "glow_order": 2, "glow_zenith": 3}
        assert glow.glow_zenith.values.tolist() == [15.0, 45.0, 75.0]
        assert np.all(found.glow_standard_error < 0.05 * glow)
        once = glow.sel(glow_order=1).values[0]
        # the farther from the zenith the more air, and less than all of it scattered by a half
        assert np.all(np.diff(once) > 0)
        assert 0 < once[0] < once[2] < 0.002 / 0.5


def test_sizes_of_the_description(tmp_path, capsys):
    sizes = {key: 10 + 2 * k for k, key in enumerate(SIZES)}
    model = with_lines(tmp_path, *(f"{key}: {size}" for key, size in sizes.items()))
    assert run_model(model, tmp_path / "o", "--no-save-tex", "--sun-zenith", "all", "--orders", 1, "--json") == 0
    report = json.loads(capsys.readouterr().out)
    named = [sizes[f"scattering texture size for {name}"] for name in ("vza", "dot(view,sun)", "sza")]
    assert report["bins"] == [named[0] // 2, named[1]]
    suns = [sun["sun_zenith_deg"] for sun in report["suns"]]
    np.testing.assert_allclose(suns, np.linspace(0, 90, named[2]), atol=1e-9)
    assert report["sizes"] == sizes
    assert run_model(model, tmp_path / "o", "--no-save-tex", "--bins", 5, 6, "--orders", 1) == 0
    printed = capsys.readouterr().out
    assert "bins: zenith 5, azimuth 6" in printed
    assert all(key in printed for key in SIZES)


@pytest.mark.parametrize("option", IDLE)
def test_options_of_calcmysky_that_would_change_nothing_are_refused(option, tmp_path, capsys):
    assert run_model(MOLECULES, tmp_path, "--no-save-tex", option) == 2
    assert f"atmosphere has no option {option}; leave it out: {IDLE[option]}" in capsys.readouterr().err
