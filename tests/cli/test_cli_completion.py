"""Completion scripts, run in the shells themselves."""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import shutil
import subprocess

import pytest

from aomc_sky.benchmark.samplers import METHODS
from aomc_sky.benchmark.skies import SKIES
from aomc_sky.cli.commands.completion import commands_of
from aomc_sky.cli.main import build_parser, main
from tests.support.pseudo_terminal import pseudo_terminal, start_in

SHELLS = ("bash", "zsh", "fish")


def needs(shell: str) -> pytest.MarkDecorator:
    return pytest.mark.skipif(shutil.which(shell) is None, reason=f"{shell} is not installed")


@pytest.fixture(scope="module")
def scripts(tmp_path_factory):
    """The script of every shell, in a file."""
    folder = tmp_path_factory.mktemp("completion")
    for shell in SHELLS:
        with contextlib.redirect_stdout(io.StringIO()) as written:
            assert main(["completion", shell]) == 0
        (folder / shell).write_text(written.getvalue())
    return folder


def subparsers() -> dict[str, argparse.ArgumentParser]:
    parser = build_parser(is_complete=True)
    return next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction)).choices


@pytest.mark.parametrize("shell", SHELLS)
def test_every_command_and_option_is_there(scripts, shell):
    text = (scripts / shell).read_text()
    commands = subparsers()
    assert {"run", "export", "completion"} <= set(commands)
    for name, parser in commands.items():
        assert name in text
        for flag, action in parser._option_string_actions.items():
            if action.help is argparse.SUPPRESS:
                continue
            form = flag if shell != "fish" else f"-l {flag[2:]} " if flag.startswith("--") else f"-s {flag[1:]} "
            assert form in text, (name, flag)


def test_arguments_of_the_parser_as_data():
    commands = {command.name: command for command in commands_of(build_parser(is_complete=True))}
    run = {flag: option for option in commands["run"].options for flag in option.flags}
    assert run["--quiet"] is run["-q"]
    assert not run["--force"].takes_value
    assert run["--bins"].choices == ("equal", "degrees")
    assert run["--waveband"].is_repeatable
    assert run["--out"].is_path
    assert not run["--seed"].is_path
    assert run["--coefficients"].n_values == 5
    assert commands["completion"].positionals[0].choices == SHELLS
    assert commands["export"].positionals[0].is_path
    assert commands["validate"].positionals[0].takes_many
    assert commands[""].help == ""
    assert all(command.help for name, command in commands.items() if name)


def test_every_value_is_a_choice_a_path_or_of_an_own_kind():
    commands = [command for command in commands_of(build_parser(is_complete=True)) if command.name]
    assert all(p.choices or p.is_path for command in commands for p in command.positionals)
    bench = {option.flags[-1]: option.choices for command in commands for option in command.options}
    assert bench["--skies"] == SKIES
    assert bench["--methods"] == tuple(METHODS)


def bash_replies(script, *words: str) -> list[str]:
    """What bash proposes for the last word."""
    program = (
        f'source "{script}"; complete -p aomc-sky >/dev/null || exit 9; '
        'COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _aomc_sky; printf "%s\\n" "${COMPREPLY[@]}"'
    )
    command = ["bash", "--norc", "-u", "-c", program, "bash", *words]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert done.stderr == ""
    return done.stdout.split()


@needs("bash")
@pytest.mark.parametrize(
    ("words", "replies"),
    [
        (["ru"], ["run"]),
        (["--v"], ["--version"]),
        (["run", "--bi"], ["--bins"]),
        (["run", "--bins", ""], ["equal", "degrees"]),
        (["run", "amc.inp", "--bins", "d"], ["degrees"]),
        (["run", "--bins", "="], ["equal", "degrees"]),
        (["run", "--bins", "=", "e"], ["equal"]),
        (["run", "--azimuth-bins", "n+"], ["n+1"]),
        (["run", "--seed", ""], []),
        (["run", "--out", "am"], []),
        (["run", ""], []),
        (["export", "out", "--to", ""], ["mcpl", "npy", "csv", "netcdf", "aomc"]),
        (["export", "--to", "npy", "--th"], ["--threads"]),
        (["completion", ""], list(SHELLS)),
        (["completion", "z"], ["zsh"]),
        (["nonsense", "-"], []),
        (["validate", "--bins", "equal", "--len"], ["--lenient"]),
    ],
)
def test_bash_proposes(scripts, words, replies):
    assert bash_replies(scripts / "bash", "aomc-sky", *words) == replies


@needs("bash")
def test_bash_goes_on_with_options_of_several_values(scripts):
    many = [
        (command.name, option)
        for command in commands_of(build_parser(is_complete=True))
        for option in command.options
        if option.takes_many and option.choices
    ]
    for name, option in many:
        words = ["aomc-sky", name, option.flags[-1], option.choices[0], option.choices[1], ""]
        assert bash_replies(scripts / "bash", *words) == list(option.choices)


@needs("bash")
def test_bash_falls_back_to_file_names(scripts):
    program = f'source "{scripts / "bash"}"; complete -p aomc-sky'
    done = subprocess.run(["bash", "--norc", "-c", program], capture_output=True, text=True, timeout=60, check=True)
    assert "-o default" in done.stdout


@needs("fish")
def test_fish_proposes(scripts):
    def replies(line: str) -> list[str]:
        command = ["fish", "--no-config", "-c", f'source "{scripts / "fish"}"; complete -C "{line}"']
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
        return [reply.split("\t")[0] for reply in done.stdout.splitlines()]

    assert replies("aomc-sky ru") == ["run"]
    assert sorted(replies("aomc-sky run --bins ")) == ["degrees", "equal"]
    assert replies("aomc-sky export out --thr") == ["--threads"]
    assert sorted(replies("aomc-sky completion ")) == sorted(SHELLS)


@needs("zsh")
def test_zsh_takes_the_script(scripts):
    program = f'autoload -U compinit; compinit -D -u; source "{scripts / "zsh"}"; print $_comps[aomc-sky]'
    done = subprocess.run(["zsh", "-f", "-c", program], capture_output=True, text=True, timeout=60, check=True)
    assert (done.stdout, done.stderr) == ("_aomc_sky\n", "")


STARTS = {
    "bash": (["bash", "--norc", "--noprofile", "-i"], "bind 'set bell-style none'; source {script}"),
    "zsh": (["zsh", "-f", "-i"], "autoload -U compinit; compinit -D -u; source {script}"),
    "fish": (["fish", "--no-config", "-i"], "source {script}"),
}
KEYS = {
    "aomc-sky run gree": "green.inp",
    "aomc-sky run --weighti": "--weighting",
    "aomc-sky run --placement=ph": "--placement=philox",
    "aomc-sky run --format npy --format mc": "--format mcpl",
    "aomc-sky lobes one.h5 twili": "twilight.h5",
    "aomc-sky lobes --plot pict": "picture.svg",
    "aomc-sky atmosphere haz": "hazy.atmo",
    "aomc-sky export --to netc": "netcdf",
    "aomc-sky validate --allow-path fold": "folder",
}
"""What is typed before the tabulator, and what stands there after it."""


@pytest.mark.parametrize("shell", [pytest.param(shell, marks=needs(shell)) for shell in SHELLS])
def test_keys_in_a_shell(shell, scripts, tmp_path):
    for name in ("green.inp", "twilight.h5", "picture.svg", "hazy.atmo"):
        (tmp_path / name).touch()
    (tmp_path / "folder").mkdir()
    command, setup = STARTS[shell]
    environment = {"PATH": os.environ["PATH"], "HOME": str(tmp_path), "TERM": "xterm", "PS1": "> "}
    with pseudo_terminal(200) as (slave, seen), start_in(slave, command, cwd=tmp_path, env=environment) as program:
        seen.type(setup.format(script=scripts / shell) + "; echo rea''dy\n")
        found = {"ready": seen.wait_for("ready\r\n")}
        for line, wanted in KEYS.items():
            seen.type(f"{line}\t")
            found[line] = seen.wait_for(wanted, 5)
            seen.type("\x15")
        seen.type("exit\n")
        program.wait(timeout=30)
    assert [line for line, is_there in found.items() if not is_there] == [], seen.text


def test_an_unknown_shell_is_a_usage_error(capsys):
    with pytest.raises(SystemExit) as stop:
        main(["completion", "tcsh"])
    assert stop.value.code == 2
    assert "bash" in capsys.readouterr().err
