"""Programs in C and Fortran that start Python themselves: how the tests compile and run them."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from aomc_sky.cli.commands.info import embed_flags, include_dir
from aomc_sky.errors import AomcSkyError
from tests.support.shared import REPOSITORY

EXAMPLES = REPOSITORY / "examples"
REFERENCE = REPOSITORY / "tests" / "reference"


def _reason() -> str | None:
    """Why such programs cannot be built here; None where they can."""
    missing = [name for name in ("gcc", "make") if shutil.which(name) is None]
    if missing:
        return f"{' and '.join(missing)} not installed"
    try:
        embed_flags()
    except AomcSkyError as error:
        return str(error)
    return None


NO_HOST = _reason()
needs_host = pytest.mark.skipif(NO_HOST is not None, reason=NO_HOST or "")


def make(folder: Path, *targets: str) -> None:
    """Run make in a copy of an example, with the Python that runs the tests; warnings are errors."""
    flags = "-O2 -Wall -Wextra -Werror"
    command = ["make", f"AOMC_SKY={sys.executable} -m aomc_sky", f"CFLAGS={flags}", f"FFLAGS={flags}", *targets]
    run(command, folder)


def compile_c(source: str, folder: Path) -> Path:
    """Compile tests/reference/<source>.c with the shim into `folder`, strictly; return the program."""
    program = folder / source
    files = [str(REFERENCE / f"{source}.c"), str(include_dir() / "aomc_sky_embed.c")]
    run(["gcc", "-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-o", str(program), *files, *embed_flags()], folder)
    return program


def run(command: list[str], folder: Path, **environment: str) -> str:
    """Run a command in a folder and return its output; a failure shows what it said."""
    done = subprocess.run(
        command, cwd=folder, env={**os.environ, **environment}, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, f"{' '.join(command)} ended with {done.returncode}:\n{done.stdout}\n{done.stderr}"
    return done.stdout
