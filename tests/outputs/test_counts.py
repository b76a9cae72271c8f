"""counts.csv and counts.npz: a line for every patch with mass."""

import io

import numpy as np
import pytest

from aomc_sky import read_scene, write_run
from aomc_sky.outputs import counts
from tests.support.shared import INPUTS

VERSION_1 = (
    "waveband,wavelength_nm,sky_wavelength_nm,component,zenith_index,azimuth_index,"
    "zenith_lo_deg,zenith_hi_deg,azimuth_lo_deg,azimuth_hi_deg,mass,expected,photons"
)
"""Columns of release 0.4.0, whose runs pass `verify`."""


def test_columns_and_bounds_of_counts_csv():
    source = read_scene(INPUTS / "document_example", iterations=1000, wavebands=[1, 3]).source(seed=3)
    lines = counts.counts_file(source)[1].decode().splitlines()
    assert lines[0] == VERSION_1
    assert counts.table_version(VERSION_1.encode()) == 1
    first = lines[1].split(",")
    assert first[:1] + first[3:10] == ["1", "sky", "1", "0", "0.0", "45.0", "0.0", "120.0"]
    assert {line.split(",")[0] for line in lines[1:]} == {"1", "3"}
    assert len(lines) - 1 == sum(np.count_nonzero(source.mass(band)) for band in (0, 2))
    beam = read_scene(INPUTS / "beam_only", wavebands=[1]).source()
    rows = [line.split(",") for line in counts.counts_file(beam)[1].decode().splitlines()[1:]]
    assert [row[3:10] for row in rows] == [["direct", "", "", "", "", "", ""]]
    assert rows[0][2] == ""
    assert int(rows[0][-1]) == beam.n_photons(0)


def test_a_large_table_becomes_npz(monkeypatch):
    dense = read_scene(INPUTS / "clear_day").source()
    monkeypatch.setattr(counts, "MAX_CSV_ROWS", 1000)
    name, data = counts.counts_file(dense)
    assert name == "counts.npz"
    with np.load(io.BytesIO(data), allow_pickle=False) as stored:
        assert np.array_equal(stored["photons"], dense.counts)
        assert np.array_equal(stored["mass"][0], dense.mass(0))
        assert stored["waveband"].tolist() == [1, 2, 3]
        assert stored["cell"].size == dense.plan.n_cells


@pytest.fixture(params=[7, 13], ids=["inside", "last"])
def old_run(request, tmp_path, monkeypatch):
    """A run that was written before a column came into the table."""
    scene = read_scene(INPUTS / "document_example", iterations=1000)
    write_run(scene, tmp_path, formats="npy")
    made, at = counts.counts_csv, request.param
    columns = [(name, 1) for name in VERSION_1.split(",")]

    def with_column(*arguments):
        lines = [line.split(",") for line in made(*arguments).decode().splitlines()]
        rows = [lines[0], *([*line[:at], repr(k / 7), *line[at:]] for k, line in enumerate(lines[1:]))]
        return "".join(",".join(row) + "\n" for row in rows).encode()

    monkeypatch.setattr(counts, "COLUMNS", dict([*columns[:at], ("new", 2), *columns[at:]]))
    monkeypatch.setattr(counts, "counts_csv", with_column)
    return scene, tmp_path


def test_an_older_table_is_compared_by_its_own_columns(old_run, told):
    scene, folder = old_run
    before = {path.name: path.stat().st_mtime_ns for path in folder.iterdir()}
    assert "counts.csv, an older table (version 1), agrees with the plan" in told("verify", folder).out
    write_run(scene, folder, formats="npy")  # it is finished: nothing is made again
    assert {path.name: path.stat().st_mtime_ns for path in folder.iterdir()} == before
    write_run(scene, folder, formats="npy", force=True)
    assert counts.table_version((folder / "counts.csv").read_bytes()) == 2
    assert "older" not in told("verify", folder).out


CHANGES = {
    "a value": ("0.0,45.0,0.0,120.0,", "0.0,45.0,0.0,121.0,", 2),
    "a name": (",photons\n", ",photon\n", 1),
    "a column more": (",photons\n", ",photons,other\n", 1),
    "a column less": (",expected,photons\n", ",photons\n", 1),
    "another order": ("waveband,wavelength_nm,", "wavelength_nm,waveband,", 1),
}


def test_a_false_value_column_or_line_of_an_older_table_is_found(old_run, told):
    path = old_run[1] / "counts.csv"
    text = path.read_text()
    for name, (old, new, line) in CHANGES.items():
        assert old in text, name
        path.write_text(text.replace(old, new, 1))
        said = told("verify", old_run[1], "--resample", 0, code=1).out
        assert f"counts.csv differs from the plan, from line {line} on" in said, name
    path.write_text("".join(text.splitlines(keepends=True)[:-1]))
    assert "counts.csv differs from the plan" in told("verify", old_run[1], code=1).out
