"""``run --format raw --out - | host``: a program in C at the other end reads the very photons."""

import shutil
import subprocess
import sys

import numpy as np
import pytest

from aomc_sky import read_scene
from tests.support.scenes import copy_scene
from tests.support.shared import REPOSITORY

GCC = shutil.which("gcc")
pytestmark = [
    pytest.mark.skipif(GCC is None, reason="gcc is not installed"),
    pytest.mark.skipif(sys.byteorder != "little", reason="the program reads numbers in the machine's own order"),
]


@pytest.fixture(scope="module")
def host(tmp_path_factory):
    program = tmp_path_factory.mktemp("host") / "read_records"
    source = REPOSITORY / "tests" / "reference" / "read_records.c"
    command = [GCC, "-std=c99", "-O2", "-Wall", "-Werror", "-o", str(program), str(source), "-lm"]
    subprocess.run(command, check=True, timeout=60)
    return program


def piped(host, amc, n_columns, *words):
    """What the host found at its end, the pipe being the operating system's own."""
    command = [sys.executable, "-m", "aomc_sky", "run", str(amc), "--format", "raw", "--out", "-", "-q", *words]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as source:
        found = subprocess.run(
            [host, str(n_columns)], stdin=source.stdout, capture_output=True, timeout=120, check=True
        )
    assert source.returncode == 0
    n, total, weighted, largest_uz, distance = found.stdout.split()
    return int(n), int(total), int(weighted), float(largest_uz), float(distance)


def sums(records):
    words = np.ascontiguousarray(records, dtype="<f4").view(np.uint32).ravel().astype(np.uint64)
    place = np.arange(1, words.size + 1, dtype=np.uint64)
    return int(words.sum(dtype=np.uint64)), int((place * words).sum(dtype=np.uint64))


def test_a_program_in_c_reads_the_photons(host, tmp_path):
    amc = copy_scene("document_example", tmp_path)
    n, total, weighted, largest_uz, distance = piped(host, amc, 3, "--iterations", "2e5", "--seed", "7")
    source = read_scene(amc, iterations=200_000).source(7)
    records = np.concatenate([source.photons(band).directions for band in range(source.n_bands)])
    assert n == len(records) == 600_000
    assert (total, weighted) == sums(records)
    assert np.float32(largest_uz) == records[:, 2].max() < 0
    assert distance < 3e-7


def test_records_carry_positions_and_weights(host, tmp_path):
    amc = copy_scene("document_example", tmp_path)
    lines = amc.read_text().splitlines()
    assert lines[21].startswith("15)Light source: point")
    lines[21] = f"{lines[21][:48]}2"
    lines[22] = f"{lines[22][:48]}8.0"
    amc.write_text("\n".join([*lines, ""]))
    n, total, weighted, _, _ = piped(host, amc, 6, "--iterations", "1000", "--weights", "--waveband", "2")
    batch = read_scene(amc, iterations=1000).source(weights=True).photons(1)
    records = np.column_stack([batch.ux, batch.uy, batch.uz, batch.x, batch.y, batch.weight])
    assert n == 1000
    assert (total, weighted) == sums(records)


def test_the_report_counts_the_threads(tmp_path):
    amc = copy_scene("document_example", tmp_path)
    words = ["run", str(amc), "--iterations", "100", "--format", "raw", "--out", "-", "--threads", "1"]
    answer = subprocess.run([sys.executable, "-m", "aomc_sky", *words], capture_output=True, timeout=60, check=True)
    assert len(answer.stdout) == 3 * 100 * 12
    assert ", 1 thread, " in answer.stderr.decode()
