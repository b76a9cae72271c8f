"""``info`` and ``validate`` of background-sky files, with h5py and without it."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from aomc_sky.cli.main import main
from tests.support.background import LOBES, plain_file
from tests.support.shared import DATA, SHARED, needs_shared

WITHOUT = "import sys; sys.modules['h5py'] = None; from aomc_sky.cli.main import main; sys.exit(main(sys.argv[1:]))"
GOOD = DATA / "background/good/three_keys.h5"


@pytest.mark.parametrize("command", ["info", "validate"])
def test_without_the_extra_the_command_to_install_it_is_named(command):
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT, command, str(GOOD)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert 'pip install "aomc-sky[hdf5]"' in done.stderr
    assert "Traceback" not in done.stderr


def test_info_lists_animations_keys_and_spectra(capsys):
    pytest.importorskip("h5py")
    assert main(["info", str(GOOD)]) == 0
    text = capsys.readouterr().out
    assert text.startswith(f"background-sky file {GOOD}, 1 animation with 3 keys\nname: sky\nauthor: Grüße\n")
    lines = text.splitlines()
    start = lines.index("a: diurnal, 3 keys")
    assert [line.split() for line in lines[start + 2 : start + 5]] == [
        ["0", "hg", "0.5", "-", "0.25", "1", "0", "0", "0", "1"],
        ["0.25", "ggx", "0.25", "1.5", "1", "0.5", "-0.5", "0.5", "0.5", "0"],
        ["1", "beckmann", "0.375", "2", "0", "0", "0", "0", "-1", "1"],
    ]
    assert "2 curves at 3 wavelengths, 500 to 750 nm" in lines
    assert lines[-1].split() == ["1", "4e-08", "10", "1250"]


def test_info_as_json_is_one_object(capsys):
    pytest.importorskip("h5py")
    assert main(["info", "--json", str(GOOD)]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["format"] == "background sky"
    assert facts["info"]["format_version"] == 1
    assert facts["wavelength_nm"] == [500.0, 625.0, 750.0]
    keys = facts["animations"]["a"]["keys"]
    assert [key["type"] for key in keys] == ["hg", "ggx", "beckmann"]
    assert keys[1]["quaternion"] == [0.5, -0.5, 0.5, 0.5]
    assert facts["curves"][1]["greatest"] == 10.0


def test_names_from_a_file_do_not_disturb_a_terminal(tmp_path, capsys):
    pytest.importorskip("h5py")

    def change(file):
        file.move("LobeAnims/a", "LobeAnims/\x1b[31mred")
        file["LobeAnims"].move("\x1b[31mred", "\x1b[31m" + "x" * 1000)

    path = plain_file(tmp_path / "x.h5", change=change, reference=(1, 2**63), lobes=LOBES * 40)
    assert main(["info", str(path)]) == 3  # times fall
    assert "\x1b" not in capsys.readouterr().err
    path = plain_file(tmp_path / "y.h5", change=change, reference=(1, 2**63), lobes=LOBES[:1] * 120)
    assert main(["info", str(path)]) == 0
    text = capsys.readouterr().out
    assert "\x1b" not in text
    assert f"absolute from {2**63} s since 1970, 120 keys" in text
    assert "... and 20 more keys" in text


def test_validate_tells_good_from_bad(capsys):
    pytest.importorskip("h5py")
    bad = DATA / "background/bad/values.h5"
    assert main(["validate", "--json", str(GOOD), str(bad)]) == 3
    good, worse = json.loads(capsys.readouterr().out)["files"]
    assert good["ok"]
    assert good["problems"] == []
    assert not worse["ok"]
    assert len([p for p in worse["problems"] if "error[E506]" in p]) == 7


def test_validate_finds_background_h5_in_a_folder(tmp_path, capsys):
    pytest.importorskip("h5py")
    plain_file(tmp_path / "background.h5", version=2)
    assert main(["validate", str(tmp_path)]) == 3
    assert "background.h5: error[E509]" in capsys.readouterr().err
    assert main(["validate", str(tmp_path / "none.HDF5")]) == 3
    assert "error[E500]" in capsys.readouterr().err


def test_a_missing_member_of_info_is_an_error_with_strict(tmp_path, capsys):
    pytest.importorskip("h5py")
    path = plain_file(tmp_path / "x.h5", info="none")
    assert main(["validate", str(path)]) == 0
    assert capsys.readouterr().err.count("warning[E504]") == 4
    assert main(["validate", "--strict", str(path)]) == 3


@needs_shared
def test_info_of_the_reference_file(capsys):
    pytest.importorskip("h5py")
    assert main(["info", str(SHARED / "lobes/background_sky_a.h5")]) == 0
    text = capsys.readouterr().out
    assert "5 animations with 29 keys" in text
    assert "airglow_wave: absolute from 2024-06-01T00:00:00Z, 5 keys" in text
    assert "4 curves at 61 wavelengths, 400 to 700 nm" in text
