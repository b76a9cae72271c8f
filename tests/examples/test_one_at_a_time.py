"""The C lines of docs/hosts.md for codes that ask for one particle at a time, compiled and called."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.shared import INPUTS, REPOSITORY

N = 10_000
HEAD = '#include <stdlib.h>\n#include "aomc_sky_embed.h"\n'

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no gcc")


class Source(ctypes.Structure):
    _fields_ = (  # as in aomc_sky_embed.h
        ("next", ctypes.c_void_p),
        ("next_double", ctypes.c_void_p),
        ("context", ctypes.c_void_p),
        ("n_photons", ctypes.c_int64),
        ("wavelength_nm", ctypes.c_double),
    )


@pytest.fixture(scope="module")
def direction_of(tmp_path_factory: pytest.TempPathFactory) -> ctypes._CFuncPtr:
    page = (REPOSITORY / "docs" / "hosts.md").read_text()
    lines = next(text for text in re.findall(r"^```c\n(.*?)^```$", page, re.M | re.S) if "direction_of" in text)
    folder: Path = tmp_path_factory.mktemp("one")
    (folder / "one.c").write_text(HEAD + lines)
    include = REPOSITORY / "src" / "aomc_sky" / "include"
    flags = ["-std=c11", "-Wall", "-Wextra", "-Werror", "-O2", "-shared", "-fPIC", f"-I{include}"]
    subprocess.run(["gcc", *flags, "-o", str(folder / "one.so"), str(folder / "one.c")], check=True)
    function = ctypes.CDLL(str(folder / "one.so")).direction_of
    function.restype = None
    function.argtypes = (ctypes.POINTER(Source), ctypes.c_int64, ctypes.POINTER(ctypes.c_double))
    return function


def test_each_photon_by_its_number(direction_of: ctypes._CFuncPtr) -> None:
    """In order, backwards and far apart, over the end of a block and up to the last photon of the band."""
    source = sky.read_scene(INPUTS / "clear_day", iterations=N).source(1)
    batch = source.photons()
    expected = np.column_stack([batch.ux, batch.uy, batch.uz])
    order = [*range(4090, 4100), *range(N - 1, N - 5, -1), 0, 8191, 8192, 1, N - 1]
    with source.c_source(0) as stream:
        given = Source(stream.address, None, stream.context, stream.n, 0.0)
        direction = (ctypes.c_double * 3)()
        for i in order:
            direction_of(ctypes.byref(given), i, direction)
            assert np.array_equal(np.float32(direction[:]), expected[i]), i
