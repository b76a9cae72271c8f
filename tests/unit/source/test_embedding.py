"""Options as a C or Fortran program writes them, and what it hears of warnings."""

import os

import pytest

from aomc_sky.errors import AomcSkyError, InputFileError, UsageError
from aomc_sky.source.embedding import open_run, open_scene, parse_options
from tests.support.shared import INPUTS


def test_options_are_read():
    assert parse_options("") == parse_options("  \n") == {}
    wanted = {"iterations": 1000, "order": "patch", "precision": "float64"}
    assert parse_options(" iterations=1000\torder=patch  precision=float64 ") == wanted


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("order", "write name=value"),
        ("order=", "write name=value"),
        ("=patch", "unknown option ''"),
        ("oder=patch", "did you mean 'order'"),
        ("seed=3", "the options are iterations, sky, bins"),
        ("order=patch order=patch", "given twice"),
        ("iterations=1e6", "whole number"),
        ("iterations=-5", "whole number"),
        ("iterations=٣", "whole number"),
    ],
)
def test_wrong_options_are_named(text, said):
    with pytest.raises(UsageError, match=said):
        parse_options(text)


def test_what_the_scene_refuses_is_an_error_of_the_package():
    with pytest.raises(InputFileError, match="no such file"):
        open_scene(b"/no/such/scene", 1, "")
    with pytest.raises(UsageError, match="precision"):
        open_scene(os.fsencode(INPUTS / "clear_day"), 1, "precision=half")


def test_warnings_go_to_standard_error(capsys):
    opened = open_scene(os.fsencode(INPUTS / "sun_and_sky"), 1, "iterations=100")
    assert "aomc-sky: warning: difcol.inp" in capsys.readouterr().err
    assert opened.n_bands == 5


def test_a_source_is_made_once_and_closed():
    opened = open_scene(os.fsencode(INPUTS / "clear_day"), 1, "iterations=100")
    first = opened.source(0)
    assert first == opened.source(0)
    assert first[3:] == (False, 100, 440.0)
    opened.close()
    with pytest.raises(IndexError):
        opened.source(3)


def test_a_run_without_a_plan_is_named(tmp_path):
    with pytest.raises(AomcSkyError, match="not a readable plan"):
        open_run(os.fsencode(tmp_path))
