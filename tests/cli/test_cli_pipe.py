"""``run --format raw --out - | host``: what comes through the pipe of the system are the very photons."""

import subprocess
import sys

import numpy as np
import pytest

from aomc_sky import read_scene


def piped(amc, *words):
    command = [sys.executable, "-m", "aomc_sky", "run", str(amc), "--format", "raw", "--out", "-", *words]
    done = subprocess.run(command, capture_output=True, timeout=120, check=True)
    return np.frombuffer(done.stdout, "<f4"), done.stderr.decode()


@pytest.mark.parametrize("threads", [1, 3])
def test_another_program_reads_the_photons(amc, threads):
    found, said = piped(amc, "--iterations", "2e5", "--seed", "7", "--threads", str(threads))
    source = read_scene(amc, iterations=200_000).source(7)
    expected = np.concatenate([source.photons(band).directions for band in range(source.n_bands)])
    np.testing.assert_array_equal(found.reshape(-1, 3), expected)
    assert len(expected) == 600_000
    assert f", {threads} thread{'s' * (threads > 1)}, " in said
