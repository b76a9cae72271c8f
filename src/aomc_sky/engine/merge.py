"""Shards of a run, gathered and joined into the files that the run makes in one go, every block checked on its way."""

from __future__ import annotations

import contextlib
import itertools
import os
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.engine.run import FORMATS, MadePhotons, finished_manifest, run_record, write_counts
from aomc_sky.engine.stored_run import require_run
from aomc_sky.errors import AomcSkyError, ForeignOutputError, OutputError, ShardError, UsageError
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.manifest import (
    ForgedManifestError,
    build_manifest,
    chosen_bands,
    head_of,
    manifest_bytes,
    read_manifest,
    read_shard_manifest,
    require_wavebands,
)
from aomc_sky.outputs.photons.files import ChunkPool, Meter, PhotonFiles, Progress
from aomc_sky.outputs.photons.leaves import BlockHashWriter, StoredBlock, compared_blocks, content_hash
from aomc_sky.outputs.photons.npy import NpyWriter
from aomc_sky.outputs.shard import BLOCK, MANIFEST, PLAN, Shard, manifest_name
from aomc_sky.outputs.statistics import BandResult, PhotonSums, band_result
from aomc_sky.source.photon_source import PhotonSource
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
        named = ", ".join(str(folder.path) for folder in folders)
        is_whole = len(folders) == 1 and folders[0].size_of(MANIFEST) is not None
        what = "holds a run that was made in one go: there is nothing to join"
        problems.append(f"{named} {what}" if is_whole else f"there are no finished shards in {named}")
    return ShardSet(plan=plans[0], shards=tuple(shards), problems=tuple(problems))


def _foreign(what: str, first: RunFolder) -> str:
    return f"{what} belongs to another run (another scene, seed or options) than {first.path / PLAN}"


def _plan(path: Path) -> Plan:
    require_run(path, "aomc-sky run --shard k/K")
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
    return [f"these shards overlap because they divide the run differently: {', and '.join(parts)}"]


def _doubles(shards: list[StoredShard]) -> list[str]:
    pairs = itertools.pairwise(shards)
    return [
        f"{one} overlaps {other}: name only one of these folders" for one, other in pairs if one.shard == other.shard
    ]


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


MAX_DAMAGES = 100
"""Damaged blocks and files after which the search for more ends."""


@dataclass(frozen=True, kw_only=True, slots=True)
class MergeResult:
    """What joining reports: the folder of the whole run, its bands and manifest, seconds, files of shards removed."""

    folder: Path
    bands: list[BandResult]
    n_shards: int
    seconds: float
    was_finished: bool
    removed: int
    manifest: dict[str, Any]


def merge_shards(
    runs: Sequence[Path],
    out: Path | None = None,
    *,
    remove_shards: bool = False,
    threads: int = 0,
    progress: Progress | None = None,
) -> MergeResult:
    """Join all shards of a run into the files of a run that was made in one go.

    Bytes are those of `run_job` with the format npy, in the manifest apart from ``run``. What the manifest says of
    the scene's files is taken from shard 1. Without `out` the folder of the shards is that of the whole run, where
    there is one only. A run that was joined before is only read again. ShardError where shards are missing, overlap,
    or are damaged, each named with the block; ForeignOutputError where they are of different runs. When something
    fails nothing half is left, nor an empty folder.
    """
    if out is None and len({path.resolve() for path in runs}) > 1:
        raise UsageError("shards of several folders need --out, the folder of the whole run")
    started = time.perf_counter()
    shard_set = gather_shards(runs)
    source, folder = PhotonSource.from_plan(shard_set.plan), RunFolder(out or runs[0])
    for stored in shard_set.shards:
        require_wavebands(stored.folder.path / manifest_name(stored.shard), stored.manifest(), source.n_bands)
    with ChunkPool(source, threads) as pool:
        manifest = _joined_before(pool, folder, progress)
        was_finished = manifest is not None
        if manifest is None:
            shard_set.require_complete()
            with folder.removed_on_failure(), folder.held(shard_set.plan, force=False):
                manifest = _join(pool, folder, shard_set, started, progress)
    removed = _remove(shard_set.plan, shard_set.shards) if remove_shards else 0
    return MergeResult(
        folder=folder.path,
        bands=[BandResult(**band) for band in manifest["bands"]],
        n_shards=len(shard_set.shards),
        seconds=time.perf_counter() - started,
        was_finished=was_finished,
        removed=removed,
        manifest=manifest,
    )


def _joined_before(pool: ChunkPool, folder: RunFolder, progress: Progress | None) -> dict[str, Any] | None:
    if folder.size_of(MANIFEST) is None:
        return None
    with folder.held(pool.source.plan, force=False):
        return finished_manifest(pool, folder, MANIFEST, read_manifest, FORMATS, progress)


def _join(
    pool: ChunkPool, folder: RunFolder, shard_set: ShardSet, started: float, progress: Progress | None
) -> dict[str, Any]:
    source, head = pool.source, head_of(shard_set.shards[0].manifest())
    bands = chosen_bands(source, head["options"]["scene"])
    copied = _ShardCopy(pool, folder, shard_set.shards, bands).make(progress)
    files = write_counts(folder, source, bands) | copied.files
    results = [band_result(source, band, copied.sums[band]) for band in bands]
    record = run_record(time.perf_counter() - started, 0, pool.threads) | {"shards": len(shard_set.shards)}
    record |= _scene_path(shard_set.shards[0], folder.path)
    manifest = build_manifest(head, results, content_hash(folder, source, bands), files, record)
    folder.write(MANIFEST, manifest_bytes(manifest))
    return manifest


def _scene_path(stored: StoredShard, folder: Path) -> dict[str, str]:
    """Where amc.inp stands, seen from the folder of the whole run."""
    run = stored.manifest().get("run")
    recorded = run.get("scene") if isinstance(run, dict) else None
    return {"scene": os.path.relpath(stored.folder.path / recorded, folder)} if isinstance(recorded, str) else {}


def _remove(plan: Plan, shards: Sequence[StoredShard]) -> int:
    """Remove the files of shards, each manifest last: whoever is killed here finds by it what is left to remove."""
    removed, folders = 0, {stored.folder.path.resolve(): stored.folder for stored in shards}
    for path, folder in folders.items():
        with folder.held(plan, force=False):
            for stored in (stored for stored in shards if stored.folder.path.resolve() == path):
                for name in (*stored.manifest()["files"], manifest_name(stored.shard)):
                    if folder.size_of(name) is not None:
                        folder.remove(name)
                        removed += 1
    return removed


class _ShardCopy:
    """Shards on their way into the files of the run, one waveband after the other."""

    def __init__(self, pool: ChunkPool, folder: RunFolder, shards: Sequence[StoredShard], bands: Sequence[int]) -> None:
        self._pool, self._folder, self._shards = pool, folder, shards
        writers = (NpyWriter(pool.source), BlockHashWriter(pool.source))
        self._parts = {band: [PhotonFiles(folder, writer, (band,)) for writer in writers] for band in bands}
        self._finished: list[int] = []
        self._damages: list[str] = []
        folder.require_space(sum(part.n_bytes_missing for parts in self._parts.values() for part in parts))

    def make(self, progress: Progress | None = None) -> MadePhotons:
        """Copy everything; a ShardError names every damaged block, up to `MAX_DAMAGES`, and leaves nothing."""
        try:
            return self._make(progress)
        except ShardError:
            self._withdraw()
            raise

    def _make(self, progress: Progress | None) -> MadePhotons:
        meter, sums = Meter(progress, sum(self._pool.source.n_photons(band) for band in self._parts)), {}
        for band, parts in self._parts.items():
            sums[band] = PhotonSums(self._pool.source.replicates)
            with contextlib.suppress(ShardError), contextlib.ExitStack() as stack:
                if not self._damages:
                    for part in parts:
                        stack.enter_context(part)
                self._copy_band(band, parts, sums[band], meter)
                self._refuse_damaged()  # inside, so that files of this waveband vanish
            if not self._damages:
                self._finished.append(band)
            elif len(self._damages) >= MAX_DAMAGES:
                break
        self._refuse_damaged()
        entries = self._pool.entries(part for parts in self._parts.values() for part in parts)
        return MadePhotons(files=entries, sums=sums, emitted=0)

    def _withdraw(self) -> None:
        """Remove the files that this copy finished."""
        for band in self._finished:
            for part in self._parts[band]:
                for layout in part.layouts:
                    self._folder.remove(layout.name)

    def _refuse_damaged(self) -> None:
        if self._damages:
            advice = "run each of these shards again (--shard k/K); only what is damaged is made again"
            raise ShardError(self._damages, advice)

    def _copy_band(self, band: int, parts: list[PhotonFiles], sums: PhotonSums, meter: Meter) -> None:
        for stored in self._shards:
            for block in self._blocks(stored, band):
                meter.add(block.n_photons)
                if not self._damages:
                    for part, chunks in zip(parts, (block.chunks, (memoryview(block.leaf),)), strict=True):
                        part.write(chunks)
                    sums.add(block.sums)
            if len(self._damages) >= MAX_DAMAGES:
                return

    def _blocks(self, stored: StoredShard, band: int) -> Iterator[StoredBlock]:
        """Blocks of a shard that agree with their leaves; what does not is noted."""
        source, writer = self._pool.source, NpyWriter(self._pool.source, stored.shard)
        n_photons = source.n_photons(band)
        leaves = self._leaves(stored, band)
        faults = list(_file_faults(stored, writer, band, n_photons))
        self._damages += [f"{stored}: {fault}" for fault in faults]
        if leaves is None or faults:
            return
        compared = compared_blocks(self._pool, stored.folder, writer, band, stored.shard, leaves)
        with contextlib.closing(compared) as blocks:
            for block, agrees in blocks:
                if agrees:
                    yield block
                else:
                    span = (block.start, block.start + block.n_photons)
                    self._damages.append(f"{stored}: {_block(band, span)} is damaged")

    def _leaves(self, stored: StoredShard, band: int) -> np.ndarray | None:
        writer = BlockHashWriter(self._pool.source, stored.shard)
        name = writer.names((band,))[0]
        try:
            leaves = writer.read(stored.folder, band)
            if stored.folder.sha256_of(name) == stored.manifest()["files"][name]["sha256"]:
                return leaves
        except (KeyError, OutputError):
            pass
        self._damages.append(f"{stored}: {name} is missing or damaged")
        return None


def _file_faults(stored: StoredShard, writer: NpyWriter, band: int, n_photons: int) -> Iterator[str]:
    """What is wrong with the length or the head of the files of a shard."""
    first, end = stored.shard.photons(n_photons)
    for layout, width in zip(writer.layouts((band,)), writer.widths, strict=True):
        name, head, size = layout.name, layout.head, layout.size
        n_bytes = stored.folder.size_of(name)
        if n_bytes is None:
            yield f"{name} is missing"
        elif n_bytes < size:
            photon = first + max(n_bytes - len(head), 0) // (width * writer.row_dtype.itemsize)
            start = photon // BLOCK * BLOCK
            yield f"{name} is cut after {n_bytes} of {size} bytes, in {_block(band, (start, min(start + BLOCK, end)))}"
        elif n_bytes > size:
            last = ((end - 1) // BLOCK * BLOCK, end)
            after = f" after {_block(band, last)}" if end > first else "; it holds no photons"
            yield f"{name} is {n_bytes - size} bytes too long{after}"
        elif stored.folder.head_of(name, len(head)) != head:
            yield f"{name} does not begin with the header of {end - first} photons of waveband {band + 1}"


def _block(band: int, span: tuple[int, int]) -> str:
    return f"block {span[0] // BLOCK} of waveband {band + 1} (photons {span[0]} to {span[1] - 1})"
