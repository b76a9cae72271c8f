"""The reference data beside the repository, where they are; tests that want them skip without."""

import csv
from importlib import util
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
SHARED = REPOSITORY.parent / "shared" / "reference"
AOMC = SHARED / "aomc"
INPUTS = REPOSITORY / "inputs"
DATA = REPOSITORY / "tests" / "data"


def script(path):
    """A program beside the package, as a module."""
    spec = util.spec_from_file_location(path.stem, path)
    module = util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def csv_rows(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


needs_shared = pytest.mark.skipif(not AOMC.is_dir(), reason="the reference data are not beside the repository")
