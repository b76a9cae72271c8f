"""Shards: every photon stands in one. Names: all that our writers write, nothing that a manifest leads astray with."""

from __future__ import annotations

import itertools
import json
import re
from importlib import resources

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aomc_sky.errors import UsageError
from aomc_sky.outputs.photons.files import PHOTON_FORMATS, photon_writer
from aomc_sky.outputs.photons.leaves import BlockHashWriter
from aomc_sky.outputs.photons.npy import NpyParts, NpyWriter
from aomc_sky.outputs.shard import (
    BLOCK,
    WHOLE_RUN,
    Shard,
    is_run_file,
    is_temporary_file,
    manifest_name,
    parse_shard,
    removal_order,
    shard_of_file,
    shard_of_manifest,
)
from aomc_sky.source.read.scene import read_scene
from tests.support.shared import INPUTS

SHARDS = (Shard(index=1, count=1), Shard(index=3, count=100), Shard(index=1_000_000, count=1_000_000))
OURS = (
    *("plan.npz", "manifest.json", "counts.csv", "counts.npz", "photons.mcpl", "photons-0001.npy", "photons-9999.npy"),
    *("photons-10000.npy", "photons-0001.raw", "photons-0001.csv", "positions-0002.npy", "weights-0003.npy"),
    *("blocks-0001.npy", "photons-0001.npy.part", "blocks-0001.part2-of-3.npy", "photons-0001.k003-of-100.npy"),
    *("manifest.k1-of-1.json", "manifest.k003-of-100.json", "blocks-0001.k1-of-2.npy"),
)
NOT_OURS = (
    *("", ".", "..", "/", "../victim", "../../victim", "/etc/passwd", "a/photons-0001.npy", "photons-0001.npy/"),
    *("photons-0001.npy\0", "photons-0001.npy\n", "\nphotons-0001.npy", "photons-0001.npy ", "Photons-0001.npy"),
    *("photons-001.npy", "photons-00001.npy", "photons-0001.jpg", "photons-of-my-cat.jpg", "counts.xlsx", "plan.npz~"),
    *("photons-\u0660001.npy", "photons-0001.k3-of-100.npy", "photons-0001.k0-of-3.npy", "photons-0001.k4-of-3.npy"),
    *("manifest.k1-of-2.npy", "blocks-0001.k1-of-2.json", "photons-0001.part1-of-2.npy", "manifest.part1-of-2.json"),
    *("manifest.k1-of-0.json", "photons-0001.k1-of-1000001.npy", "counts.npy.exe", "photons-1e999.npy", "notes.txt"),
)


@pytest.mark.parametrize("name", OURS)
def test_names_of_ours(name):
    assert is_run_file(name)


@pytest.mark.parametrize("name", NOT_OURS, ids=ascii)
def test_names_of_others(name):
    assert not is_run_file(name)


def test_everything_that_writers_write_is_known():
    source = read_scene(INPUTS / "document_example", iterations=10).source(seed=1)
    written = [name for key in PHOTON_FORMATS for name in photon_writer(key)(source).names((0,))]
    written += [*NpyParts(source).names((0,)), *BlockHashWriter(source).names((2,)), "blocks-11112.npy"]
    assert [name for name in written if shard_of_file(name) != WHOLE_RUN] == []
    for shard in SHARDS:
        names = (
            *NpyWriter(source, shard).names((0,)),
            *BlockHashWriter(source, shard).names((0,)),
            manifest_name(shard),
        )
        assert [name for name in names if shard_of_file(name) != shard] == []
    part = Shard(index=2, count=30, mark="part")
    assert shard_of_file(BlockHashWriter(source, part).names((0,))[0]) == part


def test_names_that_the_schemas_allow_are_known():
    """The published pattern and the function agree on every name above."""
    for schema, shards in (("manifest", False), ("shard_manifest", True)):
        text = (resources.files("aomc_sky.outputs") / f"{schema}.schema.json").read_text()
        pattern = json.loads(text)["properties"]["files"]["propertyNames"]["pattern"]
        allowed = {name for name in (*OURS, *NOT_OURS) if re.search(pattern[:-1] + r"\Z", name)}
        assert allowed - set(OURS) <= {"photons-0001.k3-of-100.npy", "photons-0001.k0-of-3.npy", *_beyond()}
        assert {"k" in name for name in allowed if name.startswith("photons-")} == {shards}


def _beyond() -> set[str]:
    """Numbers that a pattern cannot compare; `shard_of_file` does."""
    return {"photons-0001.k4-of-3.npy", "photons-0001.k1-of-1000001.npy"}


@pytest.mark.parametrize(("name", "is_one"), [
    (".aomc-sky-counts.csv.0123abcd", True), (".aomc-sky-photons-0001.npy.dead", True), (".aomc-sky-", False),
    (".aomc-sky-notes", False), (".aomc-sky-a.B0b0", False), ("aomc-sky-a.0123abcd", False),
])  # fmt: skip
def test_temporary_names(name, is_one):
    assert is_temporary_file(name) == is_one


def test_manifests_go_first_and_the_plan_last():
    names = sorted(("plan.npz", "photons-0001.npy", "manifest.k1-of-2.json", "blocks-0001.npy"), key=removal_order)
    assert names == ["manifest.k1-of-2.json", "blocks-0001.npy", "photons-0001.npy", "plan.npz"]


@given(st.integers(0, 60 * BLOCK), st.integers(1, 40))
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
