"""Every row of the matrix has a guard, and every guard a test that fails when the guard is taken out."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.faults import guards
from tests.faults.guards import GUARDS
from tests.faults.test_all_rows import ROWS
from tests.support.guards import PACKAGE, PackageCopy, collected_tests

NEEDS_H5PY = (36, 40)


def test_every_row_has_a_guard():
    assert {guard.row for guard in GUARDS} == set(ROWS)


def test_no_guard_is_left_out_where_they_are_read():
    lines = Path(guards.__file__).with_suffix(".txt").read_text().splitlines()
    assert len(GUARDS) == sum(line.startswith("  ") for line in lines) > 200
    kept = sum(len(part.splitlines()) for guard in GUARDS for part in (guard.text, guard.without))
    assert kept == sum(line.startswith(("-", "+")) for line in lines)


def test_every_guard_stands_once_in_its_file():
    texts = {guard.file: (PACKAGE / guard.file).read_text() for guard in GUARDS}
    assert [guard for guard in GUARDS if texts[guard.file].count(guard.text) != 1] == []


def test_what_stands_in_its_place_is_python():
    """Another program, whole and readable: a test that fails on the way in would see nothing."""
    for guard in GUARDS:
        assert guard.without != guard.text
        compile((PACKAGE / guard.file).read_text().replace(guard.text, guard.without), guard.file, "exec")


def test_every_named_test_is_there():
    pytest.importorskip("h5py")  # without it row 40 is not collected
    assert {guard.test for guard in GUARDS} - collected_tests() == set()


@pytest.fixture(scope="session")
def package(tmp_path_factory) -> PackageCopy:
    return PackageCopy(tmp_path_factory.mktemp("package"))


@pytest.mark.slow
@pytest.mark.parametrize("guard", GUARDS, ids=[guard.name for guard in GUARDS])
def test_its_test_fails_without_it(guard, package):
    if guard.row in NEEDS_H5PY:
        pytest.importorskip("h5py")
    seen = package.test_without(guard)
    assert not seen.broken, seen.said
    assert seen.hung == guard.hangs, seen.said
    assert seen.failed or seen.hung, seen.said
