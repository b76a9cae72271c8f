"""counts.csv and counts.npz: a line for every patch with mass."""

import io

import numpy as np
import pytest

from aomc_sky.outputs import counts
from aomc_sky.source.read.scene import read_scene
from tests.support.shared import INPUTS


@pytest.fixture(scope="module")
def dense():
    return read_scene(INPUTS / "clear_day").source()


def test_columns_and_bounds_of_counts_csv():
    source = read_scene(INPUTS / "document_example", iterations=1000, wavebands=[1, 3]).source(seed=3)
    lines = counts.counts_file(source)[1].decode().splitlines()
    assert lines[0] == counts.COLUMNS
    first = lines[1].split(",")
    assert first[:1] + first[3:10] == ["1", "sky", "1", "0", "0.0", "45.0", "0.0", "120.0"]
    assert {line.split(",")[0] for line in lines[1:]} == {"1", "3"}
    assert len(lines) - 1 == sum(np.count_nonzero(source.mass(band)) for band in (0, 2))
    beam = read_scene(INPUTS / "beam_only", wavebands=[1]).source()
    rows = [line.split(",") for line in counts.counts_file(beam)[1].decode().splitlines()[1:]]
    assert [row[3:10] for row in rows] == [["direct", "", "", "", "", "", ""]]
    assert rows[0][2] == ""
    assert int(rows[0][-1]) == beam.n_photons(0)


def test_a_large_table_becomes_npz(dense, monkeypatch):
    monkeypatch.setattr(counts, "MAX_CSV_ROWS", 1000)
    name, data = counts.counts_file(dense)
    assert name == "counts.npz"
    with np.load(io.BytesIO(data), allow_pickle=False) as stored:
        assert np.array_equal(stored["photons"], dense.counts)
        assert np.array_equal(stored["mass"][0], dense.mass(0))
        assert stored["waveband"].tolist() == [1, 2, 3]
        assert stored["cell"].size == dense.plan.n_cells
