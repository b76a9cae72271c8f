"""gfortran as an oracle: what it reads from a file, many files in one process."""

import shutil
import struct
import subprocess
from pathlib import Path

import pytest

GFORTRAN = shutil.which("gfortran")
needs_gfortran = pytest.mark.skipif(GFORTRAN is None, reason="gfortran is not installed")

SOURCES = Path(__file__).resolve().parents[1] / "reference"


def compile_reader(name, folder):
    """Compile tests/reference/<name>.f90 into `folder` and return the program."""
    program = folder / name
    command = [GFORTRAN, "-O1", "-J", str(folder), "-o", str(program), str(SOURCES / f"{name}.f90")]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    return program


def readings(program, jobs):
    """Words that the program prints for every (letter, path); None where Fortran refuses the file."""
    text = "".join(f"{letter} {path}\n" for letter, path in jobs)
    done = subprocess.run([program], input=text, capture_output=True, text=True, timeout=60, check=True)
    lines = done.stdout.splitlines()
    assert len(lines) == len(jobs)
    return [[int(word) for word in line.split()[1:]] if line.startswith("ok") else None for line in lines]


def as_real(word):
    return struct.unpack("<d", struct.pack("<q", word))[0]
