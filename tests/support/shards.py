"""Shards of a small run in one folder, made by the command, and what can happen to them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tests.support.fault_rows import command
from tests.support.scenes import copy_scene

N_SHARDS = 3
PHOTONS = 200_000
"""Of each of the three wavebands: four blocks, the last one short, so that shards hold 1, 1 and 2 of them."""


def shard_words(scene: Path, out: Path, k: int, *options: object) -> list[object]:
    """Arguments of the command that makes shard `k` of the run. [k from 1]"""
    words = ["run", scene, "--iterations", PHOTONS, "--threads", 1, "-q", "--out", out, "--shard", f"{k}/{N_SHARDS}"]
    return [*words, *options]


def make_shards(folder: Path, *options: object, shards: Sequence[int] = (1, 2, 3)) -> Path:
    """Make some shards of the small run in ``folder/out`` and return that."""
    scene, out = copy_scene("document_example", folder).parent, folder / "out"
    for k in shards:
        assert command(*shard_words(scene, out, k, *options)) == 0
    return out


def shard_file(out: Path, kind: str, band: int, k: int) -> Path:
    """A file of a shard. [bands and shards from 1]"""
    return out / f"{kind}-{band:04d}.k{k}-of-{N_SHARDS}.npy"


def whole_run(folder: Path, *options: object) -> Path:
    """The same run in one go, in ``folder/whole``."""
    scene, out = copy_scene("document_example", folder).parent, folder / "whole"
    assert command("run", scene, "--iterations", PHOTONS, "-q", "--out", out, *options) == 0
    return out
