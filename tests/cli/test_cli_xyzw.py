"""aomc-sky atmosphere --xyzw: what the file holds, and what is refused before any work."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from aomc_sky.cli.main import main
from tests.support.shared import INPUTS

MOLECULES = INPUTS / "atmosphere" / "molecules_only.atmo"


def run(model: Path, out: Path, *arguments: object) -> int:
    return main(["atmosphere", str(model), "--out-dir", str(out), "--xyzw", *map(str, arguments)])


def test_xyzw_is_the_sum_over_the_radiances(tmp_path: Path) -> None:
    pytest.importorskip("colour")
    pytest.importorskip("h5netcdf")
    xarray = pytest.importorskip("xarray")
    from aomc_sky.outputs.tables.atmosphere import xyzw

    assert run(MOLECULES, tmp_path / "o", "--bins", 3, 4, "--orders", 1) == 0
    with xarray.open_dataset(tmp_path / "o" / "atmosphere.nc", engine="h5netcdf") as found:
        assert found.xyzw.attrs["units"] == "cd m-2"
        assert found.xyzw.eye.values.tolist() == ["X", "Y", "Z", "W"]
        light = found.radiance.transpose(..., "wavelength").values
        np.testing.assert_allclose(found.xyzw, xyzw(light, found.wavelength.values), rtol=1e-13)
        blue = found.xyzw.sel(eye="Z") > found.xyzw.sel(eye="X")
        assert bool(blue.all())
        assert 500 < float(found.xyzw.sel(eye="Y").mean()) < 20000  # a clear sky, in cd m-2


def test_xyzw_without_the_package(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    monkeypatch.setitem(sys.modules, "colour", None)
    assert run(MOLECULES, tmp_path / "x", "--orders", 1) == 2
    assert 'pip install "aomc-sky[colour]"' in capsys.readouterr().err
    assert not (tmp_path / "x").exists()


def test_one_wavelength_has_no_colour(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("colour")
    assert run(MOLECULES, tmp_path / "x", "--wavelength", 500) == 2
    assert "two wavelengths or more" in capsys.readouterr().err
    assert not (tmp_path / "x").exists()
