"""Completion scripts by shtab: every command and option stands in them, and bash completes the names of skies."""

import argparse
import shutil
import subprocess

import pytest

from aomc_sky.cli.usage import COMMANDS, build_parser
from aomc_sky.formats.sky_models import OUR_NAMES, SKY_MODELS
from aomc_sky.formats.sky_toml.keys import DIFFUSE_MODELS
from tests.support.fault_rows import command

pytest.importorskip("shtab")


def script_of(shell, capsys):
    assert command("--print-completion", shell) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("shell", ["bash", "zsh"])
def test_every_command_and_option_is_there(shell, capsys):
    text = script_of(shell, capsys)
    assert "harrison-coombes" in text
    commands = next(action for action in build_parser()._actions if action.dest == "command").choices
    assert list(commands) == list(COMMANDS)
    for name, parser in commands.items():
        assert name in text
        shown = {flag for flag, action in parser._option_string_actions.items() if action.help != argparse.SUPPRESS}
        assert [flag for flag in shown if flag not in text] == []


_BASH = """\
source {script}
COMP_WORDS=(aomc-sky run amc.inp --sky "$1")
COMP_CWORD=4
COMPREPLY=()
_shtab_aomc_sky
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
def test_bash_completes_the_names_of_skies(tmp_path, capsys):
    """The function of the script is called as bash calls it after a TAB."""
    (tmp_path / "script").write_text(script_of("bash", capsys))
    every = {*DIFFUSE_MODELS} | ({*SKY_MODELS} - {*OUR_NAMES})
    for typed, names in (("", every), ("c", {"cardioidal", "cie"}), ("harr", {"harrison-coombes"}), ("x", {""})):
        words = ["bash", "-c", _BASH.format(script=tmp_path / "script"), "bash", typed]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        found = set(done.stdout.splitlines())
        assert (done.stderr, found & names, typed and found) == ("", names, typed and names)
