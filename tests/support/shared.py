"""Where the data of tests are, and how they are read."""

import csv
from importlib import util
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
INPUTS = REPOSITORY / "inputs"
DATA = REPOSITORY / "tests" / "data"
AOMC = DATA / "aomc"
REFERENCE = DATA / "reference"


def script(path):
    """A program beside the package, as a module."""
    spec = util.spec_from_file_location(path.stem, path)
    module = util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def csv_rows(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))
