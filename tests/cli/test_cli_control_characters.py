"""No control character of a file, a name or a manifest reaches a terminal, and the colours that we chose do."""

import io
import re
import sys

import pytest

from aomc_sky.cli.main import VisibleStream, main, visible_streams
from aomc_sky.errors import Problem, visible

HOSTILE = "\x1b]0;owned\x07\x1b[2J\x9b31m\u202eevil\u2066\x08\x7f"
UNSEEN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")


def assert_tame(shown):
    assert not UNSEEN.search(shown.out)
    assert not UNSEEN.search(shown.err)


def test_every_control_character_is_escaped_and_nothing_else():
    for code in range(0x3000):
        shown = visible(chr(code))
        assert (shown != chr(code)) == (UNSEEN.match(chr(code)) is not None or chr(code) in "\n\t"), hex(code)
        assert shown.isprintable() or shown == chr(code)
    assert visible("a\tb\n", keep_lines=True) == "a\tb\n"
    assert visible("naïve Ωλ 北") == "naïve Ωλ 北"


def test_problems_are_tame_without_the_command_line_too():
    problem = Problem(
        path=f"x{HOSTILE}", line=1, column=1, code="E1", field=HOSTILE, message=HOSTILE, advice=HOSTILE, text=HOSTILE
    )
    assert not UNSEEN.search(problem.render())
    assert "\\x1b[2J" in problem.render()
    assert problem.render().count("\n") == 2


def test_names_of_files(scene, tmp_path, capsys):
    for words in (["run", f"{tmp_path}/{HOSTILE}"], ["info", f"{tmp_path}/{HOSTILE}"], ["validate", HOSTILE]):
        assert main(words) == 3
        assert_tame(capsys.readouterr())
    with pytest.raises(SystemExit):
        main(["run", str(scene), f"--{HOSTILE}"])
    assert_tame(capsys.readouterr())


def test_streams_escape_what_a_file_says():
    stream = io.StringIO()
    before, sys.stdout = sys.stdout, stream
    try:
        with visible_streams():
            print("\x1b[31mfile\x1b[0m\tof\nlines")
    finally:
        sys.stdout = before
    assert stream.getvalue() == "\\x1b[31mfile\\x1b[0m\tof\nlines\n"
    assert not isinstance(sys.stdout, VisibleStream)
