"""Programs over the source file in C, C++, Fortran and CUDA: how the tests build and run them."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.support.shared import REPOSITORY

EXAMPLES = REPOSITORY / "examples"
REFERENCE = REPOSITORY / "tests" / "reference"
FLAGS = "-O2 -Wall -Wextra -Werror"
QUICK = FLAGS.replace("-O2", "-O0")
"""For what other tests compile with `FLAGS`: it takes a quarter of the time."""

_OMPI = ("ALLOW_RUN_AS_ROOT", "ALLOW_RUN_AS_ROOT_CONFIRM", "MCA_rmaps_base_oversubscribe")
MPI = {f"OMPI_{name}": "1" for name in _OMPI}
"""Lets Open MPI start more ranks than there are cores, and for root, as in a container."""


def needs(*commands):
    """Skip a test where one of the commands is not installed, and say which."""
    missing = [command for command in commands if shutil.which(command) is None]
    return pytest.mark.skipif(bool(missing), reason=f"{' and '.join(missing)} not installed")


needs_host = needs("gcc", "make")


def _built(_folder, names):
    """Programs and objects among the files of an example."""
    return [name for name in names if name != "Makefile" and Path(name).suffix in ("", ".o", ".mod", ".ptx")]


def copied(example, folder):
    for name in {"c", example}:
        shutil.copytree(EXAMPLES / name, folder / name, ignore=_built, dirs_exist_ok=True)
    return folder / example


def make(folder, *targets, flags=FLAGS):
    """Run make in a copy of an example, with the Python that runs the tests; warnings are errors."""
    command = ["make", f"AOMC_SKY={sys.executable} -m aomc_sky", f"CFLAGS={flags}", f"FFLAGS={flags}", *targets]
    run(command, folder)


def run(command, folder, **environment):
    """Run a command in a folder and return its output; a failure shows what it said."""
    done = subprocess.run(
        command, cwd=folder, env={**os.environ, **environment}, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, f"{' '.join(command)} ended with {done.returncode}:\n{done.stdout}\n{done.stderr}"
    return done.stdout


def bits_of(batch):
    """One number of the bits of all photons, as examples/c/example.h has it."""
    x, y, z = (u.view(np.uint32).astype(np.uint64) for u in (batch.ux, batch.uy, batch.uz))
    word = x ^ y << np.uint64(16) ^ z << np.uint64(32)
    turn = np.arange(word.size, dtype=np.uint64) % np.uint64(63) + np.uint64(1)
    return int(np.bitwise_xor.reduce(word << turn | word >> (np.uint64(64) - turn)))


def report_of(source):
    """What every example prints of a source: a line for each waveband."""
    lines = []
    for band in range(source.n_bands):
        batch, nm = source.photons(band), source.plan.bands[band].wavelength_nm
        mean = -batch.uz.mean(dtype=float) if batch.uz.size else 0.0
        lines.append(f"{nm:8g} nm {batch.uz.size:12d} photons, mean cosine {mean:.6f}, bits {bits_of(batch):016x}\n")
    return "".join(lines)
