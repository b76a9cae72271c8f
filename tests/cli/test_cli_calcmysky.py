"""The options and keys that aomc-sky atmosphere has from calcmysky: what they write, say and refuse."""

import json
import shutil

import numpy as np
import pytest

from aomc_sky.cli.main import main
from aomc_sky.skies.atmosphere.description.keys import SIZES
from tests.support.shared import INPUTS

xarray = pytest.importorskip("xarray")
pytest.importorskip("h5netcdf")

MOLECULES = INPUTS / "atmosphere" / "molecules_only.atmo"
FAST = ["--bins", "3", "4", "--orders", "3", "--wavelength", "500", "--sun-zenith", "60"]
ORDER_ONE = ["--bins", "3", "4", "--orders", "1", "--wavelength", "500"]


def run(model, out, *arguments):
    return main(["atmosphere", str(model), "--out-dir", str(out), *map(str, arguments)])


def with_lines(folder, *lines):
    """The atmosphere of molecules with more lines at the top level."""
    shutil.copytree(MOLECULES.parent, folder / "model")
    path = folder / "model" / MOLECULES.name
    head, key, tail = path.read_text().partition("scattering orders")
    path.write_text(head + "".join(line + "\n" for line in lines) + key + tail)
    return path


def opened(folder):
    return xarray.open_dataset(folder / "atmosphere.nc", engine="h5netcdf")


def test_every_save_option(tmp_path):
    names = ("irradiance", "scat-density", "scat-density2-from-ground", "delta-scattering", "accum-scattering")
    model = with_lines(tmp_path)
    model.write_text(model.read_text().replace("ground albedo: 0, 0, 0, 0, 0, 0, 0", "ground albedo: .4" + 6 * ", .4"))
    assert run(model, tmp_path / "o", *[f"--save-{name}" for name in names], *FAST) == 0
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


def test_significands(tmp_path):
    """And a file without any of these options has float64 and no further variable."""
    assert run(MOLECULES, tmp_path / "full", *ORDER_ONE) == 0
    for bits in (4, 24):
        assert run(MOLECULES, tmp_path / "cut", "--texture-save-precision", bits, *ORDER_ONE) == 0
        with opened(tmp_path / "full") as full, opened(tmp_path / "cut") as cut:
            named = {"irradiance_by_order", "radiance_up_to_order", "source_by_order", "source_from_ground"}
            assert not named & set(full.variables)
            assert (full.radiance.dtype, cut.radiance.dtype) == (np.float64, np.float32)
            np.testing.assert_allclose(cut.radiance, full.radiance, rtol=2.0**-bits)
            significand = np.ldexp(np.frexp(cut.radiance.values.astype(np.float64))[0], bits)
            np.testing.assert_array_equal(significand, np.rint(significand))
            np.testing.assert_array_equal(cut.zenith_bounds, full.zenith_bounds)
            assert cut.attrs["significand_bits"] == bits
        full_text, cut_text = ((tmp_path / name / "skydist.inp").read_text() for name in ("full", "cut"))
        assert full_text == cut_text


def test_light_of_the_ground_by_orders(tmp_path, capsys):
    model = with_lines(
        tmp_path,
        "light pollution texture size for VZA: 6",
        "light pollution texture size for altitude: 7",
    )
    key, values = "solar irradiance at TOA: file spectra/sun_astm_g173.csv", "0.002"
    assert key in model.read_text()
    count = 7
    line = f"light pollution relative radiance: {','.join([values] * count)}"
    model.write_text(model.read_text().replace(key, f"{key}\n{line}"))
    assert run(model, tmp_path / "o", "--save-light-pollution", "--orders", 2, "--bins", 3, 4, "--wavelength", 500) == 0
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
    model = with_lines(tmp_path, *(f"{key}: {10 + 2 * k}" for k, key in enumerate(SIZES)))
    assert run(model, tmp_path / "o", "--no-save-tex", "--sun-zenith", "all", "--orders", 1, "--json") == 0
    report = json.loads(capsys.readouterr().out)
    sizes = {key: 10 + 2 * k for k, key in enumerate(SIZES)}
    assert report["bins"] == [
        sizes["scattering texture size for vza"] // 2,
        sizes["scattering texture size for dot(view,sun)"],
    ]
    suns = [sun["sun_zenith_deg"] for sun in report["suns"]]
    np.testing.assert_allclose(suns, np.linspace(0, 90, sizes["scattering texture size for sza"]), atol=1e-9)
    assert report["sizes"] == sizes
    assert run(model, tmp_path / "o", "--no-save-tex", "--bins", 5, 6, "--orders", 1) == 0
    printed = capsys.readouterr().out
    assert "bins: zenith 5, azimuth 6" in printed
    assert all(key in printed for key in SIZES)


def test_options_that_change_nothing_say_so(tmp_path, capsys):
    given = ["--no-save-tex", "--no-eds-tex", "--save-delta-scattering", "--opengl-info"]
    assert run(MOLECULES, tmp_path, *given, "--json") == 0
    out, err = capsys.readouterr()
    json.loads(out)
    assert "--no-eds-tex has no effect" in err
    assert "--save-delta-scattering has no effect" in err
    assert "--opengl-info has no effect: OpenGL is not used" in err
    assert run(MOLECULES, tmp_path, *given[:3], "--quiet") == 0
    assert capsys.readouterr() == ("", "")
