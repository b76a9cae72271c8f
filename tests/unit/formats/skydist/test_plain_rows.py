"""The short way for plain rows of a broken skydist.inp gives what the long way gives."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from aomc_sky.errors import InputFileError
from aomc_sky.formats import skydist as skydist_rows
from aomc_sky.formats.skydist import read_skydist

ROWS = [
    "1 1 0 10.5",
    "  1\t1 1 12.   ",
    "1 2 1 2E1",
    "2 1 0 0.1234567890123456789",
    "2 1 1 1e400",
    "2 2 1 15.3 and words",
    "3 1 0 1",
    "1 0 0 1",
    "1 1 3 1",
    "1 1 0 11",
    "1 2 0 -1",
    "1 2 2 1d2",
    "2*1 2 4",
    "2 2 0,7",
]


def problems_of(path: Path) -> list[str]:
    with pytest.raises(InputFileError) as raised:
        read_skydist(path)
    return [str(dataclasses.replace(problem, path="")) for problem in raised.value.problems]


@pytest.mark.parametrize("last", ["2 2 2", "2 2 2 nan", "2 2 2 1"])
def test_same_problems_without_the_short_way(last: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "skydist.inp"
    path.write_text("\n".join([f"{len(ROWS) + 1} 2 2 2", "550.0 650.0", *ROWS, last]) + "\n")
    short = problems_of(path)
    monkeypatch.setattr(skydist_rows, "_take_plain", lambda *_arguments: False)
    assert problems_of(path) == short
    assert len(short) > 4


def test_same_values_and_lines_without_the_short_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "skydist.inp"
    rows = [row for row in ROWS[:6] if "400" not in row]
    path.write_text("\n".join([f"{len(rows)} 2 2 2", "550.0 650.0", "", *rows]) + "\n")
    monkeypatch.setattr("aomc_sky.formats.skydist.read_rows_fast", lambda *_arguments: None)
    short = read_skydist(path)
    monkeypatch.setattr(skydist_rows, "_take_plain", lambda *_arguments: False)
    long = read_skydist(path)
    assert short.radiance.tobytes() == long.radiance.tobytes()
    assert short.line.tobytes() == long.line.tobytes()


def test_a_big_file_with_one_bad_row_goes_the_short_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "skydist.inp"
    rows = [f"1 {z} {a} 1.5" for z in range(1, 91) for a in range(100)]
    rows[7] = "1 1 7 x"
    path.write_text("\n".join([f"{len(rows)} 90 99 1", "550.0", *rows]) + "\n")
    read: list[int] = []
    slowly = skydist_rows._read_row
    monkeypatch.setattr(skydist_rows, "_read_row", lambda *given: read.append(1) or slowly(*given))
    assert len(problems_of(path)) == 1
    assert len(read) == 1
