"""`python bench/check.py` and `python bench/report.py`: exit codes, bars from both sides, the page."""

import csv
import subprocess
import sys

import pytest

from bench import check, report
from bench.accuracy import Row
from bench.check import LIMITS, Bar, Check
from bench.quantities import QUANTITIES
from bench.samplers import METHODS, SpeedRun
from bench.skies import PEER_SKY
from tests.support.shared import REPOSITORY

TINY = ["--skies", "uniform", "--photons", "1e3", "2000", "--replicates", "2", "--turns", "1"]


def few_bars(monkeypatch, value):
    """A check that measures nothing: one bar of a given value, one line that was left out."""
    found = Check(bars=(Bar(name=next(iter(LIMITS)), value=value),), left_out=("one is left out",), shown=("one",))
    for module in (check, report):
        monkeypatch.setattr(module, "run_check", lambda sizes: found)


@pytest.mark.parametrize(("value", "code", "word"), [(40.0, 0, "kept"), (39.9, 1, "MISSED")])
def test_exit_code_of_a_check(monkeypatch, capsys, value, code, word):
    few_bars(monkeypatch, value)
    assert check.main([]) == code
    printed = capsys.readouterr()
    assert word in printed.out
    assert "one is left out" in printed.out
    assert ("1 of 1 bars" in printed.err) == (code == 1)


def test_bars_from_above_and_from_below():
    for value, is_kept in ((50.0, True), (50.1, False)):
        assert Bar(name="growth of a streamed run's memory [MB]", value=value).is_kept == is_kept
    for value, is_kept in ((1.9, True), (1.89, False), (float("nan"), False)):
        assert Bar(name="two threads against one", value=value).is_kept == is_kept


def test_page_and_picture(monkeypatch, tmp_path):
    pytest.importorskip("matplotlib")
    few_bars(monkeypatch, 39.0)
    monkeypatch.setattr(report, "announce_photons", lambda n_photons: None)  # plain numpy gives the same bits
    monkeypatch.setattr(report, "measure_peers", lambda sky, n_photons, turns: None)
    page = tmp_path / "performance.md"
    assert report.main([str(page), *TINY]) == 1
    assert all(word in page.read_text() for word in ("performance.png", "MISSED", "## Sky: uniform"))
    assert (tmp_path / "performance.png").stat().st_size > 10_000
    with (tmp_path / "performance.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == report.CSV_COLUMNS
    assert [row["method"] for row in rows] == [*METHODS, *METHODS]
    for row in rows:
        assert int(row["replicates"]) == (2 if METHODS[row["method"]].is_random else 1)
        assert float(row["emit_s"]) > 0
        assert all(float(row[column]) >= 0 for column in report.CSV_COLUMNS if column.startswith("error_"))


def test_a_page_that_cannot_be_written_is_refused_before_anything_is_measured(monkeypatch, tmp_path, capsys):
    assert report.main([str(tmp_path / "no/such/folder/x.md")]) == 2
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert report.main([str(tmp_path / "x.md")]) == 2
    assert 'pip install ".[plot]"' in capsys.readouterr().err


OTHERS = [pytest.param(script, marks=pytest.mark.slow) for script in ("report", "emission", "growth", "same_bits")]


@pytest.mark.parametrize("script", ["check", "transport", *OTHERS])
def test_scripts_start_from_any_folder(script, tmp_path):
    command = [sys.executable, str(REPOSITORY / f"bench/{script}.py"), "--help"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
    assert "usage:" in done.stdout


def test_peers_have_the_error_of_independent_photons_and_stores_have_none():
    n = 1000
    names = ("stores of 12 bytes", "default", "default, two threads", "numpy choice")
    run = SpeedRun(n_photons=n, turns=1, times={name: [k * 1e-6] for k, name in enumerate(names, start=1)})
    rows = [
        Row(sky=PEER_SKY, method=method, n_photons=n, error=dict.fromkeys(QUANTITIES, error))
        for method, error in (("default", 0.5), ("iid", 2.0))
    ]
    table = report.speed_table(run, rows).splitlines()[2:]
    shown = {line.split(" | ")[0].removeprefix("| "): line.split(" | ")[2] for line in table}
    assert shown == dict(zip(names, ("-", "5.0e-01", "5.0e-01", "2.0e+00"), strict=True))


def test_the_table_in_the_documentation_has_the_columns_of_the_script():
    page = (REPOSITORY / "docs/accuracy.md").read_text()
    table = page.partition("<!-- speed table: begin")[2].partition("<!-- speed table: end -->")[0]
    rows = [line.strip("| ").split(" | ") for line in table.splitlines() if line.startswith("| ")]
    assert tuple(rows[0]) == report.SPEED_COLUMNS
    assert {*METHODS} <= {row[0] for row in rows}
    assert {len(row) for row in rows} == {len(report.SPEED_COLUMNS)}
