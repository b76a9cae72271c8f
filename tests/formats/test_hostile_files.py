"""Files made to hurt: refused within 200 MB and without numba or scipy, and soon."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.limits import answers_within_limits

READERS = """
from aomc_sky.formats.aomc.amc import read_amc, read_difcol, read_lambbot
from aomc_sky.formats.aomc.skydist import read_skydist
readers = (read_amc, read_lambbot, read_difcol, read_skydist)
"""


def sparse_gigabyte(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(2**30)


def one_long_line(path: Path) -> None:
    path.write_bytes(b"1 " * 50_000_000)


def many_bad_rows(path: Path) -> None:
    path.write_bytes(b"400000 89 359 1\n500\n" + b"1 x 0 1.0\n" * 400_000)


def largest_header(path: Path) -> None:
    path.write_bytes(b"2 8192 8191 2\n500 600\n1 1 0 x\n")


def many_wavelengths(path: Path) -> None:
    path.write_bytes(b"2 1 0 300000\n" + (b"2 " * 30_000 + b"\n") * 10)


def quarter_million_digits(path: Path) -> None:
    path.write_bytes(b"9" * 60_000 + b"\n" + b"1e" + b"9" * 60_000 + b"\n")


@pytest.mark.parametrize(
    "make",
    [sparse_gigabyte, one_long_line, many_bad_rows, largest_header, many_wavelengths, quarter_million_digits],
    ids=lambda make: make.__name__,
)
def test_hostile_files_cost_little(make: object, tmp_path: Path) -> None:
    path = tmp_path / "file.inp"
    make(path)  # type: ignore[operator]
    assert all(answer.startswith("E") for answer in answers_within_limits(READERS, path))
