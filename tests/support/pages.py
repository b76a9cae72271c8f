"""Carry out a page of the documentation as a reader would: files saved, commands typed, output compared."""

import doctest
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from tests.support.shared import REPOSITORY

_FENCE = re.compile(r"^```([^`\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_NAME = re.compile(r"(?:#|!|//) ([\w./-]+\.(?:py|toml|c|cpp|cu|f90|inp))\n")
_COMPARE = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


@dataclass(frozen=True, slots=True)
class Command:
    """A line after ``$``, joined where a backslash ends it, and the output that the page shows below it."""

    line: str
    shown: str


@dataclass(frozen=True, slots=True)
class SavedFile:
    """A block whose first line is a comment with a file's name."""

    name: str
    text: str


def steps(text):
    """Files and commands of a page in order, without ``sh`` blocks, directives and nameless parts of C and Fortran."""
    for language, body in _FENCE.findall(text):
        if language == "console":
            yield from _commands(body)
        elif language not in {"", "sh", "text"} and not language.startswith("{"):
            name = _NAME.match(body)
            if name is None and language in {"c", "fortran"}:
                continue
            assert name is not None, f"no file name in the first line of\n{body}"
            yield SavedFile(name[1], body)


def programs(page):
    """Texts of the files that a page of the repository saves, by their names."""
    return {step.name: step.text for step in steps((REPOSITORY / page).read_text()) if isinstance(step, SavedFile)}


def _commands(body):
    assert body.startswith("$ "), body
    for part in re.split(r"^\$ ", body, flags=re.MULTILINE)[1:]:
        line, _, shown = part.replace("\\\n", "\0").partition("\n")
        yield Command(line.replace("\0", ""), shown)


def carry_out(page, folder):
    """Do what a page of docs/ says in a folder that has the scenes of inputs/; return how many commands ran."""
    shutil.copytree(REPOSITORY / "inputs", folder / "inputs", dirs_exist_ok=True)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "COLUMNS": "200", "NO_COLOR": "1"}
    checker, n = doctest.OutputChecker(), 0
    for step in steps((REPOSITORY / "docs" / page).read_text()):
        if isinstance(step, SavedFile):
            target = folder / step.name
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(step.text)
            continue
        done = subprocess.run(
            ["bash", "-c", step.line], cwd=folder, env=environment, capture_output=True, text=True, check=False
        )
        said = done.stderr + done.stdout
        assert done.returncode == 0, f"$ {step.line}\n{said}"
        if step.shown:
            assert checker.check_output(step.shown, said, _COMPARE), (
                f"$ {step.line}\nshown:\n{step.shown}\nsaid:\n{said}"
            )
        n += 1
    return n
