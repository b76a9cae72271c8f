"""Notebooks of the site run from the first cell to the last."""

import json

import pytest

from tests.support.shared import REPOSITORY

BOOKS = sorted((REPOSITORY / "docs" / "notebooks").glob("*.ipynb"))


def code_cells(path):
    return [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]


@pytest.mark.parametrize("path", BOOKS, ids=[path.stem for path in BOOKS])
def test_notebook_is_kept_without_outputs(path):
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code_cells(path))


def printed(name):
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    for library in ("ipykernel", "matplotlib", "pvlib"):
        pytest.importorskip(library)
    book = nbformat.read(REPOSITORY / "docs" / "notebooks" / f"{name}.ipynb", 4)
    nbclient.NotebookClient(book, timeout=300, kernel_name="python3").execute()
    outputs = [output for cell in book.cells if cell.cell_type == "code" for output in cell.outputs]
    assert any("image/png" in output.get("data", {}) for output in outputs)
    return "".join(output.text for output in outputs if output.output_type == "stream" and output.name == "stdout")


@pytest.mark.slow
def test_day():
    text = printed("day")
    assert "photons 0.82859, sky 0.82857" in text
    assert "the day 62.4 mol m-2" in text


@pytest.mark.slow
def test_host():
    arriving, error = printed("host").rsplit("]", 1)
    assert arriving.startswith("[1. ")
    assert float(error) < 2e-4  # independent photons: 1.5e-3
