"""Shards share out blocks, every photon once, under names that tell them apart; a pool makes blocks in their order."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aomc_sky.errors import UsageError
from aomc_sky.outputs.blocks.blocks import WHOLE_RUN, ChunkPool, Shard, manifest_name, parse_shard, shard_of_manifest
from aomc_sky.outputs.blocks.content_tree import BLOCK
from aomc_sky.outputs.photons.npy import NpyWriter
from aomc_sky.source.read.scene import read_scene
from tests.support.shared import INPUTS

COUNTS = st.integers(1, 40)


@given(st.integers(0, 60 * BLOCK), COUNTS)
def test_every_photon_stands_in_one_shard(n_photons, count):
    shards = [Shard(index=k, count=count) for k in range(1, count + 1)]
    ends = [shard.photons(n_photons) for shard in shards]
    assert ends[0][0] == 0
    assert ends[-1][1] == n_photons
    assert all(one[1] == other[0] for one, other in itertools.pairwise(ends))
    assert all(end % BLOCK == 0 or end == n_photons for _, end in ends)
    spans = [span for shard in shards for span in shard.block_spans(n_photons)]
    assert spans == list(WHOLE_RUN.block_spans(n_photons))
    sizes = [end - first for first, end in (shard.blocks(n_photons) for shard in shards)]
    assert max(sizes) - min(sizes) <= 1


def test_the_rule_of_the_cut():
    """Blocks floor((k - 1) B / K) to floor(k B / K)."""
    n_photons = 10 * BLOCK + 1  # 11 blocks
    assert [Shard(index=k, count=4).blocks(n_photons) for k in (1, 2, 3, 4)] == [(0, 2), (2, 5), (5, 8), (8, 11)]
    assert Shard(index=4, count=4).photons(n_photons) == (8 * BLOCK, n_photons)
    assert Shard(index=1, count=3).photons(BLOCK) == (0, 0)
    assert Shard(index=3, count=3).photons(BLOCK) == (0, BLOCK)
    assert Shard(index=10**6, count=10**6).blocks(10**15) == (15258773804, 15258789063)


@pytest.mark.parametrize(
    ("text", "suffix"),
    [
        ("1/1", ".k1-of-1"),
        ("3/100", ".k003-of-100"),
        ("100/100", ".k100-of-100"),
        ("7/1000000", ".k0000007-of-1000000"),
    ],
)
def test_names(text, suffix):
    shard = parse_shard(text)
    assert shard.suffix == suffix
    assert str(shard) == text
    assert manifest_name(shard) == f"manifest{suffix}.json"
    assert shard_of_manifest(manifest_name(shard)) == shard


@pytest.mark.parametrize(
    "text", ["", "3", "0/4", "5/4", "-1/4", "1/0", "1/1000001", "1.5/4", "1/4/2", "a/b", "\u0661/4"]
)
def test_other_texts_are_refused(text):
    with pytest.raises(UsageError, match="k/K"):
        parse_shard(text)


@pytest.mark.parametrize(
    "name",
    ["manifest.json", "manifest.k3-of-100.json", "manifest.k0-of-4.json", "manifest.k5-of-4.json", "manifest.k1-of-4"],
)
def test_other_files_are_no_shards(name):
    assert shard_of_manifest(name) is None


def test_the_pool_keeps_order_and_memory():
    source = read_scene(INPUTS / "document_example", iterations=3 * BLOCK + 5).source(seed=3)
    with ChunkPool(source, 5) as pool:
        pieces = [(bytes(chunks[0][0]), n) for chunks, _, n in pool.chunks(2, [NpyWriter(source)])]
        assert len(pool._free) <= 5
    assert [n for _, n in pieces] == [BLOCK, BLOCK, BLOCK, 5]
    assert b"".join(data for data, _ in pieces) == source.photons(2).directions.tobytes()
