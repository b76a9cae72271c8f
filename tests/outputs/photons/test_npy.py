"""Numpy files of photons: every row comes back, and what is no such file is refused with what to write."""

from pathlib import Path

import numpy as np
import pytest

from aomc_sky.errors import InputFileError
from aomc_sky.outputs.photons.files import BLOCK
from aomc_sky.outputs.photons.npy import read_photons_npy


@pytest.mark.parametrize("dtype", ["<f4", ">f4", "<f8", ">f8"])
@pytest.mark.parametrize("shape", [(0, 3), (7, 3), (BLOCK, 4), (2 * BLOCK + 1,), (2 * BLOCK + 1, 3)])
@pytest.mark.parametrize("order", "CF")
def test_rows_come_back(tmp_path, dtype, shape, order):
    rows = np.arange(float(np.prod(shape))).reshape(shape).astype(dtype, order=order)
    np.save(tmp_path / "x.npy", rows)
    file = read_photons_npy(tmp_path / "x.npy", n_columns=(1, 3, 4))
    blocks = list(file.blocks())
    assert file.n_photons == len(rows)
    assert all(len(block) <= BLOCK for block in blocks)
    assert np.array_equal(np.concatenate([*blocks, np.zeros((0, file.n_columns))]).reshape(shape), rows)


def test_no_regular_file(tmp_path):
    for path in (tmp_path, tmp_path / "nowhere.npy", Path("/dev/null"), Path("a\0b")):
        with pytest.raises(InputFileError, match="E901"):
            read_photons_npy(path)


@pytest.mark.parametrize("order", "CF")
def test_a_file_that_becomes_shorter(tmp_path, order):
    path = tmp_path / "x.npy"
    np.save(path, np.zeros((100, 3), order=order))
    file = read_photons_npy(path)
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(InputFileError, match="E903"):
        list(file.blocks())
