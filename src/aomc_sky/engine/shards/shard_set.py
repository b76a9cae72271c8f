"""The shards of one run, gathered from their folders: of one plan, all there, none twice."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aomc_sky.errors import AomcSkyError, ForeignOutputError, ShardError
from aomc_sky.formats.text_file import refuse
from aomc_sky.outputs.blocks.shard import Shard, manifest_name
from aomc_sky.outputs.folder.run_folder import PLAN, RunFolder
from aomc_sky.outputs.manifest.file import ForgedManifestError
from aomc_sky.outputs.manifest.shard import read_shard_manifest
from aomc_sky.source.plan.plan import Plan


@dataclass(frozen=True, kw_only=True, slots=True)
class StoredShard:
    """A finished shard and its folder."""

    shard: Shard
    folder: RunFolder

    def manifest(self) -> dict[str, Any]:
        """Its manifest, read now: a million of them are not kept."""
        return read_shard_manifest(self.folder.path / manifest_name(self.shard), self.shard)

    def __str__(self) -> str:
        return f"shard {self.shard} in {self.folder.path}"


@dataclass(frozen=True, kw_only=True, slots=True)
class ShardSet:
    """What was found in some folders."""

    plan: Plan  #: that of all folders
    shards: tuple[StoredShard, ...]  #: in the order of their numbers
    problems: tuple[str, ...]  #: why they do not make a run, one sentence each; empty where they do

    def require_complete(self) -> None:
        """Raise a ShardError unless these are all shards of one division of the run, each once."""
        if self.problems:
            raise ShardError(self.problems)


def gather_shards(runs: Sequence[Path]) -> ShardSet:
    """Look for finished shards in folders that `run_shard` wrote.

    ForeignOutputError where two folders or shards are of different runs.
    """
    folders = list({path.resolve(): RunFolder(path) for path in runs}.values())
    plans = [_plan(folder.path) for folder in folders]
    for folder, plan in zip(folders, plans, strict=True):
        if plan.sha256 != plans[0].sha256:
            raise ForeignOutputError(_foreign(str(folder.path), folders[0]))
    plan_sha256 = plans[0].sha256  # of a large plan it takes a while
    shards: list[StoredShard] = []
    problems: list[str] = []
    for folder in folders:
        for shard in folder.finished_shards():
            _add(folder, shard, plan_sha256, shards, problems)
    shards.sort(key=lambda stored: (stored.shard.count, stored.shard.index))
    problems += [*_divisions(shards), *_doubles(shards), *_missing(shards)]
    if not shards and not problems:
        problems.append(f"there are no finished shards in {', '.join(str(folder.path) for folder in folders)}")
    return ShardSet(plan=plans[0], shards=tuple(shards), problems=tuple(problems))


def _foreign(what: str, first: RunFolder) -> str:
    return f"{what} belongs to another run (another scene, seed or options) than {first.path / PLAN}"


def _plan(path: Path) -> Plan:
    if not path.is_dir():
        raise refuse(path, "there is no such folder", advice="name a folder that `aomc-sky run --shard` wrote")
    RunFolder(path).require_regular_files()
    if not (path / PLAN).is_file():
        advice = "name a folder that `aomc-sky run --shard` wrote"
        raise refuse(path, f"this folder holds no {PLAN}, so it holds no shards of a run", advice=advice)
    return Plan.load(path / PLAN)


def _add(folder: RunFolder, shard: Shard, expected: str, shards: list[StoredShard], problems: list[str]) -> None:
    stored = StoredShard(shard=shard, folder=folder)
    try:
        plan_sha256 = stored.manifest()["plan_sha256"]
    except ForgedManifestError:
        raise
    except AomcSkyError as error:
        problems.append(f"shard {shard}: {error}")
        return
    if plan_sha256 != expected:
        raise ForeignOutputError(_foreign(f"shard {shard} in {folder.path}", folder))
    shards.append(stored)


def _divisions(shards: list[StoredShard]) -> list[str]:
    counts = sorted({stored.shard.count for stored in shards})
    if len(counts) < 2:
        return []
    parts = (f"{_ranges(s.shard.index for s in shards if s.shard.count == count)} of {count}" for count in counts)
    return [f"these shards overlap, for they divide the run differently: {', and '.join(parts)}"]


def _doubles(shards: list[StoredShard]) -> list[str]:
    pairs = itertools.pairwise(shards)
    return [f"{one} overlaps {other}: give one of the folders" for one, other in pairs if one.shard == other.shard]


def _missing(shards: list[StoredShard]) -> list[str]:
    counts = {stored.shard.count for stored in shards}
    if len(counts) != 1:
        return []
    present = {stored.shard.index for stored in shards}
    gone = [k for k in range(1, shards[0].shard.count + 1) if k not in present]
    if not gone:
        return []
    count, first = shards[0].shard.count, f"run it with --shard {gone[0]}/{shards[0].shard.count}"
    if len(gone) == 1:
        return [f"shard {gone[0]}/{count} is missing or unfinished; {first}"]
    return [f"shards {_ranges(gone)} of {count} are missing or unfinished; {first} and so on"]


def _ranges(numbers: Iterable[int]) -> str:
    """Numbers for a person: ``1 to 3, 7``; no more than ten pieces."""
    pieces: list[list[int]] = []
    for number in sorted(set(numbers)):
        if pieces and number == pieces[-1][1] + 1:
            pieces[-1][1] = number
        else:
            pieces.append([number, number])
    texts = [str(a) if a == b else f"{a} to {b}" for a, b in pieces]
    return ", ".join(texts[:10]) + (" ..." if len(texts) > 10 else "")
