"""Kernels as Python, where nothing is compiled: the whole matrix of lobes, of which a part is compiled else."""

from __future__ import annotations

import os
import subprocess
import sys

import numba
import pytest

from tests.support.shared import REPOSITORY

FILES = ("test_lobe_cells.py", "test_order.py", "test_rng.py")
_OPTIONS = ("-q", "-m", "not soak", "--tb=short", "-p", "no:xdist", "-p", "no:cacheprovider")


@pytest.mark.slow
@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="these tests run as Python themselves")
def test_the_whole_matrix():
    files = [f"tests/unit/kernels/{name}" for name in FILES]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *_OPTIONS, *files],
        cwd=REPOSITORY,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-5000:] + done.stderr[-2000:]
