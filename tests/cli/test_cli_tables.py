"""No table is wider than 100 columns, with the widest values that each command can meet; each number has a label."""

import re
import shutil

import pytest

import aomc_sky as sky
from aomc_sky.cli import terminal
from aomc_sky.cli.main import main
from aomc_sky.cli.terminal import WIDTH, report_text, table
from tests.support.scenes import copy_scene
from tests.support.shared import INPUTS

HAZY = INPUTS / "atmosphere" / "hazy.atmo"
DIGITS = "1234567890123456"


@pytest.mark.parametrize("n_columns", [1, 2, 20, 60])
@pytest.mark.parametrize("size", [1, 40, 150])
@pytest.mark.parametrize("n_left", [0, 3])
def test_a_wide_table_loses_nothing(n_columns, size, n_left):
    cells = [["x" * size, *(f"{row}{k}".ljust(size, "0") for k in range(n_columns - 1))] for row in range(3)]
    text = table(cells, [f"c{k}" for k in range(n_columns)], n_left=n_left)
    assert max(map(len, text.splitlines())) <= WIDTH
    assert not any(line.endswith(" ") for line in text.splitlines())
    letters = "".join(text.split())
    for row in cells:
        for cell in row[1:]:
            assert sorted(letters).count(cell[0]) >= cell.count(cell[0])
    n_blocks = text.count("\n\n") + 1
    expected = sum(len(cell) for row in cells for cell in row[1:]) + n_blocks * 3 * size
    expected += sum(len(f"c{k}") for k in range(1, n_columns)) + n_blocks * 2
    assert len(letters) == expected


def test_keys_stand_in_each_block_and_numbers_of_a_cell_have_labels():
    rows = [[str(band), f"{400 + band}", *[DIGITS] * 8] for band in (1, 2)]
    head = ["band", "nm", *(f"c{k}" for k in range(8))]
    blocks = [block.splitlines() for block in table(rows, head, n_keys=2).split("\n\n")]
    assert [block[0].split() for block in blocks] == [
        ["band", "nm", "c0", "c1", "c2", "c3"],
        ["band", "nm", "c4", "c5", "c6", "c7"],
    ]
    assert [[line.split()[:2] for line in block[1:]] for block in blocks] == [[["1", "401"], ["2", "402"]]] * 2
    values = {
        "wavelength_nm": [440.0, 550.0, 660.0],
        "suns": [{"zenith_deg": 40, "direct": [0.1, 0.2, 0.3], "quaternion": [0.5, -0.5, 0.5, 0.5]}],
    }
    text = report_text("head", values)
    assert "440 nm 0.1 ... 660 nm 0.3" in text
    assert "w 0.5 x -0.5 y 0.5 z 0.5" in text


def wide_night(folder):
    amc = copy_scene("night_sky", folder)
    lobes = {
        f"glow of the town number {k}, as far as the other side of the bay": sky.lobes.SkyLobe(
            kind="ggx", width=0.123456789, width_y=0.987654321, zenith_deg=10.123456 + k, azimuth_deg=123.456789,
            turn_deg=33.333, spectrum=[1.23456789e-8 * k] * 40,
        )
        for k in range(1, 11)
    }  # fmt: skip
    sky.lobes.write_background(
        amc.parent / "night.h5", sky.lobes.background_of_lobes(lobes, [380.123 + 9 * k for k in range(40)])
    )
    return amc


@pytest.fixture
def lines(monkeypatch):
    made: list[str] = []
    original = terminal._lines

    def kept(*arguments):
        found = list(original(*arguments))
        made.extend(found)
        return found

    monkeypatch.setattr(terminal, "_lines", kept)
    return made


@pytest.mark.slow
def test_every_table_of_the_command_line(tmp_path, capsys, monkeypatch, lines, skies_site):
    pytest.importorskip("h5py")
    monkeypatch.syspath_prepend(skies_site)
    monkeypatch.chdir(tmp_path)
    amc = wide_night(tmp_path)
    shutil.copytree(INPUTS / "clear_day", tmp_path / "clear_day")
    wide = ["--wavelengths", "443.123456 555.123456 670.123456", "--ghi", "780", "--dhi", "140", "--sun-zenith", "40"]
    commands = {
        "run of lobes": ["run", str(amc), "--iterations", "1e5", "--replicates", "4", "--out", "night", "-v"],
        "run of many": ["run", "clear_day", "--iterations", "1e18", "--format", "none", "--out", "many"],
        "run of weather": ["run", *" ".join(wide).split(), "--iterations", "1e17", "--format", "none", "--out", "day"],
        "info of a run": ["info", "night"],
        "info of many": ["info", "many"],
        "info of a scene": ["info", "clear_day", "--iterations", "1e18"],
        "run of mcpl": ["run", "clear_day", "--iterations", "1e4", "--format", "mcpl", "--out", "mcpl"],
        "info of mcpl": ["info", "mcpl/photons.mcpl"],
        "run of source": ["run", "clear_day", "--iterations", "1e4", "--format", "source", "--out", "source"],
        "info of source": ["info", "source/source.sky"],
        "info of skies": ["info", "--skies"],
        "info of lobes": ["info", str(amc.parent / "night.h5")],
        "info of lobes at a time": ["info", str(amc.parent / "night.h5"), "--time", "0"],
        "info of air": ["info", str(HAZY)],
        "atmosphere": ["atmosphere", str(HAZY), "--sun-zenith", "40.123456,60.654321", "--wavelengths", "450.5 550.5",
                       "--orders", "2", "--bins", "9", "18", "--out-dir", "air", "--no-netcdf"],
        "verify": ["verify", "mcpl"],
        "verify with tests": ["verify", "night", "--statistics", "-v"],
        "verify of others": ["verify", "mcpl/photons.mcpl", "--scene", "clear_day", "--method", "iid"],
    }  # fmt: skip
    for name, words in commands.items():
        lines.clear()
        code = main(words)
        said = capsys.readouterr().out
        assert code == (1 if name == "verify of others" else 0), (name, said)
        assert lines, name
        assert max(map(len, lines)) <= WIDTH, name
        assert all(line in said for line in lines), name
        # what is wider is a sentence, a name or a path, and no row of a table
        assert [line for line in said.splitlines() if len(line) > WIDTH and re.search(r"\S {2,}\S", line)] == [], name


def test_pulls_are_a_table_too(tmp_path, told, lines):
    """Photons that are spread evenly and judged as independent ones: the zones with the largest differences."""
    amc = copy_scene("document_example", tmp_path)
    assert main(["run", str(amc), "--iterations", "1e5", "--out", str(tmp_path / "out"), "-q"]) == 0
    other = copy_scene("clear_day", tmp_path)
    words = ["verify", str(tmp_path / "out" / "photons-0001.npy"), "--scene", str(other), "--waveband", "1"]
    assert "largest differences" in told(*words, code=1).out
    assert any("zenith [deg]" in line for line in lines)
    assert max(map(len, lines)) <= WIDTH
