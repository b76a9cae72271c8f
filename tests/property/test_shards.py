"""Whatever way a run is shared out and in whatever order its shards are made: the bytes and the root of one go."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from aomc_sky.engine.merge import merge_shards
from aomc_sky.engine.run import JobOptions, run_job, run_shard
from aomc_sky.formats.amc import FootprintCode
from aomc_sky.outputs.blocks.blocks import Shard
from aomc_sky.outputs.blocks.content_tree import BLOCK
from aomc_sky.source.read.scene import read_scene
from tests.support.scenes import change_config, copy_scene, run_bytes

N_BLOCKS = 4


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """One waveband with positions."""
    amc = copy_scene("document_example", tmp_path_factory.mktemp("scene"))
    change_config(amc, footprint=FootprintCode.CIRCLE, circle_diameter_m=4.0)
    return read_scene(amc, iterations=(N_BLOCKS - 1) * BLOCK + 77, wavebands=[2])


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
def test_any_division_in_any_order_ends_with_the_same_bytes(scene, source, whole, data):
    count = data.draw(st.integers(1, N_BLOCKS + 2), "shards")
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
