"""Habits that no linter knows: no network in tests, one place for numba, small modules and functions."""

from __future__ import annotations

import ast
import socket
import sys
from pathlib import Path

import pytest

from tests.conftest import FIRST
from tests.support.shared import REPOSITORY

SOURCE = REPOSITORY / "src" / "aomc_sky"
MODULES = sorted(SOURCE.rglob("*.py"))
MAX_LINES = 550  # a file is as long as its noun; a kernel file may be longer
MAX_FUNCTION_LINES = 55  # "about 40", docstring aside


def is_kernel(path: Path) -> bool:
    return "kernels" in path.relative_to(SOURCE).parts


def name_of(path: Path) -> str:
    return str(path.relative_to(SOURCE))


def test_network_is_out_of_reach() -> None:
    with socket.socket() as one, pytest.raises(RuntimeError, match="reached for the network"):
        one.connect(("192.0.2.1", 9))


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_module_is_small_and_documented(path: Path) -> None:
    text = path.read_text()
    tree = ast.parse(text)
    assert ast.get_docstring(tree), "a module says what it is for"
    if is_kernel(path):
        return
    assert text.count("\n") <= MAX_LINES
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            first = node.body[0]
            has_docstring = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)
            start = (first.end_lineno if has_docstring else node.lineno) or node.lineno
            assert (node.end_lineno or start) - start <= MAX_FUNCTION_LINES, node.name


def imported_by(path: Path) -> set[str]:
    """Top-level names of every import of a file, also those inside functions."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names.update(alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            names.add((node.module or "").partition(".")[0])
    return names


def test_numba_is_imported_in_the_kernels_alone() -> None:
    users = [path for path in MODULES if "numba" in imported_by(path)]
    assert users
    assert [name_of(path) for path in users if not is_kernel(path)] == []


def test_kernels_are_compiled_by_one_decorator() -> None:
    compilers = {"jit", "njit", "vectorize", "guvectorize", "stencil", "cfunc"}
    users = set()
    for path in (SOURCE / "kernels").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and node.module == "numba":
                named = {alias.name for alias in node.names}
            else:
                named = {node.attr} if isinstance(node, ast.Attribute) else set()
            if compilers & named:
                users.add(path.name)
    assert users == {"jit.py"}


def test_package_depends_on_its_core_dependencies_alone() -> None:
    third_party = set().union(*map(imported_by, MODULES)) - set(sys.stdlib_module_names) - {"aomc_sky"}
    assert third_party <= {"numpy", "numba", "llvmlite", "scipy"}


def test_the_test_files_that_come_first_are_there() -> None:
    assert set(FIRST) <= {path.name for path in (REPOSITORY / "tests").rglob("test_*.py")}
