"""`python bench/check.py` and `python bench/report.py`: exit codes, bars from both sides, the page."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
from pathlib import Path

import pytest

from aomc_sky.benchmark import run
from aomc_sky.errors import MissingExtraError
from bench import check, peers, report
from bench.check import LIMITS, Bar, Check
from tests.support.shared import REPOSITORY

TINY = ["--skies", "uniform", "--photons", "1e3", "2000", "--replicates", "2", "--turns", "1"]


def few_bars(monkeypatch: pytest.MonkeyPatch, value: float) -> None:
    """A check that measures nothing: one bar of a given value, one line that was left out."""
    found = Check(bars=(Bar(name=next(iter(LIMITS)), value=value),), left_out=("one is left out",), shown=("one",))
    for module in (check, report):
        monkeypatch.setattr(module, "run_check", lambda sizes, seed: found)


@pytest.mark.parametrize(("value", "code", "word"), [(40.0, 0, "kept"), (39.9, 1, "MISSED")])
def test_exit_code_of_a_check(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], value: float, code: int, word: str
) -> None:
    few_bars(monkeypatch, value)
    assert check.main([]) == code
    printed = capsys.readouterr()
    assert word in printed.out
    assert "one is left out" in printed.out
    assert ("1 of 1 bars are missed: patch order against numpy" in printed.err) == (code == 1)
    assert check.main(["--json"]) == code
    assert json.loads(capsys.readouterr().out)["kept"] is (code == 0)


def test_bars_from_above_and_from_below() -> None:
    growth = "growth of a streamed run's memory [MB]"
    assert Bar(name=growth, value=50.0).is_kept
    assert not Bar(name=growth, value=50.1).is_kept
    assert Bar(name="two threads against one", value=1.9).is_kept
    assert not Bar(name="two threads against one", value=1.89).is_kept
    assert not Bar(name="two threads against one", value=float("nan")).is_kept


@pytest.mark.slow
def test_a_whole_check_with_a_bar_out_of_reach(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every bar is measured, on so few photons that only the injected one is asserted."""

    def absent(name: str, *, extra: str) -> None:
        raise MissingExtraError(f'this needs the package {name}: pip install "aomc-sky[{extra}]"')

    monkeypatch.setattr(peers, "optional_module", absent)
    monkeypatch.setitem(LIMITS, "cone, independent photons against default", 1e9)
    monkeypatch.setattr(check, "mcpl_times", lambda n_photons, repeats: None)
    assert check.main(["--photons", "4096", "--replicates", "2", "--turns", "1", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    by_name = {bar["name"]: bar for bar in found["bars"]}
    left_out = {"default against Mitsuba 3", "MCPL writer against a ctypes loop over libmcpl"}
    assert left_out.isdisjoint(by_name)
    assert set(by_name) >= set(LIMITS) - left_out - {"two threads against one"}
    assert not by_name["cone, independent photons against default"]["kept"]
    assert sum("left out" in line for line in found["left_out"]) >= 2


def test_page_and_picture(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    few_bars(monkeypatch, 39.0)

    def errors_alone(options: run.BenchOptions, speed_of: object) -> run.BenchResults:
        assert speed_of is peers.measure_peers
        return run.run_bench(dataclasses.replace(options, speed_photons=()))

    monkeypatch.setattr(run, "announce_photons", lambda n_photons: None)
    monkeypatch.setattr(report, "run_bench", errors_alone)
    page = tmp_path / "performance.md"
    assert report.main([str(page), *TINY]) == 1
    text = page.read_text()
    for word in ("# Speed against error", "performance.png", "MISSED", "Missed, patch order", "## Sky: uniform"):
        assert word in text
    assert all((tmp_path / f"performance{part}.png").stat().st_size > 10_000 for part in ("", "_skies"))
    assert (tmp_path / "performance.csv").read_text().startswith("sky,method,n_photons")


@pytest.mark.parametrize("words", [["--turns", "0"], ["--replicates", "0"]])
def test_refused(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert check.main(words) == 2
    assert "replicates and turns must be at least 1" in capsys.readouterr().err


def test_a_page_that_cannot_be_written_is_refused_before_anything_is_measured(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert report.main([str(tmp_path / "no/such/folder/x.md")]) == 2
    assert "does not exist" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert report.main([str(tmp_path / "x.md")]) == 2
    assert 'pip install "aomc-sky[plot]"' in capsys.readouterr().err


@pytest.mark.parametrize("script", ["check", "report", "mcpl"])
def test_scripts_start_from_any_folder(script: str, tmp_path: Path) -> None:
    command = [sys.executable, str(REPOSITORY / f"bench/{script}.py"), "--help"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
    assert "usage:" in done.stdout


def test_the_page_in_the_documentation_has_the_text_of_the_script() -> None:
    page = (REPOSITORY / "docs/performance.md").read_text()
    head = report._HEAD.partition("Machine:")[0].format(csv="`performance.csv`")
    assert " ".join(page.split()).startswith(" ".join(head.split()))


def test_table_in_markdown() -> None:
    assert report.markdown_table([("a", "1")], ("x", "n")) == "| x | n |\n| --- | ---: |\n| a | 1 |"
