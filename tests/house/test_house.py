"""Habits that no linter knows: no network in tests, one place for numba, small modules and functions."""

import ast
import functools
import re
import socket
import sys
from typing import NamedTuple

import pytest

from tests.conftest import FIRST
from tests.support.other_system import FLAGS, FUNCTIONS, SIGNALS
from tests.support.other_system import MODULES as ABSENT
from tests.support.shared import REPOSITORY

SOURCE = REPOSITORY / "src" / "aomc_sky"
MODULES = sorted(SOURCE.rglob("*.py"))
MAX_LINES = 550  # a file is as long as its noun; a kernel file may be longer
MAX_FUNCTION_LINES = 55  # "about 40", docstring aside


def is_kernel(path):
    return "kernels" in path.relative_to(SOURCE).parts


def name_of(path):
    return str(path.relative_to(SOURCE))


def test_network_is_out_of_reach_and_the_files_that_come_first_are_there():
    with socket.socket() as one, pytest.raises(RuntimeError, match="reached for the network"):
        one.connect(("192.0.2.1", 9))
    assert set(FIRST) <= {path.name for path in (REPOSITORY / "tests").rglob("test_*.py")}


class Module(NamedTuple):
    """What the habits ask of a file."""

    docstring: str | None
    imported: set[str]
    modules: set[str]
    """What it imports by `import`, whole."""
    named: set[str]
    """What it takes from numba, and attributes of anything."""
    members: set[str]
    """Attributes of names: `os.open`."""
    functions: dict[str, int]
    """Lines of each, docstring aside."""


@functools.cache
def module(path):
    tree = ast.parse(path.read_text())
    found = Module(ast.get_docstring(tree), set(), set(), set(), set(), {})
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found.modules.update(alias.name for alias in node.names)
            found.imported.update(alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found.imported.add((node.module or "").partition(".")[0])
            found.named.update(alias.name for alias in node.names if node.module == "numba")
        elif isinstance(node, ast.Attribute):
            found.named.add(node.attr)
            if isinstance(node.value, ast.Name):
                found.members.add(f"{node.value.id}.{node.attr}")
        elif isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            first = node.body[0]
            has_docstring = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)
            start = (first.end_lineno if has_docstring else node.lineno) or node.lineno
            found.functions[f"{node.name}, line {node.lineno}"] = (node.end_lineno or start) - start
    return found


def test_modules_are_small_and_documented():
    assert [name_of(path) for path in MODULES if not module(path).docstring] == []
    for path in MODULES:
        if not is_kernel(path):
            assert path.read_text().count("\n") <= MAX_LINES, name_of(path)
            long = [name for name, n_lines in module(path).functions.items() if n_lines > MAX_FUNCTION_LINES]
            assert long == [], name_of(path)


def test_numba_is_imported_and_compiled_in_the_kernels_alone_and_no_other_package_is_needed():
    users = [path for path in MODULES if "numba" in module(path).imported]
    assert users
    assert [name_of(path) for path in users if not is_kernel(path)] == []
    compilers = {"jit", "njit", "vectorize", "guvectorize", "stencil", "cfunc"}
    assert {path.name for path in MODULES if is_kernel(path) and compilers & module(path).named} == {"jit.py"}
    third_party = set().union(*(module(path).imported for path in MODULES)) - set(sys.stdlib_module_names)
    assert third_party <= {"aomc_sky", "numpy", "numba", "llvmlite", "scipy", "tqdm"}


def test_no_other_module_calls_what_is_not_everywhere():
    """mypy checks the same for Windows by typeshed's lists; this test has a list of its own."""
    absent = {*(f"os.{name}" for name in (*FUNCTIONS, *FLAGS)), *(f"signal.{name}" for name in SIGNALS), *ABSENT}
    absent |= {"sys.platform", "os.name", "os.open"}
    users = {(path.name, name) for path in MODULES for name in (module(path).members | module(path).modules) & absent}
    users -= {("cache.py", "sys.platform"), ("main.py", "os.open")}  # a default value; the null device
    assert {name for name, _ in users} == {"system.py"}


SHARED_TESTS = {"conformance", "statistical", "golden", "faults", "support", "reference", "data"}
"""Folders of tests for no room alone; `ground` has those of the files beside the rooms, `house` those of the whole."""


def test_tests_lie_in_the_rooms_of_the_package():
    """One folder for each room, or for a folder of the repository beside `src`: tests of a slice go with the slice."""
    tests = REPOSITORY / "tests"
    folders = {str(path.parent.relative_to(tests)) for path in tests.rglob("test_*.py")} - {"ground", "house"}
    rooms = {name for name in folders if any((at / name).is_dir() for at in (SOURCE, REPOSITORY))}
    assert [name for name in folders - rooms if name.split("/")[0] not in SHARED_TESTS] == []


def test_maps_of_rooms_name_what_is_there():
    """The map in the docstring of a room has a line for each file and folder."""
    for room in [path for path in SOURCE.rglob("__init__.py") if path.parent != SOURCE]:
        text = ast.get_docstring(ast.parse(room.read_text())).partition("\n")[2]
        shown = re.findall(r"^([a-z0-9_]+)/? +\S", text, re.MULTILINE)
        parts = [path for path in room.parent.iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()]
        assert sorted(shown) == sorted({path.stem for path in parts} - {"__init__"}), room
