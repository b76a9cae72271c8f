"""Files made to hurt: refused within 200 MB and without numba or scipy, and soon."""

import pytest

from tests.support.limits import answers_within_limits

READERS = """
from aomc_sky.formats.aomc.amc import read_amc, read_difcol, read_lambbot
from aomc_sky.formats.aomc.skydist import read_skydist
readers = (read_amc, read_lambbot, read_difcol, read_skydist)
"""


HOSTILE = {
    # a gigabyte in one line and headers of 10^9 bins: tests/faults
    "many bad rows": b"400000 89 359 1\n500\n" + b"1 x 0 1.0\n" * 400_000,
    "largest header": b"2 8192 8191 2\n500 600\n1 1 0 x\n",
    "many wavelengths": b"2 1 0 300000\n" + (b"2 " * 30_000 + b"\n") * 10,
    "quarter of a million digits": b"9" * 60_000 + b"\n" + b"1e" + b"9" * 60_000 + b"\n",
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files_cost_little(name, tmp_path):
    path = tmp_path / "file.inp"
    path.write_bytes(HOSTILE[name])
    assert all(answer.startswith("E") for answer in answers_within_limits(READERS, path))
