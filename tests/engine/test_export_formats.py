"""The formats of `export`: one table for the command line, the code that writes them, and the page."""

import re
from importlib import import_module

from aomc_sky import read_scene, write_run
from aomc_sky.cli.commands.export import add_options
from aomc_sky.cli.usage import Parser
from aomc_sky.engine.export_formats import exports
from aomc_sky.outputs.photon_formats import PHOTON_FORMATS, run_formats
from tests.support.fault_rows import command
from tests.support.shared import INPUTS, REPOSITORY

DOUBLES = {"photons-0001.f64", "photons-0002.f64", "photons-0003.f64"}


def test_the_command_line_offers_what_the_table_has(double):
    parser = Parser(prog="export")
    add_options(parser)
    (offered,) = (action.choices for action in parser._actions if "--to" in action.option_strings)
    assert list(offered) == list(exports())
    assert {*PHOTON_FORMATS} <= {*run_formats()} | {*exports()}
    assert {*run_formats()} - {*exports()} == {"raw"}
    for name, export in exports().items():
        module, _, function = export.make.partition(":")
        assert callable(getattr(import_module(module), function)), name


def test_formats_of_the_page_are_those_of_export():
    page = (REPOSITORY / "docs" / "export.md").read_text().partition("\n\n`--out")[0]
    assert {*re.findall(r"(?m)^\| `(\w+)` \|", page)} == {*exports()}


def test_a_new_format_is_exported_as_a_run_writes_it(double, tmp_path):
    scene = read_scene(INPUTS / "document_example", iterations=100)
    write_run(scene, tmp_path / "out", formats="double")
    assert command("export", tmp_path / "out", "--to", "double", "-q") == 0
    assert {path.name for path in (tmp_path / "out-double").iterdir()} == {"plan.npz", *DOUBLES}
    for name in DOUBLES:
        assert (tmp_path / "out-double" / name).read_bytes() == (tmp_path / "out" / name).read_bytes()
    for ending in ("f64", "raw", "csv"):  # names of files, not of a folder
        assert command("export", tmp_path / "out", "--to", "double", "--out", tmp_path / f"new.{ending}") == 2
