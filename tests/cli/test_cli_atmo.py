"""``info`` and ``validate`` of descriptions of an atmosphere."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from aomc_sky.cli.main import main
from tests.support.shared import DATA, INPUTS

MARS = INPUTS / "atmosphere" / "mars_like.atmo"
EVERY_KEY = DATA / "atmo" / "good" / "every_key.atmo"
BAD = DATA / "atmo" / "bad" / "exponent.atmo"


def test_info_prints_what_the_file_contains(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(MARS)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"atmosphere description {MARS}, 2 scatterers, 0 absorbers, 8 wavelengths"
    assert lines[1] == "ground at 3389.5 km, top 120 km above it"
    assert "sun at 1.524 AU" in lines
    (dust,) = (line for line in lines if line.startswith("scatterer dust: 1.4e-11 m2 at 1 um"))
    assert "density in lines 37 to 39, achromatic phase function in lines 43 to 44, integral 1.000000" in dust
    assert lines[-9].split()[:3] == ["nm", "sun", "W"]
    assert [float(word) for word in lines[-8].split()][:4] == [400.0, 0.667962, 0.05, 0.73]


def test_info_prints_every_number_of_points(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(EVERY_KEY)]) == 0
    out = capsys.readouterr().out
    assert "  angular integration points for eclipse: 511\n" in out
    assert "moon at 384400 km" in out
    assert "glow of the ground: scaled to 1 cd/m2 from" in out
    assert out.count("\n  ") >= 22


def test_info_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(MARS), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["format"], found["scattering_orders"]) == ("atmosphere description", 15)
    assert [part["name"] for part in found["scatterers"]] == ["co2", "dust"]
    assert found["scatterers"][1]["needs_interpolation_guides"]
    # p / (m g) of the gas times its cross section, by hand: 610 Pa / (43.3 u 3.72 m s-2) 1.053e-31 m2 0.4^-4
    column = 610 / (43.3 * 1.66054e-27 * 3.72)
    assert found["optical_depth"]["co2"][0] == pytest.approx(column * 1.053e-31 * 0.4**-4, rel=1e-3)
    assert found["phase_norm"]["dust"] == pytest.approx([1.0] * 8, abs=1e-9)
    assert found["negligible_species"] == []


@pytest.mark.parametrize("command", ["info", "validate"])
def test_a_bad_file_is_told_with_its_place(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, str(BAD)]) == 3
    error = capsys.readouterr().err
    assert ":2:20: error[E401]: atmosphere height: '1e3 km' has an exponent" in error
    assert ":3:15: error[E401]" in error


def test_validate_reads_the_code_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "x.atmo"
    text = (DATA / "atmo" / "good" / "plain.atmo").read_text()
    path.write_text(text)
    assert main(["validate", str(path)]) == 0
    path.write_text(text.replace("return 1e18;", "return nothing;"))
    assert main(["validate", str(path)]) == 3
    assert f"{path}:26:16: error[E403]" in capsys.readouterr().err


def test_allow_path_lets_tables_lie_elsewhere(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "home").mkdir()
    (tmp_path / "sun.csv").write_text("300,1\n900,1\n")
    path = tmp_path / "home" / "x.atmo"
    text = (DATA / "atmo" / "good" / "plain.atmo").read_text()
    path.write_text(text.replace("1.5, 1.9, 1.7, 1.4", "file ../sun.csv"))
    for command in ("info", "validate"):
        assert main([command, str(path)]) == 3
        assert "error[E402]" in capsys.readouterr().err
        assert main([command, str(path), "--allow-path", str(tmp_path)]) == 0
