"""Examples of public names, as `help` and the site show them, are run and print what they say."""

import doctest
import inspect
import pydoc
import re

import numpy as np
import pytest

import aomc_sky
from tests.support.public_names import public_names
from tests.support.shared import INPUTS

WITHOUT = {"PluginError"}  # it takes another package
EXTRA = {"h5py": r"write_background|read_background", "mcpl": "read_mcpl", "pvlib": "sun_position|spectrl2"}
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
