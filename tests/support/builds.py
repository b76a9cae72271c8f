"""What tests compile, once a run: all its workers take it from one folder."""

import fcntl
import hashlib
import os
import subprocess
import tempfile
from pathlib import Path

from aomc_sky.cli.commands.info import include_dir
from tests.support.host_programs import REFERENCE

FOLDER = "AOMC_SKY_BUILDS"
"""The environment variable that names the folder; `tests/conftest.py` makes the folder and deletes it."""
APART = "-DAOMC_SKY_DECLARE_ONLY"
SANITIZED = "-g -fsanitize=address,undefined -fno-sanitize-recover=all"


def once(*commands):
    """The folder in which these commands ran; the first worker that asks runs them, and others wait for it."""
    name = hashlib.sha256(repr(commands).encode()).hexdigest()[:32]
    made = Path(os.environ[FOLDER]) / name
    with made.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not made.exists():
            unfinished = Path(tempfile.mkdtemp(dir=made.parent))
            for command in commands:
                done = subprocess.run(command, cwd=unfinished, capture_output=True, text=True, check=False)
                assert done.returncode == 0, done.stderr
            unfinished.rename(made)
    return made


def header(flags):
    """The code of the header as an object, for programs under `APART`."""
    return once(["gcc", *flags.split(), "-c", "-o", "header.o", str(include_dir() / "aomc_sky.c")]) / "header.o"


def apart(flags):
    """These flags for a program over the header, whose code was compiled before."""
    return f"{flags} {APART} {header('-O1')}"


def sanitized(name, flags="-O0"):
    """A program of `tests/reference` over the header with sanitizers; -O1 takes three times as long to compile."""
    how = f"{flags} {SANITIZED}"
    parts = [f"-I{include_dir()}", "-o", name, str(REFERENCE / f"{name}.c"), str(header(how)), "-lm"]
    return once(["gcc", *how.split(), "-DDRIVER_MAIN", APART, *parts]) / name


def fortran_flags():
    """Flags of gfortran for a program over the module, which was compiled apart, as the header was."""
    strict = ["-O1", "-Wall", "-Werror"]
    made = once(["gfortran", *strict, "-c", str(include_dir() / "aomc_sky.f90")])
    return [*strict, f"-I{made}", str(made / "aomc_sky.o"), str(header("-O1")), "-lm"]
