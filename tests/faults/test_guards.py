"""Every row of the matrix has a guard, and every guard a test that fails when the guard is taken out."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from queue import SimpleQueue

import pytest

from aomc_sky.outputs.blocks.chunk_pool import n_cpus
from tests.faults.guards import GUARDS
from tests.faults.test_all_rows import ROWS
from tests.support.guards import PACKAGE, Guard, PackageCopy, Seen, collected_tests

NEEDS_H5PY = (36, 40)


def test_every_row_has_a_guard():
    assert {guard.row for guard in GUARDS} == set(ROWS)
    assert [guard for guard in GUARDS if not guard.name.startswith(f"{guard.row:02d}-")] == []


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


@pytest.fixture(scope="module")
def under_way(request, tmp_path_factory) -> Iterator[dict[Guard, Future[Seen]]]:
    """What becomes of the tests of all guards that are asked for, one at a time on each processor."""
    asked = [item.callspec.params["guard"] for item in request.session.items if item.originalname == SLOW_TEST]
    n = n_cpus()
    copies: SimpleQueue[PackageCopy] = SimpleQueue()
    for k in range(n):
        copies.put(PackageCopy(tmp_path_factory.mktemp(f"package-{k}")))

    def run(guard: Guard) -> Seen:
        package = copies.get()
        try:
            return package.test_without(guard)
        finally:
            copies.put(package)

    with ThreadPoolExecutor(n) as executor:
        yield {guard: executor.submit(run, guard) for guard in asked}
        executor.shutdown(cancel_futures=True)


@pytest.mark.slow
@pytest.mark.parametrize("guard", GUARDS, ids=[guard.name for guard in GUARDS])
def test_its_test_fails_without_it(guard, under_way):
    if guard.row in NEEDS_H5PY:
        pytest.importorskip("h5py")
    seen = under_way[guard].result()
    assert not seen.broken, seen.said
    assert seen.hung == guard.hangs, seen.said
    assert seen.failed or seen.hung, seen.said


SLOW_TEST = test_its_test_fails_without_it.__name__
