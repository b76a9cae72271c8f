"""Examples of public names, as `help` and the site show them, and notebooks of the site run and print what they say."""

import doctest
import inspect
import json
import pydoc
import re

import numpy as np
import pytest

import aomc_sky
from tests.support.public_names import public_names
from tests.support.shared import INPUTS, REPOSITORY

WITHOUT = {"errors.PluginError"}  # it takes another package
EXTRA = {
    "h5py": r"write_background|read_background",
    "mcpl": "read_mcpl",
    "pvlib": r"sun_position|spectrl2|irradiances\(",
}
EXTRA |= {"xarray": "to_xarray", "matplotlib": r"sky\.plot"}
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


#: Classes of what functions return, with pages of their own.
RETURNED = ["emission.host.NumbaSampler", "formats.mcpl.file.McplFile"]
RETURNED += ["skies.lobes.file.data.Animation", "skies.lobes.file.data.BackgroundFile"]


def examples(name):
    value = pydoc.locate(f"aomc_sky.{name}")
    names = {"np": np, "sky": aomc_sky}  # as the pages of the site say
    return doctest.DocTestParser().get_doctest(inspect.getdoc(value) or "", names, name, None, None)


def needs(test):
    text = "".join(example.source for example in test.examples)
    return [library for library, words in EXTRA.items() if re.search(words, text)]


@pytest.mark.parametrize("name", [*sorted(set(public_names()) - WITHOUT), *RETURNED])
def test_example_prints_what_it_says(name, tmp_path, monkeypatch):
    test = examples(name)
    assert test.examples, "a public name shows how it is used"
    for library in needs(test):
        pytest.importorskip(library)
    (tmp_path / "inputs").symlink_to(INPUTS)
    monkeypatch.chdir(tmp_path)
    said = []
    assert doctest.DocTestRunner(optionflags=FLAGS).run(test, out=said.append).failed == 0, "".join(said)


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
