"""``run --format raw --out - | host``: what comes through the pipe of the system are the very photons."""

import subprocess
import sys

import numpy as np
import pytest

from aomc_sky import read_scene
from aomc_sky.formats.aomc.amc import FootprintCode
from tests.support.scenes import change_config


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


def test_records_carry_positions_and_weights(amc):
    change_config(amc, footprint=FootprintCode.CIRCLE, circle_diameter_m=8.0)
    found, said = piped(amc, "--iterations", "1000", "--weights", "--waveband", "2", "-q")
    batch = read_scene(amc, iterations=1000).source(weights=True).photons(1)
    columns = [batch.ux, batch.uy, batch.uz, batch.x, batch.y, batch.weight]
    np.testing.assert_array_equal(found.reshape(1000, 6), np.column_stack(columns))
    assert np.ptp(batch.x) > 1
    assert said == ""
