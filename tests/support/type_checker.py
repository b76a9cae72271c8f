"""Programs of a user before mypy, which finds the package as it is installed."""

import sys

import pytest

UNTYPED = (
    *("--allow-untyped-defs", "--allow-untyped-calls", "--allow-untyped-decorators"),
    *("--ignore-missing-imports", "--disable-error-code=import-untyped"),
)
"""Options for programs whose own functions have no types, with packages that have none."""


def complaints(folder, *options):
    """What ``mypy --strict`` says of the programs of a folder, a line for each error; its cache is beside it."""
    api = pytest.importorskip("mypy.api")
    fixed = ("--strict", "--config-file=", "--no-error-summary", "--hide-error-context", "--no-color-output")
    cache = f"--cache-dir={folder.parent / 'mypy'}"
    programs = sorted(map(str, folder.rglob("*.py")))
    said, problems, _ = api.run([*fixed, *options, cache, f"--python-executable={sys.executable}", *programs])
    assert problems == ""
    return [line for line in said.splitlines() if ": note: " not in line]
