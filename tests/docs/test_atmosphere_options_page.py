"""The page of keys and options has every option of the command and every key of a description, and invents none."""

import argparse
import re

from aomc_sky.cli.usage import build_parser
from aomc_sky.skies.atmosphere.description.keys import DIRECTIVES, SCATTERER_DIRECTIVE, SECTION_KEYS, TOP_KEYS
from tests.support.shared import REPOSITORY

PAGE = (REPOSITORY / "docs/models/atmosphere_options.md").read_text()
ROWS = re.findall(r"^\| (`.*?) \| (.*?) \|", PAGE, re.MULTILINE)
VERDICTS = {name: verdict for names, verdict in ROWS for name in re.findall(r"`([^`]+)`", names)}
_TOOL = """
    --out-dir --radiance --no-eds-tex --texture-save-precision --no-save-tex --opengl-debug --opengl-debug-full
    --opengl-info --save-irradiance --save-scat-density2-from-ground --save-scat-density --save-delta-scattering
    --save-accum-scattering --save-light-pollution -h --help -v --version
"""
TOOL = set(_TOOL.split())


def options():
    (commands,) = (a for a in build_parser()._actions if isinstance(a, argparse._SubParsersAction))
    return {text for action in commands.choices["atmosphere"]._actions for text in action.option_strings}


def keys():
    """Every key and directive of a description, in lower case."""
    section_keys = {key for rules in SECTION_KEYS.values() for key in rules}
    return {*TOP_KEYS, *section_keys, *DIRECTIVES, SCATTERER_DIRECTIVE}


def test_every_option_and_key_has_a_row():
    documented = {name if name.startswith("-") else name.lower() for name in VERDICTS}
    assert options() - documented == set()
    assert keys() - documented == set()


def test_the_page_invents_nothing():
    for name in VERDICTS:
        assert name in options() if name.startswith("-") else name.lower() in keys(), name


def test_every_option_of_the_tool_has_a_verdict():
    assert options() >= TOOL
    for name, verdict in VERDICTS.items():
        if not name.startswith("-") or name in TOOL:
            assert verdict in {"implemented", "mapped", "met", "not used"}, name
