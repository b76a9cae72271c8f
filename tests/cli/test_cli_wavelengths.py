"""Lists of wavelengths: every command takes them with blanks and with commas."""

import shlex

import pytest

from aomc_sky.cli.options import _WavelengthList
from aomc_sky.cli.usage import COMMANDS, WrongWordsError, build_parser

NEEDED = {"run": [], "verify": ["out"], "atmosphere": ["a.atmo"], "info": ["a.h5"], "plot": ["a.h5"], "perez": []}


def lists():
    parsers = next(action for action in build_parser()._actions if action.dest == "command").choices
    return [
        (command, flag)
        for command in COMMANDS
        for action in parsers[command]._actions
        if isinstance(action, _WavelengthList)
        for flag in action.option_strings
    ]


def parsed(command, words):
    arguments = build_parser([command]).parse_args([command, *shlex.split(words)])
    return getattr(arguments, "wavelengths", None) or getattr(arguments, "wavelength", None)


@pytest.mark.parametrize(("command", "flag"), lists())
@pytest.mark.parametrize("form", ["443.5 555", "'443.5 555'", "443.5, 555", "443.5 ,555", "443.5,555,", "4.435e2 555"])
def test_blanks_and_commas(command, flag, form):
    rest = shlex.join(NEEDED[command])
    assert parsed(command, f"{rest} {flag} {form}") == [443.5, 555.0]
    if len(shlex.split(form)) == 1:
        assert parsed(command, f"{rest} {flag}={form}") == [443.5, 555.0]
    assert parsed(command, f"{rest} {flag} 443.5 {flag} 555") == [443.5, 555.0]


@pytest.mark.parametrize(("command", "flag"), lists())
def test_start_end_step(command, flag):
    rest = shlex.join(NEEDED[command])
    assert parsed(command, f"{rest} {flag} 400:420:10") == [400.0, 410.0, 420.0]
    assert parsed(command, f"{rest} {flag} 400:401:0.4 443.5,600:600:5") == [400.0, 400.4, 400.8, 443.5, 600.0]
    assert parsed(command, f"{rest} {flag} 400:700:0.3")[-1] == 700.0  # 1000 steps of 0.3 add up


def test_a_file_stands_before_the_list(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("2026.csv", "sky.csv"):
        (tmp_path / name).touch()
        with pytest.raises(WrongWordsError, match=f"got '{name}'; .*; a file stands before --wavelengths"):
            build_parser(["run"]).parse_args(["run", "--wavelengths", "443", "555", name])
        arguments = build_parser(["run"]).parse_args(["run", name, "--wavelengths", "443", "555"])
        assert (arguments.wavelengths, arguments.amc_inp) == ([443.0, 555.0], name)
    (tmp_path / "555").mkdir()  # of a run with --out 555
    assert parsed("run", "--wavelengths 443 555 6.7e2") == [443.0, 555.0, 670.0]


@pytest.mark.parametrize(
    ("form", "text"),
    [
        ("412,5", "decimals follow a point"), ("0.443 0.555", "write 443"), ("443 -5", "positive wavelengths"),
        ("443 5O5", "got '5O5'"), (",", "positive wavelengths"), ("440 , , 550", "before a comma"),
        (",440", "before a comma"), ("440,550,,", "before a comma"), ("", "expected"), ("400:700", "write 400:700:10"),
        ("700:400:10", "END not below START"), ("400:700:0", "STEP above 0"), ("0.4:0.7:0.1", "write 700"),
        ("400:700:0.01", "30001 numbers"), ("400::10", "got ''"), ("nan:700:10", "got 'nan'"),
    ],
)  # fmt: skip
def test_what_is_no_list_of_wavelengths(form, text):
    with pytest.raises(WrongWordsError, match=text):
        parsed("run", f"--wavelengths {form}")
