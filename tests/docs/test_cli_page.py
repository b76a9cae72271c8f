"""docs/cli.md and the keys of an atmosphere against the parser: all is there, nothing else; help is of one form."""

import argparse
import re
import shlex
from collections import defaultdict

import pytest

from aomc_sky.cli.usage import IDLE, build_parser
from aomc_sky.skies.atmosphere.description.keys import DIRECTIVES, SCATTERER_DIRECTIVE, SECTION_KEYS, TOP_KEYS
from tests.support.extras import PACKAGES, extras_of_project
from tests.support.shared import REPOSITORY, script

tables = script(REPOSITORY / "docs/extensions/option_tables.py")
PAGE = (REPOSITORY / "docs" / "cli.md").read_text()
FLAG = re.compile(r"(?<![\w-])--?[a-z][a-z0-9-]*")
PARSERS = next(action for action in build_parser()._actions if isinstance(action, argparse._SubParsersAction)).choices


def options_of(parser, *, hidden=False):
    """Option strings of a command; those too that only say where they went."""
    shown = (action for action in parser._actions if hidden or action.help is not argparse.SUPPRESS)
    return {flag for action in shown for flag in action.option_strings} - {"-h", "--help"}


def test_every_command_and_no_other_option_is_on_the_page():
    table = PAGE.partition("| command | does |")[2].partition("\n\n")[0]
    names = "".join(line.split("|")[1] for line in table.splitlines()[2:])
    assert set(re.findall(r"`([a-z]+)[ `]", names)) == set(PARSERS)
    everything = set().union(*(options_of(parser, hidden=True) for parser in PARSERS.values()))
    assert set(FLAG.findall(PAGE)) <= everything | {"--help", "--version", "--print-completion"}


@pytest.mark.parametrize("command", PARSERS)
def test_every_option_is_in_a_table_of_the_page(command):
    shown = set()
    for name in re.findall(r"```\{options\} (\w+)", PAGE):
        text, (_, commands) = tables.options_table(name), tables.groups_of(name)
        assert text.count("| --- |") == len(tables.groups_of(name)[0])
        if command in commands:
            shown |= set(FLAG.findall("".join(line.split(" | ")[0] for line in text.splitlines())))
    assert options_of(PARSERS[command]) - shown <= {"--help-all", "-v", "--version"}


def test_extras_on_the_page_are_those_of_the_project():
    section = PAGE.partition("## Extras")[2].partition("\n## ")[0]
    rows = re.findall(r"(?m)^\| ((?:`[a-z0-9]+`(?:, )?)+) \| ([^|]+) \|", section)
    named = {extra: brought for extras, brought in rows for extra in re.findall(r"`(\w+)`", extras)}
    project = extras_of_project()
    assert set(named) == set(project) - {"all"}
    for extra in PACKAGES:
        assert named[extra].split(", ") == project[extra]


@pytest.mark.parametrize("command", PARSERS)
def test_help_is_of_one_form(command):
    parser = PARSERS[command]
    assert parser.description
    assert parser.description.rstrip().endswith(".")
    assert parser.epilog.startswith("examples:\n")
    for action in parser._actions:
        text = action.help % vars(action) if "%(" in action.help else action.help
        assert not text.endswith("."), action.option_strings
        assert text.isprintable()


@pytest.mark.parametrize("command", ["", *PARSERS])
def test_examples_of_the_help_can_be_parsed(command):
    epilog = (PARSERS[command] if command else build_parser()).epilog
    lines = epilog.partition("examples:\n")[2].partition("\n\n")[0].splitlines()
    assert lines
    for line in lines:
        words = re.search(r"aomc-sky ([^|>)]*)", re.split(r"\s{2,}", line.strip())[0])
        assert words is not None, line
        given = shlex.split(words[1])
        assert given[0] == command or not command
        build_parser().parse_args(given)


OWN = {
    *("--out", "--seed", "--wavelength", "--wavelengths", "--iterations", "--bins", "--sun-zenith", "--sun-azimuth"),
    *("--diffuse-only", "--method", "--weights", "--waveband", "--force", "--scene"),
    *("-q", "--quiet", "-v", "--verbose"),
}
"""Options of several commands that mean something of its own in one of them."""


def test_options_of_several_commands_mean_the_same():
    texts = defaultdict(set)
    for parser in PARSERS.values():
        for action in parser._actions:
            for flag in action.option_strings:
                texts[flag].add((action.help, str(action.metavar), str(action.choices)))
    assert {flag for flag, meanings in texts.items() if len(meanings) > 1} == OWN


OPTIONS_PAGE = (REPOSITORY / "docs/models/atmosphere_options.md").read_text()
ROWS = re.findall(r"^\| (`.*?) \| (.*?) \|", OPTIONS_PAGE, re.MULTILINE)
VERDICTS = {name: verdict for names, verdict in ROWS for name in re.findall(r"`([^`]+)`", names)}


def keys():
    """Every key and directive of a description, in lower case."""
    section_keys = {key for rules in SECTION_KEYS.values() for key in rules}
    return {*TOP_KEYS, *section_keys, *DIRECTIVES, SCATTERER_DIRECTIVE}


def test_every_option_and_key_has_a_row_and_a_verdict_and_none_is_invented():
    """Options of the tool that would change nothing here are refused, and on no page."""
    options = options_of(PARSERS["atmosphere"], hidden=True) | {"-h", "--help"}
    documented = {name if name.startswith("-") else name.lower(): verdict for name, verdict in VERDICTS.items()}
    assert options | keys() == set(documented)
    assert not any(option in OPTIONS_PAGE for option in IDLE)
    assert {documented[name] for name in keys()} <= {"implemented", "mapped", "met", "not used"}
