"""Every row of docs/faults.md has a test of its own in the default suite, and no test is of a row that is not there."""

from __future__ import annotations

import re

import pytest

from tests.support.guards import collected_tests
from tests.support.shared import REPOSITORY

ROWS = tuple(range(1, 52))


def test_every_row_has_a_test() -> None:
    pytest.importorskip("h5py")  # without it row 40 is not collected
    page = (REPOSITORY / "docs" / "faults.md").read_text()
    rows = [int(number) for number in re.findall(r"^\| (\d+) \|", page, re.MULTILINE)]
    assert tuple(rows) == ROWS
    found = {int(number) for number in re.findall(r"\[row-(\d\d)-", "\n".join(collected_tests()))}
    assert found == set(rows)
