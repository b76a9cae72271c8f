"""`aomc-sky bench` as a person runs it, on few photons: tables, files, and what is refused."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from aomc_sky.benchmark import figure, run
from aomc_sky.benchmark.run import CSV_COLUMNS
from aomc_sky.benchmark.samplers import CHOICE, METHODS
from aomc_sky.cli.main import main

TINY = ["bench", "--skies", "uniform", "sparse", "--photons", "1e3", "2000", "--replicates", "2", "--turns", "1"]


@pytest.fixture(autouse=True)
def plain_numpy_may_serve(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few photons do not wait for the compiler: plain numpy gives the same bits."""
    monkeypatch.setattr(run, "announce_photons", lambda n_photons: None)


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


def test_numpy_stands_beside_every_method(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*TINY, "--skies", "uniform", "--methods", "default", "--json"]) == 0
    (speed,) = json.loads(capsys.readouterr().out)["speed"]
    assert set(speed["ns_per_photon"]) == {*METHODS, "default, float64", "patch-order, float64", CHOICE}
    assert speed["left_out"] == []


def test_moved_options_name_their_script(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--report", "x.md"]) == 2
    printed = capsys.readouterr()
    assert printed.err.rstrip().endswith("--report moved to a script of the repository: python bench/report.py FILE")
    assert printed.out == ""


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
        (["--csv", "no/such/folder/x.csv"], "the folder of no/such/folder/x.csv does not exist"),
    ],
)
def test_refused(capsys: pytest.CaptureFixture[str], arguments: list[str], text: str) -> None:
    assert main(["bench", *arguments]) == 2
    assert text in capsys.readouterr().err
