"""The front door: help, version, ``validate``, ``info``, and input errors in our form."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys

import pytest

from aomc_sky.cli.main import main


@pytest.mark.parametrize("words", [[], ["fly"], ["validate"], ["run", "a", "b"]])
def test_usage_errors(words, capsys):
    with pytest.raises(SystemExit) as stop:
        main(words)
    assert stop.value.code == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 2
    assert said[0].startswith("aomc-sky: error: ")
    assert re.fullmatch(r"      = help: aomc-sky (\w+ )?--help", said[1])


def test_validate_says_ok(amc, capsys):
    assert main(["validate", str(amc.parent)]) == 0
    shown = capsys.readouterr()
    assert [line.rsplit(": ", 1)[1] for line in shown.out.splitlines()] == ["ok"] * 3
    assert shown.err == ""


def test_info_of_a_scene_and_of_a_run(amc, tmp_path, capsys):
    assert main(["info", str(amc.parent)]) == 0
    text = capsys.readouterr().out
    assert "skydist.inp" in text
    assert "lambbot.inp" in text
    assert main(["info", str(amc), "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["wavebands"]) == 3
    out = tmp_path / "out"
    assert main(["run", str(amc), "--iterations", "1e3", "--seed", "77", "--out", str(out), "-q"]) == 0
    assert main(["info", str(out)]) == 0
    text = capsys.readouterr().out
    assert "seed 77" in text
    assert "photons-0003.npy" in text
    assert main(["info", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads((out / "manifest.json").read_text())


def test_file_names_need_not_be_text(amc, tmp_path):
    folder = os.fsencode(tmp_path) + b"/sc\xffne"
    os.rename(amc.parent, folder)
    for command in (b"info", b"validate"):
        done = subprocess.run(
            [sys.executable, b"-m", b"aomc_sky", command, folder], capture_output=True, timeout=60, check=False
        )
        assert done.returncode == 0, done.stderr
        assert b"Traceback" not in done.stderr
