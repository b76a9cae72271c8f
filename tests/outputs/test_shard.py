"""Shards: every photon stands in one. Names: all that our writers write, and no other."""

import itertools
import json
import re
from importlib import resources

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aomc_sky.errors import UsageError
from aomc_sky.outputs.photon_formats import run_formats
from aomc_sky.outputs.photons.files import BLOCK, block_spans
from aomc_sky.outputs.run_folder import is_run_file
from aomc_sky.outputs.shard import Shard, marks_among, parse_shard

IN_MANIFESTS = (
    *("plan.npz", "counts.csv", "counts.npz", "photons.mcpl", "photons-0001.npy", "photons-9999.npy"),
    *("photons-10000.npy", "photons-0001.raw", "positions-0002.npy", "weights-0003.npy"),
)
OURS = (
    *IN_MANIFESTS,
    *("manifest.json", "photons-0001.csv", "photons-0001.npy.part", "shard-003-of-100.done", "blocks-0001.npy"),
)
NOT_OURS = (
    *("", ".", "..", "/", "../victim", "../../victim", "/etc/passwd", "a/photons-0001.npy", "photons-0001.npy/"),
    *("photons-0001.npy\0", "photons-0001.npy\n", "\nphotons-0001.npy", "photons-0001.npy ", "Photons-0001.npy"),
    *("photons-001.npy", "photons-00001.npy", "photons-0001.jpg", "photons-of-my-cat.jpg", "counts.xlsx", "plan.npz~"),
    *("photons-\u0660001.npy", "photons-0001.k3-of-100.npy", "shard-1.done", "shard-1-of-x.done", "notes.txt"),
    *("counts.npy.exe", "photons-1e999.npy", "photons-0001.raw.part"),
)


def test_names_are_those_that_writers_write():
    assert [name for name in OURS if not is_run_file(name)] == []
    assert [name for name in NOT_OURS if is_run_file(name)] == []
    assert is_run_file(Shard(index=7, count=1_000_000).mark)


def schema_entry(*path):
    found = json.loads((resources.files("aomc_sky.outputs") / "manifest.schema.json").read_text())
    for key in path:
        found = found["properties"][key] if key in found.get("properties", {}) else found[key]
    return found


def test_the_schema_allows_the_files_and_formats_of_a_run_and_no_other_folder():
    pattern = schema_entry("files", "propertyNames", "pattern")
    refused = {name for name in (*OURS, *NOT_OURS) if not re.search(pattern[:-1] + r"\Z", name)}
    assert not refused & {*IN_MANIFESTS}
    assert {name for name in NOT_OURS if "/" in name or name.startswith(".") or not name.isprintable()} <= refused
    assert {"", "manifest.json", "photons-0001.npy.part", "shard-003-of-100.done", "Photons-0001.npy"} <= refused
    pattern = schema_entry("options", "formats", "items", "pattern")
    assert all(re.search(pattern, name) for name in (*run_formats(), "none"))


@given(st.lists(st.integers(0, 20 * BLOCK), min_size=1, max_size=5), st.integers(1, 40))
def test_every_photon_stands_in_one_shard(n_photons, count):
    shards = [Shard(index=k, count=count).ranges(n_photons) for k in range(1, count + 1)]
    for band, n in enumerate(n_photons):
        spans = [(first, end) for ranges in shards for k, first, end in ranges if k == band]
        assert sum(end - first for first, end in spans) == n
        assert all(one[1] == other[0] for one, other in itertools.pairwise(spans))
        assert all(first % BLOCK == 0 and first < end for first, end in spans)
    sizes = [sum(-(-(end - first) // BLOCK) for _, first, end in ranges) for ranges in shards]
    assert max(sizes) - min(sizes) <= 1


def test_the_rule_of_the_cut():
    """Blocks floor((k - 1) B / K) to floor(k B / K) of those of all wavebands in one row."""
    n_photons = [3 * BLOCK, 0, 7 * BLOCK + 1]  # 11 blocks
    ranges = [Shard(index=k, count=4).ranges(n_photons) for k in (1, 2, 3, 4)]
    assert ranges[0] == [(0, 0, 2 * BLOCK)]
    assert ranges[1] == [(0, 2 * BLOCK, 3 * BLOCK), (2, 0, 2 * BLOCK)]
    assert ranges[2] == [(2, 2 * BLOCK, 5 * BLOCK)]
    assert ranges[3] == [(2, 5 * BLOCK, 7 * BLOCK + 1)]
    assert Shard(index=1, count=3).ranges([BLOCK]) == []
    assert Shard(index=3, count=3).ranges([BLOCK]) == [(0, 0, BLOCK)]
    assert list(block_spans(BLOCK, 2 * BLOCK + 5)) == [(BLOCK, 2 * BLOCK), (2 * BLOCK, 2 * BLOCK + 5)]


def test_blocks_fill_whole_pages():
    """NFS clients that write into one page lose bytes of each other."""
    assert all(BLOCK * size * width % 4096 == 0 for size in (4, 8) for width in (1, 2, 3))


def test_marks_and_names_that_are_none():
    marks = {"1/1": "1-of-1", "3/100": "003-of-100", "7/1000000": "0000007-of-1000000"}
    for text, numbers in marks.items():
        shard, mark = parse_shard(text), f"shard-{numbers}.done"
        assert (shard.mark, str(shard)) == (mark, text)
        assert marks_among([mark, "notes.txt"]) == [shard]
        assert marks_among([mark], shard.count + 1) == []
    names = ["shard-3-of-100.done", "shard-000-of-100.done", "shard-101-of-100.done", "shard-2-of-3.done.x"]
    assert marks_among(names) == []
    kept = marks_among(["shard-2-of-3.done", "shard-1-of-3.done", "shard-1-of-2.done"], 3)
    assert kept == [Shard(index=1, count=3), Shard(index=2, count=3)]


@pytest.mark.parametrize(
    "text", ["", "3", "0/4", "5/4", "-1/4", "1/0", "1/1000001", "1.5/4", "1/4/2", "a/b", "\u0661/4"]
)
def test_other_texts_are_refused(text):
    with pytest.raises(UsageError, match="k/K"):
        parse_shard(text)
