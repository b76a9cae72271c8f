"""`aomc-sky bench` as a person runs it, on few photons: tables, files, bars, and what is refused."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from aomc_sky.benchmark import bars, figure, mitsuba_peer, run, speed
from bench.check import LIMITS, Bar, Check
from aomc_sky.benchmark.methods import METHODS
from aomc_sky.benchmark.run import CSV_COLUMNS
from aomc_sky.cli.main import main
from aomc_sky.errors import MissingExtraError

TINY = ["bench", "--skies", "uniform", "sparse", "--photons", "1e3", "2000", "--replicates", "2", "--turns", "1"]


@pytest.fixture(autouse=True)
def plain_numpy_may_serve(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few photons do not wait for the compiler: plain numpy gives the same bits."""
    monkeypatch.setattr(run, "expect_photons", lambda n_photons: None)


@pytest.fixture
def no_mitsuba(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(name: str, *, extra: str) -> None:
        raise MissingExtraError(f'this needs the package {name}: pip install "aomc-sky[{extra}]"')

    monkeypatch.setattr(mitsuba_peer, "optional_module", absent)


def test_tables_and_csv(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "bench.csv"
    assert main([*TINY, "--no-peers", "--csv", str(path)]) == 0
    printed = capsys.readouterr().out
    for word in (*METHODS, "uniform: relative errors", "sparse: relative errors", "slope planar", "ring 0.01 %"):
        assert word in printed
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == CSV_COLUMNS
    assert len(rows) == 2 * 2 * len(METHODS)
    assert {row["method"] for row in rows} == set(METHODS)
    for row in rows:
        assert int(row["replicates"]) == (2 if METHODS[row["method"]].is_random else 1)
        assert float(row["emit_s"]) > 0
        assert all(float(row[column]) >= 0 for column in CSV_COLUMNS if column.startswith("error_"))


def test_json_is_one_object(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*TINY, "--no-peers", "--methods", "default", "iid", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {row["method"] for row in found["rows"]} == {"default", "iid"}
    assert found["speed"] == []
    assert found["truth_error"]["uniform"]["planar"] < 1e-12
    assert {trend["quantity"] for trend in found["trends"]} == {"planar", "cone", "histogram", "ring"}


def test_errors_come_back_with_the_seed(capsys: pytest.CaptureFixture[str]) -> None:
    errors = []
    for seed in ("7", "7", "8"):
        assert main([*TINY, "--no-peers", "--methods", "iid", "--seed", seed, "--json"]) == 0
        errors.append([row["error"] for row in json.loads(capsys.readouterr().out)["rows"]])
    assert errors[0] == errors[1] != errors[2]


@pytest.mark.slow
@pytest.mark.usefixtures("no_mitsuba")
def test_peers_that_are_absent_are_left_out_with_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*TINY, "--skies", "uniform", "--methods", "default"]) == 0
    printed = capsys.readouterr().out
    assert 'Mitsuba 3 is left out: this needs the package mitsuba: pip install "aomc-sky[bench]"' in printed
    for name in (speed.CHOICE, speed.MULTINOMIAL, "scipy DiscreteAliasUrn", *speed.STORES, speed.TWO_THREADS):
        assert name in printed


def few_bars(monkeypatch: pytest.MonkeyPatch, value: float) -> None:
    """A check that measures nothing: one bar of a given value, one line that was left out."""
    check = Check(bars=(Bar(name=next(iter(LIMITS)), value=value),), left_out=("one is left out",), shown=("one",))
    monkeypatch.setattr(bars, "run_check", lambda sizes, seed: check)


@pytest.mark.parametrize(("value", "code", "word"), [(40.0, 0, "kept"), (39.9, 1, "MISSED")])
def test_exit_code_of_a_check(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], value: float, code: int, word: str
) -> None:
    few_bars(monkeypatch, value)
    assert main(["bench", "--check"]) == code
    printed = capsys.readouterr()
    assert word in printed.out
    assert "one is left out" in printed.out
    assert ("1 of 1 bars are missed: patch order against numpy" in printed.err) == (code == 1)
    assert main(["bench", "--check", "--json"]) == code
    assert json.loads(capsys.readouterr().out)["kept"] is (code == 0)


def test_bars_from_above_and_from_below() -> None:
    growth = "growth of a streamed run's memory [MB]"
    assert Bar(name=growth, value=50.0).is_kept
    assert not Bar(name=growth, value=50.1).is_kept
    assert Bar(name="two threads against one", value=1.9).is_kept
    assert not Bar(name="two threads against one", value=1.89).is_kept
    assert not Bar(name="two threads against one", value=float("nan")).is_kept


@pytest.mark.slow
@pytest.mark.usefixtures("no_mitsuba")
def test_a_whole_check_with_a_bar_out_of_reach(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every bar is measured, on so few photons that only the injected one is asserted."""
    monkeypatch.setitem(LIMITS, "cone, independent photons against default", 1e9)
    monkeypatch.setattr(bars, "mcpl_times", lambda n_photons, repeats: None)
    assert main(["bench", "--check", "--photons", "4096", "--replicates", "2", "--turns", "1", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    by_name = {bar["name"]: bar for bar in found["bars"]}
    absent = {"default against Mitsuba 3", "MCPL writer against a ctypes loop over libmcpl"}
    assert absent.isdisjoint(by_name)
    assert set(by_name) >= set(LIMITS) - absent - {"two threads against one"}
    assert not by_name["cone, independent photons against default"]["kept"]
    assert sum("left out" in line for line in found["left_out"]) >= 2


def test_page_and_picture(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    few_bars(monkeypatch, 39.0)
    page = tmp_path / "performance.md"
    assert main([*TINY, "--no-peers", "-q", "--report", str(page)]) == 1
    text = page.read_text()
    for word in ("# Speed against error", "performance.png", "MISSED", "Missed, patch order", "## Sky: uniform"):
        assert word in text
    assert (tmp_path / "performance.png").stat().st_size > 10_000
    assert (tmp_path / "performance.csv").read_text().startswith("sky,method,n_photons")


def test_every_method_has_a_style_of_its_own() -> None:
    assert set(METHODS) <= set(figure.STYLES)
    assert len(set(figure.STYLES.values())) == len(figure.STYLES)
    assert len({marker + line for _, line, marker in figure.STYLES.values()}) == len(figure.STYLES)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["--skies", "moon"], "there is no sky 'moon'"),
        (["--methods", "magic"], "there is no method 'magic'"),
        (["--replicates", "0"], "replicates and turns must be at least 1"),
        (["--check", "--csv", "x.csv"], "--check measures the bars alone"),
        (["--check", "--skies", "clear"], "--check measures fixed skies"),
        (["--check", "--photons", "10", "20"], "--check takes one number of photons"),
        (["--csv", "no/such/folder/x.csv"], "the folder of no/such/folder/x.csv does not exist"),
        (["--report", "x.md", "--json"], "--report writes a page"),
    ],
)
def test_refused(capsys: pytest.CaptureFixture[str], arguments: list[str], text: str) -> None:
    assert main(["bench", *arguments]) == 2
    assert text in capsys.readouterr().err


def test_missing_extra_is_told_before_anything_is_measured(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    for words in (["--plot", "x.png"], ["--report", "x.md"]):
        assert main(["bench", *words]) == 2
        assert 'pip install "aomc-sky[plot]"' in capsys.readouterr().err
