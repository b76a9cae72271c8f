"""In whatever order shards or ranges of a run are made, and by whom: the bytes of one go; what is damaged is found."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from aomc_sky.engine.cluster import block_ranges, finish_band, make_range
from aomc_sky.engine.merge import merge_shards
from aomc_sky.engine.run import JobOptions, run_job, run_shard
from aomc_sky.errors import OutputError
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.photons.npy import NpyParts, word_sum
from aomc_sky.outputs.shard import BLOCK, Shard
from aomc_sky.source.read.scene import read_scene
from tests.support.scenes import run_bytes, scene_with_circle

BAND = 1
FILES = ("photons-0002.npy", "positions-0002.npy", "blocks-0002.npy")


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """One waveband with positions, whose rows are not whole words of 64 bits in the last block."""
    amc = scene_with_circle(tmp_path_factory.mktemp("scene"))
    return read_scene(amc, iterations=4 * BLOCK + 77, wavebands=[BAND + 1])


@pytest.fixture(scope="module")
def source(scene):
    return scene.source(seed=11, replicates=3)


@pytest.fixture(scope="module")
def whole(scene, source, tmp_path_factory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("whole")
    run_job(source, scene, folder, JobOptions(threads=1))
    return run_bytes(folder)


@settings(max_examples=5, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_any_division_into_shards_in_any_order_ends_with_the_same_bytes(scene, source, whole, data):
    count = data.draw(st.integers(1, 6), "shards")
    order = data.draw(st.permutations(range(1, count + 1)), "order")
    n_folders = data.draw(st.integers(1, 3), "folders")
    with tempfile.TemporaryDirectory() as base:
        runs = [Path(base) / f"part{i % n_folders}" for i in range(count)]
        for run, index in zip(runs, order, strict=True):
            threads = data.draw(st.integers(1, 5), "threads")
            run_shard(source, scene, run, JobOptions(threads=threads), Shard(index=index, count=count))
        out = Path(base) / "whole"
        result = merge_shards(runs, out, threads=data.draw(st.integers(1, 5), "threads of merge"))
        assert run_bytes(out) == whole
        assert result.n_shards == count


@pytest.fixture
def ranges(source, monkeypatch):
    monkeypatch.setattr("aomc_sky.engine.cluster.RANGE_PHOTONS", BLOCK)
    found = block_ranges(source, [BAND])[BAND]
    assert len(found) == 5
    return found


def claimed(source, path: Path) -> RunFolder:
    """A folder whose files are reserved."""
    folder = RunFolder(path)
    folder.claim(source.plan, force=False)
    NpyParts(source).reserve(folder, BAND)
    return folder


def sealed(source, folder: RunFolder, made) -> dict[str, bytes]:
    """Bytes of the files of a waveband, once they have their names."""
    entries = finish_band(source, folder, [(part.block_range, part.word_sum) for part in made])
    assert set(entries) == set(FILES)
    return {name: (folder.path / name).read_bytes() for name in FILES}


@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_any_order_and_any_repetition_end_with_the_same_bytes(source, whole, ranges, data):
    order = data.draw(st.permutations(range(5)), "order")
    again = data.draw(st.lists(st.integers(0, 4), max_size=3), "made twice")
    with tempfile.TemporaryDirectory() as path:
        folder = claimed(source, Path(path))
        made = {k: make_range(source, folder, ranges[k]) for k in order}
        for k in again:
            twice = make_range(source, folder, ranges[k])
            assert (twice.emitted, twice.word_sum) == (0, made[k].word_sum)
            assert twice.sums.totals("inverse") == made[k].sums.totals("inverse")
        files = sealed(source, folder, [made[k] for k in range(5)])
        assert files == {name: whole[name] for name in FILES}
        assert sum(part.n_photons for part in made.values()) == source.n_photons(BAND)


def test_damaged_range_alone_is_made_again(source, whole, ranges, tmp_path):
    folder = claimed(source, tmp_path)
    for block_range in ranges:
        make_range(source, folder, block_range)
    with open(tmp_path / "positions-0002.npy.part", "r+b") as file:
        file.seek(-1, 2)
        file.write(b"\x00")
    made = [make_range(source, folder, block_range) for block_range in ranges]
    assert [part.emitted for part in made] == [0, 0, 0, 0, 77]
    assert sealed(source, folder, made) == {name: whole[name] for name in FILES}


@pytest.mark.parametrize("name", ["photons-0002.npy.part", "positions-0002.npy.part"])
def test_what_the_file_system_lost_is_no_photon_file(source, whole, ranges, tmp_path, name):
    folder = claimed(source, tmp_path)
    made = [make_range(source, folder, block_range) for block_range in ranges]
    with open(tmp_path / name, "r+b") as file:  # a page of the second range
        file.seek(128 + BLOCK * 12)
        file.write(bytes(4096))
    with pytest.raises(
        OutputError, match=f"photons {BLOCK} to {2 * BLOCK - 1} of waveband 2 differ from what was written"
    ):
        sealed(source, folder, made)
    assert not any((tmp_path / name).exists() for name in FILES if name.startswith("p"))
    made = [make_range(source, folder, block_range) for block_range in ranges]
    assert [part.emitted for part in made] == [0, BLOCK, 0, 0, 0]
    assert sealed(source, folder, made) == {name: whole[name] for name in FILES}


def test_file_that_became_shorter_is_found(source, ranges, tmp_path):
    folder = claimed(source, tmp_path)
    made = [make_range(source, folder, block_range) for block_range in ranges]
    with open(tmp_path / "photons-0002.npy.part", "r+b") as file:
        file.truncate(1000)
    with pytest.raises(OutputError, match="differ from what was written"):
        sealed(source, folder, made)


def test_waveband_is_sealed_twice_with_one_result(source, ranges, tmp_path):
    folder = claimed(source, tmp_path)
    made = [make_range(source, folder, block_range) for block_range in ranges]
    words = [(part.block_range, part.word_sum) for part in made]
    assert finish_band(source, folder, words) == finish_band(source, folder, words)


def test_run_by_threads_takes_the_parts_of_a_lost_cluster_away(scene, source, whole, ranges, tmp_path):
    folder = claimed(source, tmp_path)
    make_range(source, folder, ranges[0])
    assert (tmp_path / "photons-0002.npy.part").exists()
    run_job(source, scene, tmp_path, JobOptions(threads=1))
    assert run_bytes(tmp_path) == whole


def test_parts_count_as_disk_that_is_taken(source, ranges, tmp_path):
    """Sparse until photons stand in them."""
    folder, parts = claimed(source, tmp_path), NpyParts(source)
    before = parts.n_bytes_missing(folder, BAND)
    make_range(source, folder, ranges[0])
    assert 0 <= before - parts.n_bytes_missing(folder, BAND) - BLOCK * 20 < 20_000
    shutil.rmtree(tmp_path)
    assert parts.n_bytes_missing(folder, BAND) == sum(layout.size for layout in parts.layouts((BAND,)))


@given(st.binary(max_size=200).map(lambda data: data[: len(data) // 4 * 4]), st.integers(0, 24))
def test_word_sum_is_that_of_any_pieces(data, cut):
    words = np.frombuffer(data.ljust(-(-len(data) // 8) * 8, b"\0"), "<u8")
    expected = sum(words.tolist()) % (1 << 64)
    assert word_sum([data]) == expected
    assert word_sum([data[: 8 * cut], data[8 * cut :]]) == expected


@given(st.binary(min_size=8, max_size=80), st.data())
def test_word_sum_tells_any_changed_byte(data, draw):
    place, byte = draw.draw(st.integers(0, len(data) - 1)), draw.draw(st.integers(0, 255))
    changed = data[:place] + bytes([byte]) + data[place + 1 :]
    assert (word_sum([changed]) == word_sum([data])) == (changed == data)
